"""The command line `sphecs`, also as `python -m sphecs`."""

import signal
import sys

from . import _sphecs


def main() -> int:
    """Runs the command line of the process and returns its exit code."""
    # The engine finishes a step and closes its files on Ctrl-C; Python's handler would raise an exception afterwards.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _sphecs.command_line(["sphecs", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())

"""Short version of scripts/reliability/failpoints.py: kills and full disks at some of the calls that change a file."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import binary

DRIVER = Path(__file__).resolve().parents[2] / "scripts/reliability/failpoints.py"


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the shim needs the Linux loader")
def test_kills_and_full_disks_cost_nothing():
    assert shutil.which("cc"), "needs a C compiler"
    command = [sys.executable, DRIVER, "--every", "149", "--full", "8", "--sphecs", binary()]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "no byte differs" in done.stdout

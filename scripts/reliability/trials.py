"""Functions shared by the scripts of this folder: running the program and comparing run folders."""

import filecmp
import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RESULTS = [f"{name}.nc" for name in ("particles", "monitor", "probes", "forces")]
RESULTS += ["monitor.csv", "forces.csv", "probes_points.csv"]
SCENES = sorted((ROOT / "scenes").glob("*.ron"))
QUICK = ROOT / "scenes/quickstart.ron"


def fail(message):
    """Ends the script with a message, at the first failure."""
    sys.exit(f"FAILED: {message}")


def ends(program, arguments, code=0, what="", environment=None):
    """Runs the program and returns its output. Fails unless its exit code is `code`."""
    command = [str(program), *map(str, arguments)]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    if code is not None and done.returncode != code:
        fail(f"{what}: `{' '.join(command)}` ended with {done.returncode}, not {code}\n{done.stdout}{done.stderr}")
    return done


def same(whole, other, what):
    """Fails unless two run folders have identical results, byte by byte, and the second has no temporary files."""
    probes = {path.relative_to(run).as_posix() for run in (whole, other) for path in run.glob("probes/*.csv")}
    for name in [*RESULTS, *sorted(probes)]:
        if (whole / name).exists() != (other / name).exists():
            fail(f"{what}: {name} exists in one of the two folders only")
        if (whole / name).exists() and not filecmp.cmp(whole / name, other / name, shallow=False):
            fail(f"{what}: {name} differs")
    strays = [path for pattern in ("*.partial", "journal*", ".probe*") for path in other.rglob(pattern)]
    strays += list(other.parent.glob(f".{other.name}.*"))
    if strays:
        fail(f"{what}: left over: {strays}")


def summary(folder):
    """Returns the summary of a run."""
    return json.loads((folder / "summary.json").read_text())

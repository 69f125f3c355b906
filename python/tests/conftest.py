"""Fixtures: one small run for all tests."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))


def binary():
    """Returns the absolute path of the program under test: `$SPHECS`, or the latest build of cargo."""
    if "SPHECS" in os.environ:
        return Path(os.environ["SPHECS"]).resolve()
    built = [path for kind in ("release", "debug") if (path := ROOT / "target" / kind / "sphecs").exists()]
    if not built:
        pytest.exit("no program to test: run `cargo build --release`, or set SPHECS to its path", 2)
    return max(built, key=lambda path: path.stat().st_mtime)


def sphecs(*arguments):
    """Runs the program and returns its output."""
    done = subprocess.run([binary(), *map(str, arguments)], capture_output=True, text=True, cwd=ROOT, check=False)
    assert done.returncode == 0, f"exit code {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done.stdout


@pytest.fixture(scope="session")
def run_folder(tmp_path_factory):
    """Runs 0.25 s of the quickstart scene at its smoke spacing."""
    folder = tmp_path_factory.mktemp("runs") / "quickstart"
    sphecs("run", "scenes/quickstart.ron", "--smoke", "--until", "0.25", "--out", folder, "--quiet")
    return folder

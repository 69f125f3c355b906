"""Memory: `sphecs check` is within 20 % of the measured peak, and packing takes no more than the run."""

import re
import subprocess
import sys

import pytest
from conftest import ROOT, binary, sphecs

SCENES = sorted(path.stem for path in (ROOT / "scenes").glob("*.ron"))
# At the smoke spacing the program itself takes most of it; these have up to 150 000 particles.
LARGER = [
    ("quickstart", "0.0004", "F64"),
    ("quickstart", "0.0004", "F32"),
    ("cylinder_re20", "0.1", "F64"),
    ("duct3d", "0.01", "F64"),
    ("duct3d", "0.01", "F32"),
    ("square_bend", "0.009", "F32"),
    ("square_bend", "0.009", "F64"),
]


# Runs the program and prints its largest resident memory in kB. A process that is started inherits the largest memory
# of the one that starts it, which is that of all the tests; this one imports almost nothing.
MEASURE = """
import os, subprocess, sys
child = subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL)
_, status, usage = os.wait4(child.pid, 0)
print(usage.ru_maxrss)
sys.exit(os.waitstatus_to_exitcode(status))
"""


def peak(arguments):
    """Runs the program and returns its largest resident memory, MB."""
    command = [sys.executable, "-I", "-S", "-c", MEASURE, binary(), *map(str, arguments)]
    measured = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
    return int(measured.stdout) * 1024 / 1e6


def check(scene, options, tmp_path):
    """Compares the estimate with the peak of twelve steps, which write two frames and a checkpoint."""
    text = sphecs("check", f"scenes/{scene}.ron", *options, "--no-timing")
    number, unit = re.search(r"memory +about ([0-9.]+) (MB|GB)", text).groups()
    estimate = float(number) * {"MB": 1.0, "GB": 1000.0}[unit]
    run = ["run", f"scenes/{scene}.ron", *options, "--steps", 12, "--threads", 2, "--quiet", "--out", tmp_path / "run"]
    measured = peak(run)
    assert abs(estimate / measured - 1.0) < 0.2, f"{estimate} MB estimated, {measured:.1f} MB measured"


pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the model is that of Linux")


@pytest.mark.parametrize("scene", SCENES)
def test_estimate_of_a_shipped_scene(scene, tmp_path):
    check(scene, ["--smoke"], tmp_path)


@pytest.mark.parametrize(("scene", "spacing", "precision"), LARGER)
def test_estimate_of_a_larger_run(scene, spacing, precision, tmp_path):
    check(scene, ["--set", f"spacing={spacing}", "--set", f"precision={precision}"], tmp_path)


def test_packing_takes_no_more_memory_than_the_run(tmp_path):
    """Packing a run of many frames takes as much as one of two."""
    arguments = ["run", "scenes/quickstart.ron", "--set", "spacing=0.0006", "--threads", 2, "--quiet", "--force"]
    few = peak([*arguments, "--steps", 40, "--out", tmp_path / "few"])
    many = peak([*arguments, "--steps", 40, "--set", "output.every=1e-9", "--out", tmp_path / "many"])
    assert many < 1.15 * few, f"{many:.1f} MB with 41 frames, {few:.1f} MB with 2"

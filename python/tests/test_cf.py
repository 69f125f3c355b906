"""The NetCDF files against the CF conventions, by the IOOS compliance checker with its own table of standard names."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import sphecs

CHECKER = Path(sys.executable).with_name("compliance-checker")

# Messages that are no faults of the files, with the reason.
ACCEPTED = {
    # Time is that since the start of the run. With "seconds since" an invented date, which CF wants of calendar times,
    # xarray would turn the numbers into dates.
    r"time must be in a valid units format <unit> since <epoch> not s": "elapsed time",
    r"time does not have correct time units": "elapsed time",
    r'Time coordinate variable "time" should have a string valued attribute "calendar"': "elapsed time",
    # The checker reports references that it has found, too.
    r".*: '[xyz]' found in same group": "no fault",
    # CF 2.7 scopes dimensions by group; every probe has its own `time` and `point`.
    r"Dimensions with the same name must be the same object \(ID\)\.": "groups have dimensions of their own",
}


@pytest.fixture(scope="session")
def run_with_all_files(tmp_path_factory):
    """Runs some steps of a scene with bodies, probes, means, an inlet and an outlet."""
    folder = tmp_path_factory.mktemp("cf") / "run"
    mean = ["--set", "bodies.0.mean=(0.0, 0.5)", "--set", "output.probes.0.mean=(0.0, 0.5)"]
    mean += ["--set", "output.fields=(mean: (0.0, 0.5))", "--set", "output.walls=(mean: (0.0, 0.5))"]
    output = ["--set", "output.every=0.1", "--set", "output.monitor_every=0.05"]
    sphecs("run", "scenes/cylinder_re20.ron", "--smoke", "--until", 0.5, *mean, *output, "--out", folder, "--quiet")
    sphecs("export", folder, "--tracks")
    return folder


FILES = ["particles.nc", "tracks.nc", "monitor.nc", "probes.nc", "forces.nc", "fields.nc", "walls.nc"]


@pytest.mark.parametrize("file", FILES)
def test_files_follow_cf(run_with_all_files, file, tmp_path):
    report = tmp_path / "report.json"
    command = [CHECKER, "--test=cf:1.11", "--criteria=strict", "--format=json", f"--output={report}"]
    subprocess.run([*command, run_with_all_files / file], check=False, capture_output=True)
    found = json.loads(report.read_text())["cf:1.11"]
    results = [*found["high_priorities"], *found["medium_priorities"]]
    messages = {message for result in results for message in result["msgs"]}
    faults = [text for text in messages if not any(re.fullmatch(known, text) for known in ACCEPTED)]
    assert results and not faults, "\n".join(sorted(faults))


def test_checker_finds_a_fault(run_with_all_files, tmp_path):
    """The fault of earlier versions, a fill value of the coordinate `time`, is found."""
    netCDF4 = pytest.importorskip("netCDF4")
    broken, report = tmp_path / "broken.nc", tmp_path / "report.json"
    with netCDF4.Dataset(broken, "w") as data:
        data.Conventions = "CF-1.11"
        data.createDimension("time", 1)
        time = data.createVariable("time", "f8", "time", fill_value=-1.0)
        time.units, time.standard_name = "s", "time"
        time[:] = 0.0
    subprocess.run([CHECKER, "--test=cf:1.11", "--format=json", f"--output={report}", broken], capture_output=True)
    assert "_FillValue" in report.read_text()

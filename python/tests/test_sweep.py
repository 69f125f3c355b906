"""`sphecs.open_sweep`: all runs of a sweep as one tree."""

import pytest
import sphecs
from conftest import sphecs as command

SETS = ["--set", "time.end=0.05", "--set", "output.every=0.05", "--set", "output.probes=[]", "--set", "output.fields=()"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Makes three runs of the quickstart scene."""
    folder = tmp_path_factory.mktemp("sweep") / "speeds"
    grid = ["--grid", "constants.v0=0.05,0.1", "--grid", "outlets.0.condition=WaveEquation()"]
    command("sweep", "scenes/quickstart.ron", "--smoke", *SETS, *grid, "--out", folder)
    return folder


def test_runs_are_nodes_with_their_values(folder):
    sweep = sphecs.open_sweep(folder)
    assert list(sweep.children) == ["v0-0.05_condition-WaveEquation", "v0-0.1_condition-WaveEquation"]
    slow, fast = sweep.children.values()
    assert (slow.attrs["constants.v0"], fast.attrs["constants.v0"]) == (0.05, 0.1)
    assert fast.attrs["outlets.0.condition"] == "WaveEquation()"
    assert float(fast.kinetic_energy[-1]) > float(slow.kinetic_energy[-1]) > 0


def test_any_file_is_opened_and_missing_ones_are_left_out(folder):
    grids = sphecs.open_sweep(folder, "fields.nc")
    assert {node.u.dims for node in grids.children.values()} == {("time", "y", "x")}
    assert not sphecs.open_sweep(folder, "probes.nc").children
    with pytest.raises(FileNotFoundError, match="not the folder of a sweep"):
        sphecs.open_sweep(folder.parent)

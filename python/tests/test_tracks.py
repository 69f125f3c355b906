"""Trajectories: `sphecs export --tracks` against the frames, read by xarray and TrajAn, and `.sphecs.track`."""

import subprocess
import time

import numpy as np
import pytest
import sphecs
import trajan  # noqa: F401 - adds the accessor `.traj`
import xarray as xr
from conftest import binary
from conftest import sphecs as program
from scenes import QUICKSTART

COLUMNS = ("x", "y", "u", "v", "density", "pressure", "tag")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Runs 3 s of the quickstart: the first particles have left, and their numbers have entered again."""
    folder = tmp_path_factory.mktemp("tracks") / "run"
    run = sphecs.run(QUICKSTART, smoke=True, until=3, out=folder, set={"output.fields": "None"})
    program("export", folder, "--tracks")
    return run


@pytest.fixture(scope="module")
def tracks(run):
    return xr.open_dataset(run.folder / "tracks.nc")


def samples(particles, zones=(0,)):
    """Returns number, frame and slot of every sample of `particles.nc`."""
    present = np.isin(particles.zone.values, zones)
    numbers = particles.passage.values.astype("i8") * 10**10 + particles.particle_id.values
    return numbers[present], *np.nonzero(present)


def test_file_has_every_sample_of_the_fluid_and_nothing_else(run, tracks):
    particles = run.particles
    numbers, frames, slots = samples(particles)
    trajectories, row = np.unique(numbers, return_inverse=True)
    np.testing.assert_array_equal(tracks.trajectory, trajectories)
    np.testing.assert_array_equal(tracks.time, particles.time)
    for name in COLUMNS:
        wanted = np.full((len(trajectories), particles.sizes["time"]), np.nan)
        wanted[row, frames] = particles[name].values[frames, slots]
        np.testing.assert_array_equal(tracks[name].values, wanted, err_msg=name)
        assert tracks[name].dtype == particles[name].dtype
        assert tracks[name].attrs["units"] == particles[name].attrs["units"]


def test_piece_of_fluid_is_one_trajectory(run, tracks):
    """A trajectory has samples in a row and moves no farther than the flow; a slot holds several of them."""
    assert int(tracks.passage.max()) > 0
    again = tracks.particle_id.values[tracks.passage.values > 0]
    assert np.isin(again, tracks.particle_id.values[tracks.passage.values == 0]).any(), "no number was used twice"
    present = np.isfinite(tracks.x.values)
    assert (present.sum(axis=1) > 0).all()
    # The distance between two frames, 0.05 s, at the largest speed with a margin of 50 %.
    step = np.hypot(np.diff(tracks.x, axis=1), np.diff(tracks.y, axis=1))
    speed = float(np.nanmax(np.hypot(tracks.u, tracks.v)))
    assert np.nanmax(step) < 1.5 * speed * 0.06
    # A particle that has left is at the outlet, and next at the inlet: in one row it would jump.
    id = again[np.isin(again, tracks.particle_id.values[tracks.passage.values == 0])][0]
    first, second = (tracks.x[row].dropna("time") for row in np.flatnonzero(tracks.particle_id.values == id)[:2])
    assert first.time[-1] < second.time[0] and first[-1] - second[0] > 0.1


def test_one_line_of_xarray_reads_one_trajectory(run, tracks):
    number = int(tracks.trajectory[-1])
    one = tracks.sel(trajectory=number).dropna("time")
    assert 0 < one.sizes["time"] < tracks.sizes["time"]
    assert int(one.passage) * 10**10 + int(one.particle_id) == number
    assert np.isfinite(one.u).all()


def test_accessor_returns_the_rows_of_the_file(run, tracks):
    particles = run.particles
    numbers, counts = np.unique(tracks.particle_id, return_counts=True)
    once, twice = int(numbers[counts == 1][0]), int(numbers[counts > 1][0])
    for name in COLUMNS:
        found = particles.sphecs.track(once)[name]
        xr.testing.assert_equal(found, tracks.sphecs.track(once)[name])
        assert found.dims == ("time",)
    with pytest.raises(ValueError, match="choose a passage: "):
        particles.sphecs.track(twice)
    passages = tracks.passage.values[tracks.particle_id.values == twice]
    for passage in map(int, passages):
        one = particles.sphecs.track(twice, passage=passage)
        assert int(one.trajectory) == passage * 10**10 + twice
        xr.testing.assert_equal(one.u, tracks.sel(trajectory=int(one.trajectory)).u)
    both = particles.sphecs.track([twice, once])
    assert both.sizes["trajectory"] == 1 + len(passages)
    xr.testing.assert_equal(both.pressure, tracks.sel(trajectory=both.trajectory).pressure)
    assert "wall_x" not in both
    for source in (particles, tracks):
        with pytest.raises(KeyError, match="none of these frames"):
            source.sphecs.track(10**6)
        with pytest.raises(KeyError, match="with the passage 99"):
            source.sphecs.track(once, passage=99)
        with pytest.raises(ValueError, match="zones: are"):
            source.sphecs.track(once, zones=["reservoir"])
    with_zone = particles.sphecs.track(once, zones=("fluid", "inflow", "outflow"))
    assert set(with_zone.zone.values) <= {0, 2, 3, 255}


def test_trajan_reads_the_file(tracks):
    reader = tracks.traj
    assert type(reader).__name__ == "Orthogonal"
    assert (reader.trajectory_dim, reader.obs_dim, reader.time_varname) == ("trajectory", "time", "time")
    assert reader.crs is None, "Cartesian, no map"
    xr.testing.assert_equal(reader.tx, tracks.x)
    xr.testing.assert_equal(reader.ty, tracks.y)
    frame = reader.iseltime(-1)
    assert np.isfinite(frame.x).sum() == np.isfinite(tracks.x.isel(time=-1)).sum()


def test_selection_of_frames_numbers_zones_and_a_box(run, tracks, tmp_path):
    def export(*options):
        program("export", run.folder, "--tracks", *options, "-o", tmp_path / "some.nc")
        with xr.open_dataset(tmp_path / "some.nc") as data:
            return data.load()

    every = export("--every", 7)
    xr.testing.assert_equal(every.time, tracks.time[::7])
    same = np.intersect1d(every.trajectory, tracks.trajectory)
    assert len(same) == every.sizes["trajectory"], "an identity does not depend on the frames"
    xr.testing.assert_equal(every.v, tracks.v.isel(time=slice(None, None, 7)).sel(trajectory=same))

    some = export("--ids", "3,200-260")
    chosen = tracks.particle_id.isin([3, *range(200, 261)])
    np.testing.assert_array_equal(some.trajectory, tracks.trajectory[chosen])

    box = export("--box", "0.06,-0.005,0.07,0.005")
    inside = ((tracks.x >= 0.06) & (tracks.x <= 0.07) & (abs(tracks.y) <= 0.005)).any("time")
    xr.testing.assert_equal(box.x, tracks.x[inside])

    zones = export("--zones", "fluid,inflow,outflow")
    numbers = samples(run.particles, (0, 2, 3))[0]
    assert zones.zone.dtype == np.uint8
    assert int((zones.zone != 255).sum()) == len(numbers)
    np.testing.assert_array_equal(np.isfinite(zones.x), zones.zone != 255)
    one = int(zones.trajectory[0])
    found = run.particles.sphecs.track(one % 10**10, one // 10**10, ("fluid", "inflow", "outflow"))
    xr.testing.assert_equal(found.zone, zones.zone.sel(trajectory=one))


def test_run_that_was_killed_has_the_same_trajectories(run, tracks, tmp_path):
    """The journal of a run that has not ended gives the first columns of the whole run."""
    folder = tmp_path / "run"
    frame = folder / "journal" / "frame-00000005.nc"
    options = ["--smoke", "--until", "3", "--set", "output.fields=None", "--quiet"]
    with subprocess.Popen([str(binary()), "run", str(QUICKSTART), *options, "--out", str(folder)]) as killed:
        while not frame.exists() and killed.poll() is None:
            time.sleep(0.02)
        killed.kill()
    program("export", folder, "--tracks")
    with xr.open_dataset(folder / "tracks.nc") as early:
        assert 6 <= early.sizes["time"] < tracks.sizes["time"]
        xr.testing.assert_equal(early.x, tracks.x.sel(trajectory=early.trajectory, time=early.time))


def test_faults_are_messages(run, tmp_path):
    def refused(*arguments):
        done = subprocess.run([binary(), "export", *map(str, arguments)], capture_output=True, text=True, check=False)
        assert done.returncode == 2, done.stdout + done.stderr
        return " ".join(done.stderr.split())

    assert "is not a run" in refused(tmp_path, "--tracks")
    assert "has no such particle" in refused(run.folder, "--tracks", "--box", "5,5,6,6", "-o", tmp_path / "none.nc")
    before = (run.folder / "particles.nc").read_bytes()
    assert "not replaced" in refused(run.folder, "--tracks", "-o", run.folder / "particles.nc")
    assert (run.folder / "particles.nc").read_bytes() == before
    assert not list(tmp_path.iterdir())

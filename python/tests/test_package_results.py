"""Results in Python: runs under way, and the accessor of particles."""

import json
import shutil
import subprocess
import sys

import numpy as np
import pytest
import sphecs
import xarray as xr
from scenes import QUICKSTART, ROOT


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Runs 0.6 s of the quickstart scene: fluid has passed the gap."""
    return sphecs.run(QUICKSTART, smoke=True, until=0.6, out=tmp_path_factory.mktemp("package") / "quickstart")


@pytest.fixture(scope="module")
def bodies(tmp_path_factory):
    folder = tmp_path_factory.mktemp("package") / "cylinder"
    scene = ROOT / "scenes" / "cylinder_re20.ron"
    return sphecs.run(scene, smoke=True, until=0.5, out=folder, set={"output.every": 0.1, "output.monitor_every": 0.1})


@pytest.fixture
def under_way(tmp_path):
    """Kills the run when it has four frames: it leaves what a run under way has."""
    program = """if True:
        import os, sys, threading, time, sphecs
        threading.Thread(target=lambda: sphecs.run(sys.argv[1], smoke=True, out=sys.argv[2]), daemon=True).start()
        while not os.path.exists(sys.argv[2] + "/journal/frame-00000003.nc"): time.sleep(0.02)
        os._exit(9)
    """
    folder = tmp_path / "run"
    ended = subprocess.run([sys.executable, "-c", program, str(QUICKSTART), str(folder)], check=False)
    assert ended.returncode == 9
    return sphecs.open(folder)


def test_a_run_has_all_its_files(run, bodies):
    assert set(run.probes.children) == {"inlet", "gap", "axis"}
    assert run.monitor.kinetic_energy[-1] > 0
    assert run.fields.u.dims == ("time", "y", "x")
    assert run.fields.u.isel(time=-1).max() > 0.1
    assert "cylinder" in bodies.forces.children
    with pytest.raises(FileNotFoundError, match="forces.nc"):
        _ = run.forces
    with pytest.raises(FileNotFoundError, match="fields.nc"):
        _ = bodies.fields
    assert run.summary == json.loads((run.folder / "summary.json").read_text())
    assert isinstance(run.notes, list)


def test_other_folders_are_refused(tmp_path):
    with pytest.raises(sphecs.RunError, match="is not a run") as raised:
        sphecs.open(tmp_path)
    assert raised.value.reason == "not a run"


def test_a_run_under_way_has_the_frames_of_the_whole_run(run, under_way):
    assert under_way.status == "running"
    assert "running or killed, " in repr(under_way)
    assert not under_way.is_packed
    early, whole = under_way.particles, run.particles
    count = early.sizes["time"]
    assert count >= 4
    assert set(early.variables) == set(whole.variables)
    same = min(count, whole.sizes["time"] - 1)
    for name in early.variables:
        np.testing.assert_equal(dict(early[name].attrs), dict(whole[name].attrs))
        expected, found = whole[name], early[name]
        if "time" in expected.dims:
            expected, found = expected.isel(time=slice(same)), found.isel(time=slice(same))
        np.testing.assert_array_equal(found.values, expected.values, err_msg=name)
    # A part is read alone, in any order.
    part = early.x.isel(time=[2, 0], particle=slice(5, 9))
    np.testing.assert_array_equal(part, whole.x.isel(time=[2, 0], particle=slice(5, 9)))
    assert early.u.isel(time=1, particle=3).item() == whole.u.isel(time=1, particle=3).item()


def test_tables_of_a_run_under_way_are_those_of_the_whole_run(run, under_way):
    rows = under_way.monitor.sizes["time"]
    assert rows >= 10
    same = min(rows, run.monitor.sizes["time"]) - 1
    xr.testing.assert_equal(under_way.monitor.isel(time=slice(same)), run.monitor.isel(time=slice(same)).load())
    assert set(under_way.probes.children) == set(run.probes.children)
    assert not (under_way.folder / "monitor.nc").exists()


def test_frames_outlive_the_journal(under_way):
    frames = under_way.particles
    expected = frames.x.isel(time=1).values
    later = under_way.particles.x.isel(time=1)
    # Packing replaces the journal by `particles.nc`.
    subprocess.run([sys.executable, "-m", "sphecs", "pack", under_way.folder], check=True, capture_output=True)
    assert not (under_way.folder / "journal").exists()
    np.testing.assert_array_equal(later.values, expected)
    assert under_way.is_packed


def test_grid_reproduces_a_linear_field(run):
    frame = run.particles.isel(time=0).load()
    frame["pressure"] = (3 + 2 * frame.x - 5 * frame.y).astype("f8").assign_attrs(frame.pressure.attrs)
    grid = frame.sphecs.grid("pressure", spacing=0.004)
    assert grid.dims == ("y", "x")
    assert grid.attrs["units"] == "Pa"
    assert np.allclose(grid.x / 0.004, np.round(grid.x / 0.004))
    inside = np.isfinite(grid)
    assert 0.3 < inside.mean() < 1
    # A linear fit of a linear field is exact to rounding.
    np.testing.assert_allclose(
        grid.values[inside], (3 + 2 * grid.x - 5 * grid.y).transpose("y", "x").values[inside], atol=1e-9
    )
    # There is no fluid in the blocks.
    assert np.isnan(grid.sel(x=0.08, y=0.016, method="nearest"))
    assert np.isfinite(grid.sel(x=0.08, y=0.0, method="nearest"))


def test_grid_has_a_dimension_of_time_if_the_dataset_has(run):
    grid = run.particles.isel(time=[0, -1]).sphecs.grid("speed", spacing=0.01, bounds=((0, -0.02), (0.2, 0.02)))
    assert grid.dims == ("time", "y", "x")
    assert grid.sizes == {"time": 2, "y": 5, "x": 21}
    assert grid.isel(time=1).max() > grid.isel(time=0).max()
    with pytest.raises(ValueError, match="`speeed`"):
        run.particles.isel(time=0).sphecs.grid("speeed")
    with pytest.raises(ValueError, match="spacing: is 0.0"):
        run.particles.sphecs.grid("speed", spacing=0)


def test_profile_agrees_with_the_probe(run):
    probe = run.probes["axis"].isel(time=-1)
    frame = run.particles.sel(time=float(probe.time), method="nearest")
    # The frame and the last samples are of the same step.
    assert float(frame.time) == float(probe.time)
    profile = frame.sphecs.profile((0.0, 0.0), (0.2, 0.0), 81, ["u", "v", "speed"])
    assert profile.distance[-1] == pytest.approx(0.2)
    assert set(profile.data_vars) == {"u", "v", "speed"}
    inner = slice(8, 73)
    deviation = np.abs(profile.u[inner].values - probe.u[inner].values).max()
    # Files have f32, and near the openings the probe knows the zones better.
    assert deviation < 0.02 * float(np.abs(probe.u).max())
    assert set(frame.sphecs.profile((0, 0), (0.2, 0)).data_vars) == {"u", "v", "speed", "pressure", "density"}
    with pytest.raises(ValueError, match="points in 2D"):
        frame.sphecs.profile((0, 0, 0), (1, 0, 0))
    with pytest.raises(ValueError, match="n: is 1"):
        frame.sphecs.profile((0, 0), (1, 0), 1)


def test_track_is_the_history_of_a_piece_of_fluid(run):
    particles = run.particles
    number = int(particles.particle_id[7])
    track = particles.sphecs.track(number, passage=0)
    assert track.x.dims == ("time",)
    here = particles.isel(particle=7)
    fluid = ((here.zone == 0) & (here.passage == 0)).values
    np.testing.assert_array_equal(track.x, np.where(fluid, here.x, np.nan))
    both = particles.sphecs.track([number, number + 1])
    assert set(both.particle_id.values) == {number, number + 1}
    assert both.x.dims == ("trajectory", "time")
    with pytest.raises(KeyError, match="none of these frames"):
        particles.sphecs.track(10**6)


def test_plot_draws_particles_and_walls(run):
    import matplotlib

    matplotlib.use("Agg")
    axes = run.particles.sphecs.plot("pressure")
    walls, dots = axes.collections
    assert len(walls.get_offsets()) == run.particles.sizes["wall"]
    assert len(dots.get_offsets()) == int(np.isin(run.particles.zone.isel(time=-1), (0, 2, 3)).sum())
    assert axes.get_title().startswith("t = 0.60")
    assert run.particles.isel(time=0).sphecs.plot(ax=axes, cmap="magma") is axes
    with pytest.raises(ValueError, match="2D"):
        run.particles.sphecs.plot(slab=("z", 0.0))


def test_three_dimensions(tmp_path):
    scene = ROOT / "scenes" / "duct3d.ron"
    run = sphecs.run(scene, set={"spacing": 0.05}, steps=3, out=tmp_path / "run")
    last = run.particles.isel(time=-1)
    grid = last.sphecs.grid("speed", spacing=0.1)
    assert grid.dims == ("z", "y", "x")
    assert set(last.sphecs.profile((0, 0, 0), (0.6, 0, 0), 5).data_vars) == {
        "u",
        "v",
        "w",
        "speed",
        "pressure",
        "density",
    }
    axes = last.sphecs.plot("u", slab=("y", 0.0))
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x [m]", "z [m]")


def test_other_datasets_are_refused(run):
    with pytest.raises(ValueError, match="no particles of a run"):
        run.monitor.sphecs.grid("speed")


def test_missing_packages_are_named(run):
    program = """if True:
        import sys
        sys.modules["xarray"] = None
        import sphecs
        try:
            sphecs.open(sys.argv[1]).particles
        except ImportError as error:
            print(error)
    """
    shown = subprocess.run([sys.executable, "-c", program, str(run.folder)], capture_output=True, text=True, check=True)
    assert "pip install 'sphecs[results]'" in shown.stdout


def test_copies_of_a_run_can_be_opened(run, tmp_path):
    shutil.copytree(run.folder, tmp_path / "copy")
    assert sphecs.open(tmp_path / "copy").particles.equals(run.particles)

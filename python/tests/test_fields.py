"""`fields.nc`: opened and plotted by xarray, in agreement with the particles and the probes."""

import matplotlib
import numpy as np
import pytest
import xarray as xr
from conftest import sphecs

matplotlib.use("Agg")

PLANES = (
    "output.fields=(volume: true, planes: ["
    "(name: \"middle\", at: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0)), "
    "(name: \"cut\", at: (0.0, 0.0, 0.0), normal: (1.0, 2.0, 0.0))])"
)


@pytest.fixture(scope="session")
def run(tmp_path_factory):
    """Runs 0.5 s of the quickstart scene with means on the grid."""
    folder = tmp_path_factory.mktemp("fields") / "quickstart"
    fields = "output.fields=(every: 0.1, mean: (0.2, 0.4))"
    sphecs("run", "scenes/quickstart.ron", "--smoke", "--until", "0.5", "--set", fields, "--out", folder, "--quiet")
    return folder


@pytest.fixture(scope="session")
def fields(run):
    return xr.open_dataset(run / "fields.nc")


def test_every_quantity_is_plotted_with_one_line(fields):
    assert fields.u.dims == ("time", "y", "x") and fields.u_mean.dims == ("y", "x")
    for name in ("u", "v", "pressure", "density", "vorticity", "tag", "fluid_fraction"):
        fields[name].isel(time=-1).plot()
        matplotlib.pyplot.close("all")


def test_cells_fill_the_box_of_the_domain(fields):
    for axis, (low, high) in {"x": (0.0, 0.2), "y": (-0.02, 0.02)}.items():
        step = np.diff(fields[axis])
        assert step == pytest.approx(step[0])
        assert fields[axis].values[[0, -1]] == pytest.approx([low + step[0] / 2, high - step[0] / 2])


def test_nodes_in_walls_have_no_values(fields):
    in_blocks = (fields.x > 0.06) & (fields.x < 0.1) & (abs(fields.y) > 0.01)
    assert (fields.solid.astype(bool) == in_blocks).all()
    filled = fields.u.isel(time=-1).notnull()
    assert not (filled & in_blocks).any()
    # The channel is full: at most single nodes in its corners have too few particles.
    assert (filled | in_blocks).mean() > 0.995


def test_mass_flow_is_that_of_the_section(fields, run):
    gap = xr.open_datatree(run / "probes.nc")["gap"].to_dataset()
    across = fields.isel(time=-1).sel(x=0.08, method="nearest")
    flow = float((across.density * across.u).sum() * np.diff(fields.y)[0])
    measured = float(gap.mass_flow.sel(time=float(across.time), method="nearest"))
    # Sixteen particles across at the smoke spacing: the section counts crossings of particles.
    assert flow == pytest.approx(measured, rel=0.05)


def test_nodes_agree_with_a_line_probe(fields, run):
    axis = xr.open_datatree(run / "probes.nc")["axis"].to_dataset()
    last = fields.isel(time=-1).interp(y=0.0)
    probe = axis.isel(time=-1)
    inside = (probe.x > 0.01) & (probe.x < 0.19)
    on_grid = last.u.interp(x=probe.x.values[inside.values]).values
    # The axis is between two rows of nodes, where a parabola in the gap with 8 nodes across is 1.6 % lower, and
    # velocities of single particles deviate by as much.
    assert np.abs(on_grid - probe.u.values[inside.values]).max() < 0.05 * float(probe.u.max())


def test_means_cover_their_interval(fields):
    assert fields.u_mean.attrs["cell_methods"] == "mean_time: mean"
    assert [float(fields.mean_start), float(fields.mean_end)] == pytest.approx([0.2, 0.4])
    wet = fields.fluid_time.where(fields.solid == 0)
    assert float(wet.max()) == pytest.approx(0.2)
    # The flow starts smoothly, so that the mean of frames and that of all samples nearly agree.
    frames = fields.u.sel(time=slice(0.19, 0.42)).mean("time")
    assert float(abs(fields.u_mean - frames).max()) < 0.15 * float(fields.u.max())
    assert float(fields.uu_covariance.min()) >= 0.0
    assert float((fields.uv_covariance**2 - fields.uu_covariance * fields.vv_covariance).max()) <= 1e-12
    tags = fields.tag.sel(time=slice(0.19, 0.42)).mean("time")
    assert float(abs(fields.tag_mean - tags).max()) < 0.2
    # The passive scalar is 0 or 1 at the start: its variance is at most that of a mean in between.
    assert float((fields.tag_variance - fields.tag_mean * (1.0 - fields.tag_mean)).max()) < 0.02
    assert fields.tag_variance.attrs["cell_methods"] == "mean_time: variance"
    assert fields.density_mean.mean() == pytest.approx(1000.0, rel=0.01)


def test_info_states_times_grid_and_means(fields, run):
    line = next(line for line in sphecs("info", run).splitlines() if line.startswith("fields"))
    times, across, along = fields.sizes["time"], fields.sizes["y"], fields.sizes["x"]
    assert f"{times} times on {along} × {across} nodes, means from 0.2 to 0.4 s" in line


def test_frames_are_exported_onto_the_same_grid(fields, run, tmp_path):
    target = tmp_path / "grid.nc"
    sphecs("export", run, "--grid", "2.5e-3", "--mean", "0.2,0.4", "-o", target)
    exported = xr.open_dataset(target)
    assert exported.u.shape[1:] == fields.u.shape[1:] and "u_mean" in exported
    time = float(fields.time[-1])
    one, other = (data.sel(time=time, method="nearest") for data in (fields, exported))
    assert float(one.time) == float(other.time)
    for name, size in {"u": 0.1, "v": 0.1, "pressure": 10.0, "density": 1000.0, "tag": 1.0}.items():
        # Frames have single precision.
        assert float(abs(one[name] - other[name]).max()) < 1e-4 * size, name


def test_planes_are_groups(tmp_path):
    folder = tmp_path / "duct"
    sphecs("run", "scenes/duct3d.ron", "--smoke", "--steps", "5", "--set", PLANES, "--out", folder, "--quiet")
    whole = xr.open_dataset(folder / "fields.nc")
    assert whole.w.dims == ("time", "z", "y", "x") and {"vorticity_x", "vorticity_z"} <= set(whole)
    middle = xr.open_dataset(folder / "fields.nc", group="middle")
    assert middle.u.dims == ("time", "y", "x") and float(middle.z) == 0.0
    cut = xr.open_dataset(folder / "fields.nc", group="cut")
    assert cut.u.dims == ("time", "b", "a") and cut.x.dims == ("b", "a")
    assert float(abs(cut.x + 2 * cut.y).max()) < 1e-12
    between = whole.u.isel(time=-1).interp(z=0.0)
    assert float(abs(between - middle.u.isel(time=-1)).max()) < 0.1 * float(abs(whole.u).max())
    matplotlib.pyplot.close("all")
    cut.u.isel(time=-1).plot(x="a", y="b")

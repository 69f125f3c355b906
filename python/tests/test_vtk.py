"""Files for ParaView, read by VTK's own readers: VTKHDF with all frames, and compressed VTU."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest
import vtk
import xarray as xr
from conftest import sphecs
from vtk.util.numpy_support import vtk_to_numpy

#: Zones of the flow, and of walls that move.
PRESENT = (0, 2, 3)
WALL = 1

SCALARS = ("density", "pressure", "tag", "zone", "passage")


class Reader:
    """VTKHDF file as VTK reads it."""

    def __init__(self, path):
        self.reader = vtk.vtkHDFReader()
        assert self.reader.CanReadFile(str(path))
        self.reader.SetFileName(str(path))
        self.reader.UpdateInformation()
        information = self.reader.GetOutputInformation(0)
        self.times = information.Get(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS()) or ()

    def at(self, time=0.0):
        self.reader.UpdateTimeStep(time)
        return self.reader.GetOutput()


def points(grid):
    return vtk_to_numpy(grid.GetPoints().GetData())


def array(grid, name):
    return vtk_to_numpy(grid.GetPointData().GetArray(name))


def compare(grid, frame, present):
    """Compares a grid with the particles of a frame of `particles.nc`."""
    count = int(present.sum())
    assert grid.GetNumberOfPoints() == grid.GetNumberOfCells() == count
    assert {grid.GetCellType(cell) for cell in (0, count - 1)} == {vtk.VTK_VERTEX}
    assert [grid.GetCell(cell).GetPointId(0) for cell in (0, count - 1)] == [0, count - 1]
    for axis, (place, velocity) in enumerate([("x", "u"), ("y", "v"), ("z", "w")]):
        wanted = frame[place].values[present] if place in frame else 0.0
        np.testing.assert_array_equal(points(grid)[:, axis], wanted)
        wanted = frame[velocity].values[present] if velocity in frame else 0.0
        np.testing.assert_array_equal(array(grid, "velocity")[:, axis], wanted)
    for name in SCALARS:
        np.testing.assert_array_equal(array(grid, name), frame[name].values[present], err_msg=name)
    np.testing.assert_array_equal(array(grid, "particle_id"), frame.particle_id.values[present])


def has_constants(grid, attributes):
    """Checks the arrays of numbers that all particles of a 2D run share."""
    spacing = attributes["spacing"]
    for name, value in [
        ("mass", attributes["reference_density"] * spacing**2),
        ("spacing", spacing),
        ("smoothing_length", attributes["smoothing_length"]),
    ]:
        np.testing.assert_allclose(array(grid, name), value, rtol=1e-6)


@pytest.fixture(scope="module")
def particles(run_folder):
    with xr.open_dataset(run_folder / "particles.nc") as data:
        return data.load()


@pytest.fixture(scope="module")
def file(run_folder, tmp_path_factory):
    path = tmp_path_factory.mktemp("vtk") / "particles.vtkhdf"
    sphecs("export", run_folder, "--vtkhdf", "-o", path)
    return path


def test_vtkhdf_has_the_particles_of_every_frame(file, particles):
    reader = Reader(file)
    np.testing.assert_array_equal(reader.times, particles.time)
    counts = set()
    # Not in order, as a user moves the slider.
    for index in [*range(particles.sizes["time"]), 0, 2]:
        frame = particles.isel(time=index)
        present = np.isin(frame.zone, PRESENT)
        compare(reader.at(reader.times[index]), frame, present)
        counts.add(int(present.sum()))
    assert len(counts) > 1, "all frames have as many particles"


def test_arrays_suit_point_gaussian_and_the_sph_filters(file, particles):
    grid = Reader(file).at()
    has_constants(grid, particles.attrs)
    # The sum of m/rho W over the particles around a point inside the fluid, which VTK computes, is one.
    grid.GetPointData().SetActiveScalars("tag")
    place = vtk.vtkPolyData()
    inside = vtk.vtkPoints()
    inside.InsertNextPoint(0.03, 0.0, 0.0)
    place.SetPoints(inside)
    kernel = vtk.vtkSPHQuinticKernel()
    kernel.SetDimension(2)
    kernel.SetSpatialStep(particles.attrs["spacing"])
    interpolator = vtk.vtkSPHInterpolator()
    interpolator.SetInputData(place)
    interpolator.SetSourceData(grid)
    interpolator.SetKernel(kernel)
    interpolator.SetDensityArrayName("density")
    interpolator.SetMassArrayName("mass")
    interpolator.ComputeShepardSumOn()
    interpolator.Update()
    assert array(interpolator.GetOutput(), interpolator.GetShepardSumArrayName())[0] == pytest.approx(1, abs=0.05)


def test_walls_at_rest_are_a_file_without_time(file, particles):
    reader = Reader(file.with_name("particles_walls.vtkhdf"))
    assert not reader.times
    grid = reader.at()
    assert grid.GetNumberOfPoints() == grid.GetNumberOfCells() == particles.sizes["wall"]
    np.testing.assert_array_equal(points(grid)[:, 0], particles.wall_x)
    np.testing.assert_array_equal(points(grid)[:, 1], particles.wall_y)
    np.testing.assert_array_equal(array(grid, "wall_part"), particles.wall_part)


def test_frames_may_be_left_out(run_folder, particles, tmp_path):
    sphecs("export", run_folder, "--vtkhdf", "--every", 2, "-o", tmp_path / "some.vtkhdf")
    reader = Reader(tmp_path / "some.vtkhdf")
    np.testing.assert_array_equal(reader.times, particles.time[::2])
    frame = particles.isel(time=2)
    compare(reader.at(reader.times[1]), frame, np.isin(frame.zone, PRESENT))


@pytest.mark.parametrize(("scene", "moves"), [("stirrer", True), ("duct3d", False)])
def test_walls_that_move_and_three_dimensions(scene, moves, tmp_path):
    run = tmp_path / "run"
    output = ["--set", "output.every=1e-9", "--steps", 4, "--quiet"]
    sphecs("run", f"scenes/{scene}.ron", "--smoke", *output, "--out", run)
    sphecs("export", run, "--vtkhdf")
    reader = Reader(run / "particles.vtkhdf")
    with xr.open_dataset(run / "particles.nc") as data:
        frames = data.load()
    assert len(reader.times) == frames.sizes["time"] == 5
    for index, time in enumerate(reader.times):
        frame = frames.isel(time=index)
        present = np.isin(frame.zone, (*PRESENT, WALL))
        assert bool((frame.zone == WALL).any()) == moves
        compare(reader.at(time), frame, present)
    if moves:
        places = [points(reader.at(time))[array(reader.at(time), "zone") == WALL] for time in reader.times[:2]]
        assert places[0].shape == places[1].shape and np.abs(places[1] - places[0]).max() > 0


def test_compressed_vtu_has_the_values_of_the_frames(run_folder, particles, tmp_path):
    sphecs("export", run_folder, "--vtu", "-o", tmp_path / "vtu")
    series = ET.parse(tmp_path / "vtu" / "particles.pvd").getroot().findall("Collection/DataSet")
    assert [float(entry.get("timestep")) for entry in series] == pytest.approx(particles.time.values.tolist())
    for index, entry in enumerate(series):
        path = tmp_path / "vtu" / entry.get("file")
        assert ET.parse(path).getroot().get("compressor") == "vtkZLibDataCompressor"
        reader = vtk.vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(path))
        reader.Update()
        frame = particles.isel(time=index)
        compare(reader.GetOutput(), frame, np.isin(frame.zone, PRESENT))
        has_constants(reader.GetOutput(), particles.attrs)
    reader.SetFileName(str(tmp_path / "vtu" / "walls.vtu"))
    reader.Update()
    np.testing.assert_array_equal(points(reader.GetOutput())[:, 1], particles.wall_y)
    np.testing.assert_allclose(array(reader.GetOutput(), "spacing"), particles.attrs["spacing"], rtol=1e-6)


def test_exports_replace_earlier_ones(run_folder, tmp_path):
    target = tmp_path / "again.vtkhdf"
    target.write_text("an earlier file")
    sphecs("export", run_folder, "--vtkhdf", "-o", target)
    first = target.read_bytes()
    sphecs("export", run_folder, "--vtkhdf", "-o", target)
    assert target.read_bytes() == first, "the same run gives the same file"
    assert {path.name for path in tmp_path.iterdir()} == {"again.vtkhdf", "again_walls.vtkhdf"}

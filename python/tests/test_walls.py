"""`walls.nc`: shear stress and pressure at the walls against exact flows, the forces and each other."""

import numpy as np
import pytest
import xarray as xr
from conftest import sphecs

# A periodic channel that starts as Poiseuille flow: the peak U is g H²/2ν.
CHANNEL = """Scene(
    title: "Poiseuille flow", dimensions: 2, spacing: "H/15", smoke: "H/10",
    constants: {"H": 0.5, "L": 0.4, "U": 0.1, "nu": 0.01},
    fluid: (density: 1000.0, viscosity: "nu", sound_speed: 2.0),
    scheme: Wcsph(smoothing_ratio: 2.0),
    domain: Box(min: (0.0, "-H"), max: ("L", "H")), periodic: ["x"],
    walls: (parts: [(name: "upper", region: Box(min: (0.0, 0.0), max: ("L", "2*H")), velocity: (UPPER, 0.0))]),
    body_force: (FORCE, 0.0),
    initial: (velocity: (START, 0.0)),
    time: (end: 2.0), reference: (velocity: "U", length: "2*H"),
    output: (every: 0.5, walls: (mean: (1.0, 2.0))),
)"""

# Velocity of the upper wall, body force and start of plane Poiseuille flow and of Couette flow between a wall at
# rest and one of speed U; shear stress on the lower and on the upper wall over that of Poiseuille flow; tolerance.
# The fluid of a Poiseuille flow slips by 0.02 Δ: its shear is 3.2 % too large with 30 particles across, 2.0 % with 50.
FLOWS = {
    "poiseuille": ('"0"', '"2*nu*U/H^2"', '"U*(1 - y^2/H^2)"', (1.0, 1.0), 0.035),
    "couette": ('"U"', '"0"', '"U*(y + H)/(2*H)"', (0.25, -0.25), 0.01),
}


@pytest.mark.parametrize("flow", FLOWS)
def test_shear_stress_is_that_of_the_exact_flow(flow, tmp_path):
    upper, force, start, expected, tolerance = FLOWS[flow]
    text = CHANNEL.replace("UPPER", upper).replace("FORCE", force).replace("START", start)
    scene = tmp_path / "channel.ron"
    scene.write_text(text)
    sphecs("run", scene, "--out", tmp_path / "run", "--quiet")
    walls = xr.open_dataset(tmp_path / "run" / "walls.nc")
    assert f"at walls      {walls.sizes['time']} times, means from 1 to 2 s" in sphecs("info", tmp_path / "run")
    stress = 2 * 1000.0 * 0.01 * 0.1 / 0.5
    for part, of_exact in zip((0, 1), expected):
        at = walls.isel(point=walls.wall_part.values == part)
        assert at.area.sum() == pytest.approx(0.4, rel=1e-3)
        assert at.wall_shear_stress_x_mean.values == pytest.approx(of_exact * stress, rel=tolerance)
        assert at.wall_shear_stress_y_mean.values == pytest.approx(0.0, abs=1e-9)
        assert at.wall_shear_stress_x.isel(time=-1).mean() == pytest.approx(of_exact * stress, rel=tolerance)
        friction_velocity = (abs(of_exact) * stress / 1000.0) ** 0.5
        assert at.y_plus_mean.values == pytest.approx(friction_velocity * 0.5 * 0.5 / 15 / 0.01, rel=tolerance)
    assert (walls.oscillatory_shear_index < 1e-3).all()


@pytest.fixture(scope="session")
def cylinder(tmp_path_factory):
    """Runs the flow past a cylinder at a coarse spacing until it is nearly steady."""
    folder = tmp_path_factory.mktemp("walls") / "cylinder"
    box = "domain=Difference([Box(min: (-4.0, -4.0), max: (8.0, 4.0)), Circle(center: (0.0, 0.0), radius: \"R\")])"
    sets = ["spacing=0.2", "precision=F32", box, "inlets.0.at=(-4.0, 0.0)", "constants.L=8.0", "time.end=12.0"]
    sets += ["bodies.0.mean=(8.0, 12.0)", "output.probes=[]", "output.walls=(parts: [\"cylinder\"], mean: (8.0, 12.0))"]
    sets += ["output.every=4.0"]
    options = [option for change in sets for option in ("--set", change)]
    sphecs("run", "scenes/cylinder_re20.ron", *options, "--out", folder, "--quiet")
    return folder


def test_drag_is_the_integral_over_the_surface(cylinder):
    walls = xr.open_dataset(cylinder / "walls.nc")
    forces = xr.open_datatree(cylinder / "forces.nc")["cylinder"].to_dataset()
    assert walls.area.sum() == pytest.approx(2 * np.pi, rel=0.01)
    pressure = float((-walls.pressure_mean * walls.normal_x * walls.area).sum())
    friction = float((walls.wall_shear_stress_x_mean * walls.area).sum())
    late = forces.sel(time=slice(8.0, 12.0)).mean("time")
    # A linear fit over two spacings, with ten across.
    assert pressure == pytest.approx(float(late.pressure_force_x), rel=0.05)
    assert friction == pytest.approx(float(late.viscous_force_x), rel=0.02)


def test_curve_of_a_body_is_closed_and_symmetric(cylinder):
    walls = xr.open_dataset(cylinder / "walls.nc")
    assert set(walls.wall_part.values) == {1} and len(np.unique(walls.curve)) == 1
    assert np.diff(walls.arc_length) == pytest.approx(np.diff(walls.arc_length)[0])
    front = walls.pressure_mean.isel(point=int(walls.x.argmin()))
    assert front > walls.pressure_mean.isel(point=int(walls.x.argmax()))
    assert float(walls.pressure_mean.max()) == pytest.approx(float(front), rel=0.05)


def test_walls_that_move_have_their_places_over_time(tmp_path):
    folder = tmp_path / "run"
    sets = ["time.end=0.5", "output.every=0.25", 'output.walls=(parts: ["cylinder"], mean: (0.0, 0.5))']
    options = [option for change in sets for option in ("--set", change)]
    sphecs("run", "scenes/towed_cylinder.ron", "--smoke", *options, "--out", folder, "--quiet")
    walls = xr.open_dataset(folder / "walls.nc")
    assert walls.x.dims == ("time", "point") and walls.x_at_start.dims == ("point",)
    # The way of U (1 − exp(−t²/4)) along −x.
    times = np.linspace(0.0, float(walls.time[-1]), 1001)
    speeds = 1 - np.exp(-((times / 2) ** 2))
    way = -np.sum((speeds[1:] + speeds[:-1]) / 2 * np.diff(times))
    moved = walls.x.isel(time=-1) - walls.x_at_start
    assert moved.values == pytest.approx(way, abs=1e-5)
    assert walls.wall_shear_stress_mean.notnull().all() and (walls.fluid_time > 0.49).all()


def test_resumed_means_are_those_of_one_run(tmp_path):
    walls = "output.walls=(every: 0.1, mean: (0.1, 0.4))"
    common = ["scenes/quickstart.ron", "--smoke", "--set", walls, "--set", "output.fields=()", "--quiet"]
    sphecs("run", *common, "--until", "0.4", "--out", tmp_path / "whole")
    sphecs("run", *common, "--until", "0.2", "--out", tmp_path / "parts")
    sphecs("resume", tmp_path / "parts", "--until", "0.4", "--quiet")
    whole, parts = (xr.load_dataset(tmp_path / name / "walls.nc") for name in ("whole", "parts"))
    # The first part wrote its end as a time of its own.
    parts = parts.isel(time=[step in whole.step.values for step in parts.step.values])
    assert whole.drop_attrs().identical(parts.drop_attrs())

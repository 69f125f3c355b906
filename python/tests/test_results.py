"""Contents of a run folder: units, zone counts that add up, and agreement with the engine's own figures."""

import json

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from conftest import sphecs
from sphecs_results import frame, open_run, plot, profile, zones


@pytest.fixture(scope="session")
def particles(run_folder):
    return open_run(run_folder)


@pytest.fixture(scope="session")
def monitor(run_folder):
    return open_run(run_folder, "monitor.nc")


@pytest.fixture(scope="session")
def summary(run_folder):
    return json.loads((run_folder / "summary.json").read_text())


def test_folder_is_complete(run_folder):
    names = {path.name for path in run_folder.iterdir() if not path.name.startswith(".")}
    assert {"particles.nc", "monitor.nc", "monitor.csv", "probes.nc", "probes_points.csv", "scene.ron"} <= names
    assert {"inlet.csv", "gap.csv", "axis.csv"} == {path.name for path in (run_folder / "probes").iterdir()}
    assert "journal" not in names


def test_every_variable_has_units_and_a_long_name(run_folder):
    for file in ("particles.nc", "monitor.nc", "probes.nc", "fields.nc"):
        tree = xr.open_datatree(run_folder / file)
        assert tree.attrs["Conventions"] == "CF-1.11"
        for group in tree.subtree:
            for name, variable in group.variables.items():
                assert "units" in variable.attrs and "long_name" in variable.attrs, f"{file}: {group.path}/{name}"


def test_units_are_si(particles):
    units = {"x": "m", "y": "m", "u": "m s-1", "v": "m s-1", "density": "kg m-3", "pressure": "Pa", "time": "s"}
    for name, unit in units.items():
        assert particles[name].attrs["units"] == unit
    # CF has names for sea water and air only, and the fluid may be any.
    assert [name for name in particles.variables if "standard_name" in particles[name].attrs] == ["time"]


def test_time_stays_a_number_of_seconds(particles, monitor):
    for data in (particles, monitor):
        assert data.time.dtype == np.float64
        assert data.time_step.dtype == np.float64
        assert np.all(np.diff(data.time) > 0)
    assert particles.time.values[0] == 0.0
    assert particles.time.values[-1] == pytest.approx(0.25, abs=0.01)


def test_properties_of_the_run_are_attributes(particles, run_folder):
    for name in ("scene_sha256", "sphecs_version", "kernel", "smoothing_length", "spacing", "sound_speed"):
        assert name in particles.attrs
    text = (run_folder / "scene.ron").read_text()
    assert particles.attrs["scene"].strip() == text.strip()


def test_zone_counts_equal_the_ledger(particles, monitor, summary):
    names = zones(particles)
    shared = np.intersect1d(particles.time.values, monitor.time.values)
    assert shared.size >= 2
    for time in shared:
        zone = particles.zone.sel(time=time).values
        for name in ("fluid", "inflow", "outflow", "reservoir"):
            assert (zone == names[name]).sum() == int(monitor[f"count_{name}"].sel(time=time)), f"{name} at {time} s"
    assert particles.sizes["wall"] == int(monitor.count_wall[-1]) == summary["ledger"]["wall"]

    ledger = summary["ledger"]
    last = particles.zone.isel(time=-1).values
    for name in ("fluid", "inflow", "outflow", "reservoir"):
        assert (last == names[name]).sum() == ledger[name]
    total = sum(ledger[name] for name in ("fluid", "wall", "inflow", "outflow", "reservoir"))
    assert total == ledger["initial"] + ledger["grown"] + ledger["created"] - ledger["deleted"]
    assert ledger["balances"]


def test_only_stored_particles_have_no_position(particles):
    names = zones(particles)
    stored = particles.zone.isin([names["reservoir"], names["absent"]])
    no_position = np.isnan(particles.x) & np.isnan(particles.y)
    assert bool((stored == no_position).all())


def test_csv_files_have_equal_numbers(run_folder, monitor):
    table = pd.read_csv(run_folder / "monitor.csv")
    assert len(table) == monitor.sizes["time"]
    for column in table:
        name, unit = column.rstrip("]").split(" [")
        assert monitor[name].attrs["units"] == unit
        # Parsing text may change the last digit.
        np.testing.assert_allclose(table[column].to_numpy(float), monitor[name].values, rtol=1e-14)


def test_profile_from_particles_equals_the_probe_of_the_engine(particles, run_folder):
    axis = open_run(run_folder, "probes.nc", group="axis")
    # Lines are sampled with the frames.
    np.testing.assert_array_equal(axis.time, particles.time)
    time = axis.time.values[-1]
    points = np.column_stack([axis.x, axis.y])
    # The engine samples the fluid only, not the zones of inlets and outlets.
    found = profile(frame(particles, time, "fluid"), points, "u", h=particles.attrs["smoothing_length"])
    wanted = axis.u.sel(time=time).values
    both = np.isfinite(found) & np.isfinite(wanted)
    assert both.mean() > 0.9
    largest = np.abs(wanted[both]).max()
    assert largest > 0.0
    # Both fit the same functions to the same particles, with slightly different volumes as weights.
    assert np.abs(found - wanted)[both].max() < 1e-3 * largest


def test_mass_flow_of_a_section_is_the_integral_of_its_particles(particles, run_folder):
    inlet = open_run(run_folder, "probes.nc", group="inlet")
    time = np.intersect1d(particles.time.values, inlet.time.values)[-1]
    x, height = float(inlet.x), 0.04
    count = 64
    y = (np.arange(count) + 0.5) / count * height - height / 2
    now = frame(particles, time)
    h = particles.attrs["smoothing_length"]
    points = np.column_stack([np.full(count, x), y])
    u = profile(now, points, "u", h)
    rho = profile(now, points, "density", h)
    flow = float(np.nansum(u * rho) * height / count)
    assert flow == pytest.approx(float(inlet.mass_flow.sel(time=time)), rel=0.02)


def test_plot_draws_a_figure(particles, tmp_path):
    pytest.importorskip("matplotlib").use("Agg")
    target = tmp_path / "speed.png"
    plot(particles, "speed", time=0.2).savefig(target)
    assert target.stat().st_size > 10_000


def test_render_and_info_read_the_run(run_folder, tmp_path):
    picture = tmp_path / "flow.png"
    sphecs("render", run_folder, "--field", "vorticity", "-o", picture)
    assert picture.read_bytes().startswith(b"\x89PNG")
    text = sphecs("info", run_folder)
    assert "completed" in text and "balances" in text


def test_packed_file_opens_with_other_readers(run_folder):
    with xr.open_dataset(run_folder / "particles.nc", decode_times=False, mask_and_scale=False) as raw:
        assert raw.zone.dtype == np.uint8
        assert raw.zone.encoding["zlib"] and raw.zone.encoding["shuffle"]

"""Simulations that a program advances: state, forces, samples."""

import gc
import threading
import weakref

import numpy as np
import pytest
import sphecs
from scenes import QUICKSTART, ROOT, box, channel


@pytest.fixture
def simulation():
    return sphecs.Simulation(channel())


def test_steps_advance_the_clock(simulation):
    assert (simulation.time, simulation.step_count) == (0, 0)
    simulation.step()
    assert simulation.step_count == 1
    assert simulation.time == simulation.time_step > 0
    simulation.step(9)
    assert simulation.step_count == 10
    simulation.run_until(0.5)
    assert 0.5 <= simulation.time < 0.5 + simulation.time_step
    simulation.step(0)
    simulation.run_until(0.1)
    assert "t = 0.5" in repr(simulation)
    for wrong in (-1, 0.5):
        with pytest.raises(ValueError, match="whole number"):
            simulation.step(wrong)
    with pytest.raises(ValueError, match="finite"):
        simulation.run_until(np.inf)


def test_properties_are_those_of_the_scene(simulation):
    assert (simulation.name, simulation.dimensions, simulation.spacing, simulation.end) == ("scene", 2, 0.05, 1)
    assert simulation.smoothing_length > simulation.spacing
    assert simulation.notes == []


def test_state_is_that_of_the_files(tmp_path):
    run = sphecs.run(QUICKSTART, smoke=True, steps=50, out=tmp_path / "run")
    simulation = sphecs.Simulation(QUICKSTART, smoke=True, threads=1)
    simulation.step(50)
    state = simulation.state
    with run.particles as particles:
        last = particles.isel(time=-1).load()
        kept = np.isin(last.zone, (0, 2, 3))
        flow = state.where(state.zone != 1)
        assert float(last.time) == state.time
        np.testing.assert_array_equal(flow.id, last.particle_id[kept])
        np.testing.assert_array_equal(flow.zone, last.zone[kept])
        np.testing.assert_array_equal(flow.position, np.column_stack([last.x, last.y])[kept])
        np.testing.assert_array_equal(flow.velocity.astype("f4"), np.column_stack([last.u, last.v])[kept])
        np.testing.assert_array_equal(flow.pressure.astype("f4"), last.pressure[kept])
        np.testing.assert_array_equal(flow.density.astype("f4"), last.density[kept])
        np.testing.assert_array_equal(state.wall.position[:, 0], last.wall_x)
        np.testing.assert_array_equal(state.wall.id, last.wall_id)


def test_state_has_one_row_per_particle(simulation):
    simulation.step(5)
    state = simulation.state
    count = len(state)
    assert state.position.shape == state.velocity.shape == (count, 2)
    assert state.position.dtype == state.velocity.dtype == np.float64
    for column in (state.pressure, state.density, state.zone, state.patch, state.id):
        assert column.shape == (count,)
    assert np.all(np.diff(state.id.astype(int)) > 0)
    assert len(state.fluid) + len(state.wall) + len(state.select("inflow")) + len(state.select("outflow")) == count
    assert np.all(state.fluid.zone == 0)
    fast = state.fluid.where(state.fluid.velocity[:, 0] > 0.05)
    assert np.all(fast.velocity[:, 0] > 0.05)
    with pytest.raises(ValueError, match="`fluids`"):
        state.select("fluids")
    with pytest.raises(ValueError, match="one truth value"):
        state.where([True])


def test_arrays_outlive_steps_and_simulations():
    simulation = sphecs.Simulation(channel())
    simulation.step(3)
    position = simulation.state.position
    before = position.copy()
    simulation.step(3)
    assert not np.array_equal(before, simulation.state.position)
    del simulation
    gc.collect()
    np.testing.assert_array_equal(position, before)
    with pytest.raises(ValueError, match="read-only"):
        position[0] = 1


def test_a_state_ends_with_the_next_step(simulation):
    state, fluid = simulation.state, simulation.state.fluid
    assert simulation.state is state
    simulation.step()
    for old in (state, fluid):
        with pytest.raises(sphecs.StaleStateError, match="step 0, the simulation is at step 1"):
            _ = old.position
    assert simulation.state is not state


def test_reading_the_state_changes_no_result():
    read, unread = (sphecs.Simulation(channel()) for _ in range(2))
    for _ in range(10):
        read.step()
        assert len(read.state) > 0
        read.sample([[0.5, 0.2]])
    unread.step(10)
    np.testing.assert_array_equal(read.state.position, unread.state.position)


def test_a_force_accelerates_as_newton_predicts():
    calls = []

    def wind(time, position, velocity):
        calls.append(time)
        assert position.shape == velocity.shape == (160, 2)
        return np.array([0.02, -0.01])

    simulation = sphecs.Simulation(box(), forces=[wind, lambda t, x, v: np.full_like(v, 0.01)])
    simulation.step(40)
    expected = np.array([0.03, 0.0]) * simulation.time
    np.testing.assert_allclose(simulation.state.fluid.velocity, np.broadcast_to(expected, (160, 2)), atol=1e-9)
    assert len(calls) >= 40
    assert calls[0] == 0


def test_a_force_equals_that_of_the_scene():
    # In a box without openings no other part of the engine knows the body force of the scene.
    by_scene = sphecs.Simulation(box(), set={"body_force": ("0.1*sin(2*pi*x)", "t")})
    by_function = sphecs.Simulation(
        box(), forces=lambda t, x, v: np.column_stack([0.1 * np.sin(2 * np.pi * x[:, 0]), np.full(len(x), t)])
    )
    for simulation in (by_scene, by_function):
        simulation.step(50)
    # The sine of NumPy differs from that of the engine in the last digit.
    np.testing.assert_allclose(by_scene.state.velocity, by_function.state.velocity, rtol=0, atol=1e-12)


def test_the_result_of_a_force_does_not_depend_on_threads():
    def drag(time, position, velocity):
        return -5 * velocity

    runs = [sphecs.Simulation(channel(), forces=[drag], threads=threads) for threads in (1, 2)]
    for simulation in runs:
        simulation.step(30)
    np.testing.assert_array_equal(runs[0].state.velocity, runs[1].state.velocity)


def test_an_exception_of_a_force_ends_the_step():
    def late(time, position, velocity):
        if time > 0.02:
            raise KeyError("from the force")
        return 0 * velocity

    simulation = sphecs.Simulation(channel(), forces=[late])
    with pytest.raises(KeyError, match="from the force") as raised:
        simulation.step(1000)
    assert raised.traceback[-1].name == "late"
    assert 0.02 < simulation.time < 0.1
    assert len(simulation.state.position) > 0
    with pytest.raises(sphecs.RunError, match="a force raised") as again:
        simulation.step()
    assert again.value.reason == "ended"


@pytest.mark.parametrize(
    ("force", "error", "message"),
    [
        (lambda t, x, v: x[:, 0], ValueError, r"shape \(160,\), must be \(160, 2\)"),
        (lambda t, x, v: v[:3], ValueError, r"shape \(3, 2\)"),
        (lambda t, x, v: np.nan * v, ValueError, "must be finite"),
        (lambda t, x, v: "fast", ValueError, "could not convert"),
        (lambda t, x: x, TypeError, "positional"),
    ],
)
def test_a_force_of_a_wrong_kind_is_named(force, error, message):
    with pytest.raises(error, match=message):
        sphecs.Simulation(box(), forces=[force]).step()


def test_a_force_cannot_advance_its_own_simulation():
    simulations = []
    simulation = sphecs.Simulation(box(), forces=[lambda t, x, v: simulations[0].step()])
    simulations.append(simulation)
    with pytest.raises(sphecs.RunError, match="in use by another call"):
        simulation.step()


def test_other_threads_run_during_a_step():
    simulation = sphecs.Simulation(QUICKSTART, smoke=True)
    worker = threading.Thread(target=simulation.step, args=(300,))
    worker.start()
    seen = set()
    while worker.is_alive():
        seen.add(simulation.step_count)
    worker.join()
    assert simulation.step_count == 300
    assert len(seen) > 10


def test_a_force_may_belong_to_the_holder_of_its_simulation():
    class Model:
        def __init__(self):
            self.simulation = sphecs.Simulation(channel(), forces=[self.force])

        def force(self, time, position, velocity):
            return 0 * velocity

    model = Model()
    model.simulation.step()
    left = weakref.ref(model)
    del model
    gc.collect()
    assert left() is None


def test_a_flow_that_diverges_ends_the_simulation():
    simulation = sphecs.Simulation(box(), forces=[lambda t, x, v: 1e9 * x])
    with pytest.raises(sphecs.RunError, match="diverged at step") as raised:
        simulation.step(1000)
    assert raised.value.reason == "diverged"
    assert raised.value.step == simulation.step_count
    assert len(simulation.state.position) > 0
    with pytest.raises(sphecs.RunError, match="has ended"):
        simulation.step()


def test_samples_are_fields_at_points(simulation):
    simulation.step(20)
    sample = simulation.sample([[0.5, 0.2], [0.25, 0.1], [5.0, 5.0]])
    assert sample.velocity.shape == (3, 2)
    assert sample.pressure.shape == sample.density.shape == (3,)
    assert np.isfinite(sample.velocity[:2]).all()
    assert np.isnan(sample.velocity[2]).all()
    assert np.isnan(sample.pressure[2])
    assert sample.density[0] == pytest.approx(1000, rel=0.05)
    with pytest.raises(ValueError, match=r"must be \(n, 2\)"):
        simulation.sample([[0, 0, 0]])


def test_bodies_have_forces():
    simulation = sphecs.Simulation(ROOT / "scenes" / "cylinder_re20.ron", smoke=True)
    assert simulation.forces == {}
    simulation.step(20)
    forces = simulation.forces["cylinder"]
    assert forces.force.shape == (2,)
    assert forces.torque.shape == (1,)
    np.testing.assert_array_equal(forces.force, forces.pressure_force + forces.viscous_force)
    assert forces.force[0] > 0
    assert 0 < forces.time < simulation.time
    assert forces.velocity is None


def test_a_body_that_moves_has_a_motion():
    simulation = sphecs.Simulation(ROOT / "scenes" / "oscillating_cylinder.ron", smoke=True)
    simulation.step(20)
    forces = next(iter(simulation.forces.values()))
    assert forces.position.shape == forces.velocity.shape == (2,)
    assert forces.spin.shape == (1,)


def test_three_dimensions():
    simulation = sphecs.Simulation(ROOT / "scenes" / "duct3d.ron", smoke=True, set={"spacing": 0.05})
    simulation.step(5)
    assert simulation.state.velocity.shape == (len(simulation.state), 3)
    assert simulation.sample([[0.3, 0, 0]]).velocity.shape == (1, 3)


def test_faults_of_the_scene_are_raised():
    with pytest.raises(sphecs.SceneError, match="sound_speed"):
        sphecs.Simulation(channel(), set={"fluid.sound_speed": -1})
    with pytest.raises(TypeError, match="functions"):
        sphecs.Simulation(channel(), forces=[3])

"""A simulation that a program advances step by step."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _sphecs
from ._exceptions import StaleStateError
from ._forces import Floats, Force, force_functions
from ._running import count
from ._scene import SceneLike, scene_input

#: Zones by their numbers.
ZONES = ("fluid", "wall", "inflow", "outflow", "reservoir")


class State:
    """Particles of one step, sorted by their numbers; those in the reservoir are left out.

    The arrays are read-only copies that stay as they are. The state itself ends with the next step: it then raises
    `StaleStateError`, so that no program works on an old state by mistake. Take `simulation.state` again.
    """

    __slots__ = ("_rows", "_shared", "_simulation", "_step", "time")

    def __init__(
        self, simulation: Simulation, shared: dict[str, Any], rows: npt.NDArray[np.intp] | None = None
    ) -> None:
        self._simulation = simulation
        self._shared = shared
        self._rows = rows
        self._step = simulation.step_count
        #: Time of the state, s.
        self.time = simulation.time

    def __repr__(self) -> str:
        return f"<sphecs.State: {len(self)} particles, t = {self.time:.6g} s>"

    def __len__(self) -> int:
        return len(self.id)

    def _column(self, name: str) -> Any:
        now = self._simulation.step_count
        if now != self._step:
            raise StaleStateError(
                f"the state is that of step {self._step}, the simulation is at step {now}: take `simulation.state` again"
            )
        if not self._shared:
            self._shared.update(self._simulation._engine.snapshot())
            for array in self._shared.values():
                array.flags.writeable = False
        column = self._shared[name]
        if self._rows is None:
            return column
        chosen = column[self._rows]
        chosen.flags.writeable = False
        return chosen

    @property
    def position(self) -> Floats:
        """Positions (n, dimensions), m."""
        return self._column("position")

    @property
    def velocity(self) -> Floats:
        """Velocities (n, dimensions), m/s; of walls, that of their surface."""
        return self._column("velocity")

    @property
    def pressure(self) -> Floats:
        """Pressures above that of the reference density, Pa."""
        return self._column("pressure")

    @property
    def density(self) -> Floats:
        """Densities, kg/m³."""
        return self._column("density")

    @property
    def zone(self) -> npt.NDArray[np.uint8]:
        """Zones: 0 fluid, 1 wall, 2 inflow, 3 outflow."""
        return self._column("zone")

    @property
    def patch(self) -> npt.NDArray[np.uint16]:
        """Indices of the inlet, outlet or wall part of each particle; 0 for fluid."""
        return self._column("patch")

    @property
    def id(self) -> npt.NDArray[np.uint32]:
        """Numbers of the particles, as in `particles.nc`."""
        return self._column("id")

    def select(self, zone: str) -> State:
        """Returns the particles of one zone: "fluid", "wall", "inflow" or "outflow"."""
        if zone not in ZONES[:4]:
            raise ValueError(f"zone: is `{zone}`, must be one of {', '.join(ZONES[:4])}")
        return self.where(self.zone == ZONES.index(zone))

    def where(self, mask: npt.ArrayLike) -> State:
        """Returns the particles for which an array of truth values is true."""
        chosen = np.asarray(mask)
        if chosen.dtype != np.bool_ or chosen.shape != (len(self),):
            raise ValueError(
                f"mask: has shape {chosen.shape}, must have one truth value for each of {len(self)} particles"
            )
        rows = np.flatnonzero(chosen)
        return State(self._simulation, self._shared, rows if self._rows is None else self._rows[rows])

    @property
    def fluid(self) -> State:
        """The fluid particles."""
        return self.select("fluid")

    @property
    def wall(self) -> State:
        """The wall particles."""
        return self.select("wall")


@dataclass(frozen=True)
class BodyForce:
    """Force and torque of the fluid on a body at the beginning of the last step; per metre of depth in 2D."""

    #: Time, s.
    time: float
    #: Force of the pressure, N.
    pressure_force: Floats
    #: Force of all else, N.
    viscous_force: Floats
    #: Torque of the pressure about the centre of the body, N m; one component in 2D.
    pressure_torque: Floats
    #: Torque of all else, N m.
    viscous_torque: Floats
    #: Position of the centre, m; None for a body at rest.
    position: Floats | None = None
    #: Velocity of the centre, m/s; None for a body at rest.
    velocity: Floats | None = None
    #: Angular velocity, rad/s; None for a body at rest.
    spin: Floats | None = None

    @property
    def force(self) -> Floats:
        """Whole force, N."""
        return self.pressure_force + self.viscous_force

    @property
    def torque(self) -> Floats:
        """Whole torque, N m."""
        return self.pressure_torque + self.viscous_torque


@dataclass(frozen=True)
class Sample:
    """Fields of the fluid at points; NaN at a point without fluid nearby."""

    #: Velocities (n, dimensions), m/s.
    velocity: Floats
    #: Pressures, Pa.
    pressure: Floats
    #: Densities, kg/m³.
    density: Floats


class Simulation:
    """Simulation of a scene, ready for its first step.

    Parameters
    ----------
    scene: path or text of a scene file, or a dictionary (see `sphecs.variant`).
    set: changes of the scene, as `{"spacing": 0.01}`; text is taken as on the command line.
    forces: functions `f(time, position, velocity)` that return the acceleration of all fluid particles, an array
        `(n, dimensions)` in m/s², or one vector for all. They are called once in every stage of a step, with time in s and
        arrays `(n, dimensions)` of positions, m, and velocities, m/s, whose order changes from step to step. An exception
        ends the step and the simulation.
    smoke: take the coarse smoke spacing of the scene.
    threads: number of threads; None: one for each core. The results do not depend on it.
    name: name of a scene given as text or dictionary.
    """

    def __init__(
        self,
        scene: SceneLike,
        *,
        set: Mapping[str, Any] | None = None,
        forces: Force | Iterable[Force] = (),
        smoke: bool = False,
        threads: int | None = None,
        name: str | None = None,
    ) -> None:
        given = scene_input(scene, set, smoke, name)
        self._engine = _sphecs.Simulation(given, force_functions(forces), count(threads, "threads"))
        self._scene = self._engine.scene()
        self._state: State | None = None

    def __repr__(self) -> str:
        return f"<sphecs.Simulation {self.name!r}: step {self.step_count}, t = {self.time:.6g} s>"

    def step(self, n: int = 1) -> None:
        """Advances by `n` steps. Ctrl-C raises `KeyboardInterrupt` between two steps; the simulation can continue."""
        if n != int(n) or n < 0:
            raise ValueError(f"n: is {n}, must be a whole number from 0")
        self._engine.step(int(n))

    def run_until(self, time: float) -> None:
        """Advances until the first time at or after `time`, s. Ctrl-C as in `step`."""
        if not math.isfinite(time):
            raise ValueError(f"time: is {time}, must be finite")
        self._engine.run_until(float(time))

    @property
    def time(self) -> float:
        """Time, s."""
        return self._engine.clock()[0]

    @property
    def step_count(self) -> int:
        """Number of steps done."""
        return self._engine.clock()[1]

    @property
    def time_step(self) -> float:
        """Size of the last step, s."""
        return self._engine.clock()[2]

    @property
    def state(self) -> State:
        """Particles at the present time."""
        if self._state is None or self._state._step != self.step_count:
            self._state = State(self, {})
        return self._state

    @property
    def forces(self) -> dict[str, BodyForce]:
        """Forces on the bodies of the scene by their names; empty before the first step."""
        return {name: BodyForce(**entry) for name, entry in self._engine.body_forces().items()}

    def sample(self, points: npt.ArrayLike) -> Sample:
        """Returns the fields of the fluid at points (n, dimensions), m."""
        places = np.ascontiguousarray(points, dtype=np.float64)
        if places.ndim == 1:
            places = places[np.newaxis]
        if places.ndim != 2 or places.shape[1] != self.dimensions:
            raise ValueError(f"points: has shape {places.shape}, must be (n, {self.dimensions})")
        return Sample(**self._engine.sample(places))

    @property
    def notes(self) -> list[str]:
        """Notes on outlets that do not behave as intended."""
        return self._engine.notes()

    @property
    def name(self) -> str:
        """Name of the scene."""
        return self._scene["name"]

    @property
    def dimensions(self) -> int:
        """Number of dimensions, 2 or 3."""
        return self._scene["dimensions"]

    @property
    def spacing(self) -> float:
        """Spacing of the particles, m."""
        return self._scene["spacing"]

    @property
    def smoothing_length(self) -> float:
        """Smoothing length, m."""
        return self._scene["smoothing_length"]

    @property
    def end(self) -> float:
        """End of the scene, s."""
        return self._scene["end"]

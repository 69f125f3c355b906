"""The flow of benches/channel_cylinder.ron in PySPH: python channel_cylinder.py --help

Takes the particles, the fluid's constants and the smoothing length from a run of sphecs, so that both start from the
same. The equations are those of sphecs, as PySPH lets its users write theirs, with one evaluation of the forces a step:

    rho_a = sum_b m_b W                                     over fluid, walls, inlet and outlet
    p     = c0^2 rho0/7 ((rho/rho0)^7 - 1)
    dv/dt = sum_b [-(V_b/rho_a) (p_a + p_b) grad W + 4 nu m_b F/(rho_a + rho_b) v_ab],   F = x.grad W/r^2
    dx    = -A h v_max dt sum_b V_b grad W                  shifting, A = 4 as in sphecs

Walls carry the kernel means of the fluid's pressure and of its velocity, reversed. Inlet and outlet are PySPH's own:
new particles come with the inlet's velocity and the pressure of the fluid next to it; what has left keeps what it had.

Prints one JSON object: seconds for the steps after the warm-up, and figures of the flow at the end.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import dataclass
from pathlib import Path

import netCDF4
import numpy as np
from pysph.base.kernels import WendlandQuintic
from pysph.base.particle_array import ParticleArray
from pysph.base.utils import get_particle_array
from pysph.solver.application import Application
from pysph.solver.solver import Solver
from pysph.sph.basic_equations import SummationDensity
from pysph.sph.bc.donothing.inlet import Inlet
from pysph.sph.bc.donothing.outlet import Outlet
from pysph.sph.bc.donothing.simple_inlet_outlet import SimpleInletOutlet
from pysph.sph.bc.inlet_outlet_manager import InletInfo, OutletInfo
from pysph.sph.equation import Equation, Group
from pysph.sph.integrator import LeapFrogIntegrator
from pysph.sph.integrator_step import IntegratorStep
from pysph.sph.wc.basic import TaitEOS

SHIFTING = 4.0  # A, the default of sphecs
ZONES = {"fluid": 0, "inlet": 2, "outlet": 3}  # numbers of the zones in particles.nc
# Properties that the equations below need in addition to the standard ones of PySPH.
PROPERTIES = ["cs", "wij", "cx", "cy", "ioid", "disp"]


@dataclass
class Start:
    """A frame of sphecs: points and velocities of each zone, and the constants of the run."""

    points: dict[str, np.ndarray]
    velocities: dict[str, np.ndarray]
    spacing: float
    smoothing_length: float
    density: float
    sound_speed: float
    viscosity: float


def read_frame(path: Path, index: int) -> Start:
    """A frame of particles.nc, 0 for the first and -1 for the last."""
    with netCDF4.Dataset(path) as file:
        column = {name: np.ma.filled(file[name][index], np.nan) for name in ("x", "y", "u", "v")}
        zone = np.asarray(file["zone"][index])
        at = np.stack([column["x"], column["y"]], axis=1).astype(float)
        velocity = np.stack([column["u"], column["v"]], axis=1).astype(float)
        points = {name: at[zone == number] for name, number in ZONES.items()}
        velocities = {name: velocity[zone == number] for name, number in ZONES.items()}
        points["wall"] = np.stack([file["wall_x"][:], file["wall_y"][:]], axis=1).astype(float)
        velocities["wall"] = np.zeros_like(points["wall"])
        return Start(
            points,
            velocities,
            file.spacing,
            file.smoothing_length,
            file.reference_density,
            file.sound_speed,
            file.kinematic_viscosity,
        )


class InletPressure(Equation):
    """Pressure of inlet particles: the kernel mean of the fluid's."""

    def initialize(self, d_idx, d_p, d_wij):
        d_p[d_idx] = 0.0
        d_wij[d_idx] = 0.0

    def loop(self, d_idx, s_idx, d_p, d_wij, s_p, WIJ):
        d_p[d_idx] += s_p[s_idx] * WIJ
        d_wij[d_idx] += WIJ

    def post_loop(self, d_idx, d_p, d_wij):
        if d_wij[d_idx] > 0.0:
            d_p[d_idx] /= d_wij[d_idx]


class WallState(Equation):
    """Pressure and velocity of wall particles: the kernel means of the fluid's, the velocity reversed."""

    def initialize(self, d_idx, d_p, d_u, d_v, d_wij):
        d_p[d_idx] = 0.0
        d_u[d_idx] = 0.0
        d_v[d_idx] = 0.0
        d_wij[d_idx] = 0.0

    def loop(self, d_idx, s_idx, d_p, d_u, d_v, d_wij, s_p, s_u, s_v, WIJ):
        d_p[d_idx] += s_p[s_idx] * WIJ
        d_u[d_idx] -= s_u[s_idx] * WIJ
        d_v[d_idx] -= s_v[s_idx] * WIJ
        d_wij[d_idx] += WIJ

    def post_loop(self, d_idx, d_p, d_u, d_v, d_wij):
        if d_wij[d_idx] > 0.0:
            d_p[d_idx] /= d_wij[d_idx]
            d_u[d_idx] /= d_wij[d_idx]
            d_v[d_idx] /= d_wij[d_idx]


class Rates(Equation):
    """Pressure force, laminar viscosity and the gradient of concentration, in one loop over the neighbours."""

    def __init__(self, dest, sources, nu):
        self.nu = nu
        super().__init__(dest, sources)

    def initialize(self, d_idx, d_au, d_av, d_cx, d_cy):
        d_au[d_idx] = 0.0
        d_av[d_idx] = 0.0
        d_cx[d_idx] = 0.0
        d_cy[d_idx] = 0.0

    def loop(self, d_idx, s_idx, d_au, d_av, d_cx, d_cy, d_p, d_rho, s_p, s_rho, s_m, DWIJ, XIJ, VIJ, R2IJ):
        volume = s_m[s_idx] / s_rho[s_idx]
        force = -volume * (d_p[d_idx] + s_p[s_idx]) / d_rho[d_idx]
        # The loop includes the particle itself, at zero distance.
        slope = (DWIJ[0] * XIJ[0] + DWIJ[1] * XIJ[1]) / (R2IJ + 1e-24)
        viscous = 4.0 * self.nu * s_m[s_idx] * slope / (d_rho[d_idx] + s_rho[s_idx])
        d_au[d_idx] += force * DWIJ[0] + viscous * VIJ[0]
        d_av[d_idx] += force * DWIJ[1] + viscous * VIJ[1]
        d_cx[d_idx] += volume * DWIJ[0]
        d_cy[d_idx] += volume * DWIJ[1]


class ShiftedLeapfrog(IntegratorStep):
    """Kick, drift with the shift, evaluation, kick."""

    def stage1(self, d_idx, d_x, d_y, d_u, d_v, d_au, d_av, d_cx, d_cy, d_h, d_fastest, d_strength, dt):
        shift = d_strength[0] * d_h[d_idx] * d_fastest[0] * dt
        d_u[d_idx] += 0.5 * dt * d_au[d_idx]
        d_v[d_idx] += 0.5 * dt * d_av[d_idx]
        d_x[d_idx] += dt * d_u[d_idx] - shift * d_cx[d_idx]
        d_y[d_idx] += dt * d_v[d_idx] - shift * d_cy[d_idx]

    def stage2(self, d_idx, d_u, d_v, d_au, d_av, dt):
        d_u[d_idx] += 0.5 * dt * d_au[d_idx]
        d_v[d_idx] += 0.5 * dt * d_av[d_idx]


class Drift(IntegratorStep):
    """Advances inlet and outlet particles at their constant velocity."""

    def stage1(self, d_idx, d_x, d_y, d_u, d_v, dt):
        d_x[d_idx] += dt * d_u[d_idx]
        d_y[d_idx] += dt * d_v[d_idx]


class ChannelCylinder(Application):
    """The flow, from a frame of sphecs."""

    def __init__(self, start: Start, time_step: float, warm_up: int, steps: int, folder: Path):
        self.start = start
        self.time_step = time_step
        self.warm_up = warm_up
        self.steps = steps
        self.began = self.ended = 0.0
        super().__init__(output_dir=str(folder))

    def create_particles(self) -> list[ParticleArray]:
        """The four arrays, the fluid first, all with the same properties."""
        start = self.start
        arrays = []
        for name, at in start.points.items():
            velocity = start.velocities[name]
            array = get_particle_array(
                name=name,
                additional_props=PROPERTIES,
                x=at[:, 0],
                y=at[:, 1],
                u=velocity[:, 0],
                v=velocity[:, 1],
                m=self.particle_mass(),
                rho=start.density,
                h=start.smoothing_length,
            )
            array.add_constant("fastest", float(np.max(np.hypot(velocity[:, 0], velocity[:, 1]))))
            array.add_constant("strength", SHIFTING)
            arrays.append(array)
        return arrays

    def particle_mass(self) -> float:
        """Mass for which the sum over the lattice is the reference density, as sphecs normalises it, kg/m."""
        start, kernel = self.start, WendlandQuintic(dim=2)
        reach = int(np.ceil(2.0 * start.smoothing_length / start.spacing))
        offsets = range(-reach, reach + 1)
        distances = [start.spacing * np.hypot(i, j) for i in offsets for j in offsets]
        return start.density / sum(kernel.kernel(rij=r, h=start.smoothing_length) for r in distances)

    def create_inlet_outlet(self, particle_arrays: dict[str, ParticleArray]) -> list:
        """Creates PySPH's own inlet and outlet, at the first and the last column of fluid."""
        fluid_x = self.start.points["fluid"][:, 0]
        inlet = InletInfo(
            "inlet",
            normal=[-1.0, 0.0, 0.0],
            refpoint=[float(fluid_x.min()), 0.0, 0.0],
            has_ghost=False,
            update_cls=Inlet,
        )
        outlet = OutletInfo(
            "outlet", normal=[1.0, 0.0, 0.0], refpoint=[float(fluid_x.max()), 0.0, 0.0], update_cls=Outlet
        )
        manager = SimpleInletOutlet(fluid_arrays=["fluid"], inletinfo=[inlet], outletinfo=[outlet])
        manager.active_stages = [2]
        manager.setup_iom(dim=2, kernel=self.solver.kernel)
        manager.update_dx(self.start.spacing)
        return manager.get_inlet_outlet(particle_arrays)

    def create_equations(self) -> list[Group]:
        """Density, pressure, the boundaries' state, rates."""
        start = self.start
        everything = list(start.points)
        return [
            Group([SummationDensity("fluid", everything)]),
            Group([TaitEOS("fluid", None, rho0=start.density, c0=start.sound_speed, gamma=7.0)]),
            Group([WallState("wall", ["fluid"]), InletPressure("inlet", ["fluid"])]),
            Group([Rates("fluid", everything, nu=start.viscosity)]),
        ]

    def create_solver(self) -> Solver:
        """One evaluation a step; the end time is unreachable, the number of steps decides."""
        integrator = LeapFrogIntegrator(fluid=ShiftedLeapfrog(), inlet=Drift(), outlet=Drift())
        return Solver(
            dim=2,
            kernel=WendlandQuintic(dim=2),
            integrator=integrator,
            dt=self.time_step,
            tf=2 * self.total_steps() * self.time_step,
            adaptive_timestep=False,
            fixed_h=True,
        )

    def total_steps(self) -> int:
        """Steps of the run, with those of the warm-up."""
        return self.warm_up + self.steps

    def post_step(self, solver: Solver) -> None:
        """Finds the largest speed for the shift; takes the time after the warm-up and at the end."""
        fluid = self.particles[0]
        fluid.fastest[0] = np.sqrt(np.max(fluid.u**2 + fluid.v**2))
        # The solver counts a step after this.
        done = solver.count + 1
        if done == self.warm_up:
            self.began = time.perf_counter()
        elif done == self.total_steps():
            self.ended = time.perf_counter()


def figures(velocity: np.ndarray) -> dict[str, float]:
    """Returns statistics of the fluid's velocities (m/s) in which two runs of one flow should agree."""
    u, v = velocity.T
    return {
        "fluid": len(u),
        "mean_u": float(u.mean()),
        "largest_speed": float(np.hypot(u, v).max()),
        "rms_v": float(np.sqrt(np.mean(v**2))),
    }


def main() -> None:
    """Runs the flow and prints its figures; options that are not its own go to PySPH."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("particles", type=Path, help="particles.nc of a run of sphecs; its first frame is the start")
    parser.add_argument("--time-step", type=float, required=True, help="s")
    parser.add_argument("--warm-up", type=int, required=True, help="steps before the clock starts, at least 1")
    parser.add_argument("--steps", type=int, required=True, help="steps that are timed")
    parser.add_argument("--out", type=Path, required=True, help="folder for PySPH's log")
    options, for_pysph = parser.parse_known_args()

    start = read_frame(options.particles, 0)
    flow = ChannelCylinder(start, options.time_step, options.warm_up, options.steps, options.out)
    flow.run(["--openmp", "--quiet", "--disable-output", "--max-steps", str(flow.total_steps()), *for_pysph])

    fluid = flow.particles[0]
    result = {
        "seconds": flow.ended - flow.began,
        "particles": sum(array.get_number_of_particles() for array in flow.particles),
        "pysph": figures(np.stack([fluid.u, fluid.v], axis=1)),
        "sphecs": figures(read_frame(options.particles, -1).velocities["fluid"]),
    }
    print(json.dumps(result))


if __name__ == "__main__":
    main()

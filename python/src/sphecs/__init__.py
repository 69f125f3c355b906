"""Smoothed particle hydrodynamics of flows with open boundaries.

    import sphecs

    run = sphecs.run("scenes/quickstart.ron", smoke=True)      # files in runs/quickstart
    run.particles.isel(time=-1).sphecs.plot("speed")

    simulation = sphecs.Simulation("scenes/quickstart.ron", smoke=True)
    simulation.step(100)
    simulation.state.fluid.velocity.max()

All quantities are in SI units.
"""

import sys

from . import _sphecs
from ._exceptions import Fault, MissingPackageError, RunError, SceneError, SphecsError, StaleStateError
from ._notation import Variant, variant
from ._results import Run
from ._results import open_run as open  # noqa: A004 - `sphecs.open`, as `xarray` and `PIL` have it
from ._running import Report, check, run
from ._simulation import BodyForce, Sample, Simulation, State
from ._sweep import open_sweep

__version__: str = _sphecs.VERSION

__all__ = [
    "BodyForce",
    "Fault",
    "MissingPackageError",
    "Report",
    "Run",
    "RunError",
    "Sample",
    "SceneError",
    "Simulation",
    "SphecsError",
    "StaleStateError",
    "State",
    "Variant",
    "__version__",
    "check",
    "open",
    "open_sweep",
    "run",
    "variant",
]

# Without it `import sphecs` would take as long as xarray takes; who uses xarray has it already.
if sys.modules.get("xarray") is not None:
    from . import accessor  # noqa: F401

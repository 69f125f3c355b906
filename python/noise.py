"""Velocity noise of single particles in runs of the constricted channel: python noise.py RUN...

The noise of a particle is the residual of its velocity from a linear field fitted to itself and its twelve nearest
neighbours. Prints the root mean square of the noise in the jet (the first 0.12 m downstream of the throat), the spread
of the density there, and the largest time average of u in the throat, over the last third of the run.
"""

import sys

import numpy as np
from constricted_figures import THROAT, mean_velocity_in_throat
from scipy.spatial import cKDTree
from sphecs_results import frame, open_run

NEIGHBOURS = 13  # including the particle itself
JET = 0.12  # m, length of the evaluated part of the jet


def residual(position, velocity, scale):
    """Returns the velocity minus the local linear fit, one row per particle."""
    _, near = cKDTree(position).query(position, k=NEIGHBOURS)
    offset = (position[near] - position[:, None]) / scale
    basis = np.concatenate([np.ones((*offset.shape[:2], 1)), offset], axis=2)
    moment = np.einsum("nki,nkj->nij", basis, basis)
    fit = np.linalg.solve(moment, np.einsum("nki,nkd->nid", basis, velocity[near]))
    return velocity - fit[:, 0]


def main(folders):
    for folder in folders:
        run = open_run(folder)
        end = float(run.time[-1])
        noise, spread = [], []
        for time in np.linspace(2 * end / 3, end, 5):
            now = frame(run, time, zone="fluid")
            position = np.stack([now.x, now.y], axis=1)
            left = residual(position, np.stack([now.u, now.v], axis=1), run.attrs["spacing"])
            jet = (now.x.values > THROAT) & (now.x.values < THROAT + JET)
            noise.append((left[jet] ** 2).sum(axis=1).mean())
            spread.append(float(now.density[jet].std()))
        largest, (x, _) = mean_velocity_in_throat(run.sel(time=slice(2 * end / 3, None)))
        print(
            f"{folder}: noise {np.sqrt(np.mean(noise)):.4f} m/s, density ± {np.mean(spread):.2f} kg/m³, "
            f"largest mean u in the throat {largest:.4f} m/s at x = {x:.3f} m"
        )


if __name__ == "__main__":
    main(sys.argv[1:])

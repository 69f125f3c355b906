#!/usr/bin/env python3
"""Start-up of the flow in a circular pipe that a pressure gradient drives, from rest.

    u = G/(4 nu) (R^2 - r^2) - (2 G R^2/nu) sum_n J0(k_n r/R)/(k_n^3 J1(k_n)) exp(-k_n^2 nu t/R^2)

with the zeros k_n of J0, Szymanski (1932). Prints the table of the validation case `pressure_pipe`:

    python3 scripts/reference/pipe_startup.py > assets/validation/pressure_pipe.csv
"""

import numpy as np
from scipy.special import j0, j1, jn_zeros

RADIUS = 0.01  # m
VISCOSITY = 2e-5  # m2/s
GRADIENT = 0.08  # m/s2, pressure gradient over density
TIMES = {"u_0_25": 0.25, "u_0_5": 0.5, "u_1_0": 1.0, "u_4_0": 4.0}  # s
ZEROS = jn_zeros(0, 200)


def velocity(y, time):
    """Returns the velocity along the axis, m/s, at the places y on a diameter, m."""
    across = np.abs(y)[:, None] / RADIUS
    terms = j0(ZEROS * across) / (ZEROS**3 * j1(ZEROS)) * np.exp(-(ZEROS**2) * VISCOSITY * time / RADIUS**2)
    scale = GRADIENT * RADIUS**2 / VISCOSITY
    return scale * ((1 - across[:, 0] ** 2) / 4 - 2 * terms.sum(axis=1))


def main():
    y = np.linspace(-RADIUS, RADIUS, 161)
    columns = [velocity(y, time) for time in TIMES.values()]
    print("y," + ",".join(TIMES))
    for row in zip(y, *columns):
        print(",".join(f"{value:.6g}" if k else f"{value:.6f}" for k, value in enumerate(row)))


if __name__ == "__main__":
    main()

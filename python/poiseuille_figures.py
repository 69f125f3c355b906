"""Error of runs of the Poiseuille start-up (scenes/poiseuille*.ron): python poiseuille_figures.py RUN...

Prints the largest difference between a fluid particle's u and the exact series at its position and time, and the
largest |v|. Both are relative to the peak v0 of the steady flow, at the times of Alvarado-Rodríguez et al. (2017),
section 5.1.
"""

import sys

import numpy as np
from sphecs_results import frame, open_run

HALF, FORCE, NU = 5.0e-4, 1.0e-4, 1.0e-6  # m, m/s², m²/s: half the gap, force per mass, kinematic viscosity
PEAK = FORCE * HALF**2 / (2 * NU)  # m/s
TIMES = (0.01, 0.03, 0.07, 0.15, 0.5, 1.0)  # s


def series(y, t):
    """Returns the exact start-up profile, m/s, at distance y (m) from the centre line and time t (s)."""
    u = FORCE / (2 * NU) * (HALF**2 - y**2)
    for n in range(200):
        k = 2 * n + 1
        scale = 16 * (-1) ** n * HALF**2 * FORCE / (NU * np.pi**3 * k**3)
        u = u - scale * np.cos(k * np.pi * y / (2 * HALF)) * np.exp(-((k * np.pi / (2 * HALF)) ** 2) * NU * t)
    return u


def main(folders):
    for folder in folders:
        run = open_run(folder)
        print(folder)
        for time in (time for time in TIMES if time <= float(run.time[-1]) * 1.001):
            now = frame(run, time, zone="fluid")
            error = np.abs(now.u.values - series(now.y.values, float(now.time))).max() / PEAK
            print(f"  t = {float(now.time):.3f} s: error {100 * error:.3f} %, v {np.abs(now.v.values).max() / PEAK:.1e}")


if __name__ == "__main__":
    main(sys.argv[1:])

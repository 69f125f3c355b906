"""Velocity in a drum that starts to turn, Batchelor (1967), section 4.5: a table for the case `drum`.

    python3 scripts/reference/drum.py > assets/validation/drum_spin_up.csv
"""

import numpy as np
from scipy.special import j0, j1, jn_zeros

RADIUS, OMEGA, VISCOSITY = 1.0, 1.0, 0.1
TIMES = [0.5, 1.0, 2.0]
ZEROS = jn_zeros(1, 400)


def velocity(r, t):
    """Returns the velocity (m/s) at a radius (m) and time (s)."""
    decay = np.exp(-(ZEROS**2) * VISCOSITY * t / RADIUS**2)
    terms = j1(ZEROS * r / RADIUS) / (ZEROS * j0(ZEROS)) * decay
    return OMEGA * r + 2.0 * OMEGA * RADIUS * terms.sum()


print("r," + ",".join(f"v_{time}".replace(".", "_") for time in TIMES))
for radius in np.linspace(0.0, RADIUS, 101):
    print(f"{radius:.2f}," + ",".join(f"{velocity(radius, time):.6f}" for time in TIMES))

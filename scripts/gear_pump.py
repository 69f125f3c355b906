#!/usr/bin/env python3
"""Writes the outline of the gears of the scene `gear_pump` in millimetres, and checks their gaps.

    python3 scripts/gear_pump.py [--out FOLDER] [--run RUN]

The teeth are involutes with the root that a rack cuts, set back by half the gap: two such gears keep the gap between
their flanks wherever teeth without backlash would touch. `gear.csv` is written into FOLDER, `scenes/meshes` unless
`--out` names another one. Printed are, over one tooth pitch, the smallest distance between the gears and to the casing,
which must be the gap of the scene; the displaced volume; and what flows through the gaps by the theory of lubrication.
RUN is the folder of a run of the scene, whose mean flows are compared with that.
Needs numpy. Exit code: 0, or 1 if a gap is less than that of the scene.
"""

import argparse
import csv
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent

# The gears. Lengths in mm.
TEETH, MODULE, PRESSURE_ANGLE = 8, 5.0, np.radians(30.0)
ADDENDUM = 0.9 * MODULE

# The pump, as in the scene: gap, distance between the axes, height of the channels, all in mm; 1/s; Pa s.
GAP, DISTANCE, CHANNEL, SPEED, VISCOSITY = 1.0, 40.0, 20.0, 5.0, 0.09
DENSITY = 900.0  # kg/m³

# Largest distance between points, mm; number of angles of a tooth pitch at which gaps are measured.
STEP, STEPS = 0.25, 48

PITCH = MODULE * TEETH / 2
TIP = PITCH + ADDENDUM - GAP / 2
BORE = TIP + GAP


# The outline ----------------------------------------------------------------------------------------------------------


def flank():
    """Returns points of one side of the space between two teeth without backlash, from the root to the tip.

    The middle of the space is on the x axis. Below the involute the corner of the rack cuts a trochoid.
    """
    depth = PITCH - ADDENDUM
    corner = np.pi * MODULE / 4 - ADDENDUM * np.tan(PRESSURE_ANGLE)
    along = np.linspace(0.0, ADDENDUM / np.tan(PRESSURE_ANGLE), 2000)
    trochoid = np.hypot(along, depth), corner / PITCH + np.arctan(along / depth) - along / PITCH
    base = PITCH * np.cos(PRESSURE_ANGLE)
    radii = np.linspace(trochoid[0][-1], PITCH + ADDENDUM, 2000)[1:]
    inclination = np.arccos(np.minimum(base / radii, 1.0))
    involute = np.tan(inclination) - inclination - np.tan(PRESSURE_ANGLE) + PRESSURE_ANGLE
    radius = np.concatenate([trochoid[0], radii])
    angle = np.concatenate([trochoid[1], np.pi / (2 * TEETH) + involute])
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)


def evenly(points):
    """Returns points at even distances of at most `STEP` along a polyline, with its ends."""
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    places = np.linspace(0.0, length[-1], int(np.ceil(length[-1] / STEP)) + 1)
    return np.stack([np.interp(places, length, points[:, axis]) for axis in range(2)], axis=1)


def arc(radius, begin, end):
    """Returns points on a circle between two angles, with its ends."""
    angles = np.linspace(begin, end, int(np.ceil(radius * (end - begin) / STEP)) + 1)
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def gear():
    """Returns the gear, anticlockwise, with a tooth on each axis."""
    points = flank()
    tangents = np.gradient(points, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    side = points + GAP / 2 * np.stack([-tangents[:, 1], tangents[:, 0]], axis=1)
    radius = np.linalg.norm(side, axis=1)
    last = np.argmax(radius > TIP)
    share = (TIP - radius[last - 1]) / (radius[last] - radius[last - 1])
    side = evenly(np.vstack([side[:last], side[last - 1] + share * (side[last] - side[last - 1])]))
    root, tip = (np.arctan2(*side[end, ::-1]) for end in (0, -1))
    other = side[::-1] * [1.0, -1.0]
    land = arc(TIP, tip, 2 * np.pi / TEETH - tip)
    space = np.vstack([other[:-1], arc(np.linalg.norm(side[0]), -root, root)[:-1], side[:-1], land[:-1]])
    turns = np.pi / TEETH * (1 + 2 * np.arange(TEETH))
    # Rounded as in the file.
    return np.round(np.vstack([space @ turned(turn).T for turn in turns]), 5) + 0.0


def turned(angle):
    """Returns the matrix of a rotation."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


# Gaps -----------------------------------------------------------------------------------------------------------------


def nearest(points, polygon):
    """Returns the distances of points to the edges of a polygon, and the nearest points of these."""
    edges = np.roll(polygon, -1, axis=0) - polygon
    apart = points[:, None] - polygon
    along = np.clip((apart * edges).sum(axis=2) / (edges**2).sum(axis=1), 0.0, 1.0)
    feet = polygon + along[..., None] * edges
    distances = np.linalg.norm(points[:, None] - feet, axis=2)
    at = np.arange(len(points)), np.argmin(distances, axis=1)
    return distances[at], feet[at]


def cross(a, b):
    """Returns the product a × b of plane vectors."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def overlapping(a, b):
    """Returns true if edges of two polygons cross."""
    p, r, q, s = a[:, None], (np.roll(a, -1, axis=0) - a)[:, None], b, np.roll(b, -1, axis=0) - b
    of_a = cross(r, q - p) * cross(r, q + s - p) <= 0
    of_b = cross(s, p - q) * cross(s, p + r - q) <= 0
    return bool((of_a & of_b).any())


def to_casing(outline):
    """Returns the smallest distance of a gear to its bore and to the corners of bore and channels."""
    height = DISTANCE / 2 - CHANNEL / 2
    across = np.sqrt(BORE**2 - height**2)
    corners = np.array([[across, -height], [-across, -height]])
    return min(BORE - np.linalg.norm(outline, axis=1).max(), nearest(corners, outline)[0].min())


# Flow -----------------------------------------------------------------------------------------------------------------


def flows(outline):
    """Returns the gaps, mm, the flows over one tooth pitch, mm²/s, and those that a pressure drives, mm²/s per Pa.

    Any line from gear to gear bounds the fluid of the outlet, together with lines from both gears to their bores.
    Between the lines each gear pushes ω/2 (R² − r²), with the radii R and r of the ends of the lines. Through a line
    flows half the sum of the velocities of its ends times its length h, and what the pressure drives, h³/(12 μ) dp/ds.
    The sum is the same for all lines: it is their mean with the weight 1/h³. The displaced volume is that with R at the
    tips.
    """
    centre = np.array([0.0, DISTANCE / 2])
    speed = 2 * np.pi * SPEED
    edges = (np.roll(outline, -1, axis=0) - np.roll(outline, 1, axis=0)) / 2
    lengths = np.linalg.norm(edges, axis=1)
    gaps, means = [], []
    for turn in 2 * np.pi / TEETH * np.arange(STEPS) / STEPS:
        upper, lower = outline @ turned(-turn).T + centre, outline @ turned(np.pi / TEETH + turn).T - centre
        # Only what is near the other gear.
        of_upper, of_lower = upper[:, 1] < BORE / 2, lower[:, 1] > -BORE / 2
        below, above = nearest(upper[of_upper], lower)[1], nearest(lower[of_lower], upper)[1]
        above, below = np.vstack([upper[of_upper], above]), np.vstack([below, lower[of_lower]])
        gap = np.linalg.norm(above - below, axis=1)
        gaps.append([0.0 if overlapping(upper, lower) else gap.min(), to_casing(upper - centre)])
        weight = np.concatenate([lengths[of_upper], lengths[of_lower]]) / 2 / gap**3
        of_above, of_below = above - centre, below + centre
        pushed = speed / 2 * (2 * TIP**2 - (of_above**2).sum(axis=1) - (of_below**2).sum(axis=1))
        # Their normals from the outlet to the inlet; the upper gear turns clockwise.
        normal = np.stack([below[:, 1] - above[:, 1], above[:, 0] - below[:, 0]], axis=1)
        walls = speed * np.stack([of_above[:, 1] - of_below[:, 1], of_below[:, 0] - of_above[:, 0]], axis=1)
        back = (walls * normal).sum(axis=1) / 2
        means.append([*(np.average(flow, weights=weight) for flow in (pushed, back)), 1 / weight.sum()])
    pushed, back, mesh = np.mean(means, axis=0)
    # The same along the bores, which reach from channel to channel.
    share = 0.5 + np.arcsin((DISTANCE - CHANNEL) / (2 * BORE)) / np.pi
    radius = np.linalg.norm(outline, axis=1)
    weight = share * np.abs(cross(outline, edges)) / radius / (BORE - radius) ** 3
    # Pushed and carried is ω/2 (r² + (R + h − r) r) by each, with the radius R + h of the bores.
    carried = speed * (np.average(radius * BORE, weights=weight) - TIP**2)
    pressure = np.array([2 / weight.sum(), mesh]) / (12 * VISCOSITY)
    return np.min(gaps, axis=0), pushed, carried, back, *pressure


def compare(run, expected, leak):
    """Prints the mean flows of a run of the scene over those expected without a pressure, and with its leak per Pa."""
    with open(run / "probes_mean.csv", encoding="utf-8") as file:
        sections = {row["probe"]: row for row in csv.DictReader(file)}
    pressure = float(sections["out"]["mean_pressure [Pa]"]) - float(sections["in"]["mean_pressure [Pa]"])
    with_leak = expected - leak * pressure
    print(f"expected at the mean pressure of the run, {pressure:.0f} Pa: {with_leak:.0f} mm²/s")
    for name, row in sections.items():
        flow = float(row["mass_flow [kg m-1 s-1]"]) / DENSITY * 1e6
        interval = f"{float(row['from [s]']):.3g} to {float(row['to [s]']):.3g} s"
        print(f"{name}, {interval}: {flow:.0f} mm²/s, {flow / with_leak:.4f} of that expected")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=ROOT / "scenes" / "meshes", help="folder of the file")
    parser.add_argument("--run", type=Path, help="folder of a run of the scene")
    options = parser.parse_args()
    outline = gear()
    options.out.mkdir(parents=True, exist_ok=True)
    np.savetxt(options.out / "gear.csv", outline, fmt="%.5f", delimiter=",", comments="", header="x,y")
    (between, casing), pushed, carried, back, around, mesh = flows(outline)
    print(f"gear: {len(outline)} points, {cross(outline, np.roll(outline, -1, axis=0)).sum() / 2:.6g} mm²")
    print(f"smallest gap: {between:.4f} mm between the gears, {casing:.4f} mm to the casing")
    print(f"displaced: {pushed / SPEED:.1f} mm² a turn, {pushed:.0f} mm²/s")
    print(f"carried by the walls: {carried:.0f} mm²/s along the bores, {back:.0f} mm²/s back between the gears")
    print(f"driven back by the pressure: {around:.3f} mm²/(Pa s) along the bores, {mesh:.3f} between the gears")
    if options.run:
        compare(options.run, pushed + carried - back, around + mesh)
    sys.exit(int(min(between, casing) < GAP - 1e-4))


if __name__ == "__main__":
    main()

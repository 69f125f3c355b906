#!/usr/bin/env python3
"""Writes the meshes of the scenes `stl_pipe_bend`, `artery_stl` and `rushton` as binary STL, in millimetres.

    python3 scripts/meshes.py [--out FOLDER] [NAME ...]

- `square_bend`: the domain of `scenes/square_bend.ron`, a square duct with a bend of 90 degrees.
- `artery`: a vessel of 6 mm that divides into two of 4 mm, blended smoothly, with flat ends.
- `rushton`: a turbine of a disc, six blades and a shaft, as one solid.
- `ball`: a ball of 1 m with 199 710 facets, of no scene and too large for the repository, to time `sphecs check`.

FOLDER is `scenes/meshes` unless `--out` names another one. NAME is one of the meshes; without it all but `ball` are
written.
Every mesh is checked: each edge has two facets of opposite directions, and the volume is positive. Coordinates are
rounded to those of an STL file, 32 bits, before the check. Equal files result on every machine up to the last digit of
sine and cosine. Needs numpy. Exit code: 0, or 1 if a mesh is not closed.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent

# Most bytes of a file of the repository.
LARGEST = 400_000


def strips(rings, closed=True):
    """Returns the triangles between neighbouring rings of vertices, two for each pair of neighbours.

    The normals point outwards if the rings turn anticlockwise when seen against the direction of their order.
    """
    triangles = []
    for a, b in zip(rings[:-1], rings[1:]):
        count = len(a)
        for i in range(count if closed else count - 1):
            j = (i + 1) % count
            triangles += [(a[i], a[j], b[j]), (a[i], b[j], b[i])]
    return triangles


# The duct -------------------------------------------------------------------------------------------------------------


def square_bend():
    """Returns the duct: 2 m along x, a quarter of a circle about (2 m, 0.16 m), 1.6 m along y.

    160 chords of the outer wall deviate from the arc by 2.4 µm at most, a thousandth of the spacing a/28.
    """
    width, radius, before, behind, chords = 80.0, 160.0, 2000.0, 1600.0, 160
    half = width / 2
    # Corners of the section, clockwise seen against the flow: distance to the outer side, height.
    corners = [(half, -half), (-half, -half), (-half, half), (half, half)]
    stations = [((0.0, 0.0), (0.0, -1.0))]
    for angle in np.linspace(0.0, np.pi / 2, chords + 1):
        sine, cosine = (1.0, 0.0) if angle == np.pi / 2 else (np.sin(angle), np.cos(angle))
        stations.append(((before + radius * sine, radius - radius * cosine), (sine, -cosine)))
    stations.append(((before + radius, radius + behind), (1.0, 0.0)))
    vertices = [
        (x + outer * ox, y + outer * oy, height)
        for (x, y), (ox, oy) in stations
        for outer, height in corners
    ]
    rings = [[4 * station + corner for corner in range(4)] for station in range(len(stations))]
    first, last = rings[0], rings[-1]
    caps = [(first[0], first[2], first[1]), (first[0], first[3], first[2])]
    caps += [(last[0], last[1], last[2]), (last[0], last[2], last[3])]
    return vertices, strips(rings) + caps


# The artery -----------------------------------------------------------------------------------------------------------

# Middle of the end, mm, and radius, mm, of the vessel and its branches; all begin at the origin.
VESSELS = [
    (np.array([-20.0, 0.0, 0.0]), 3.0),
    (25.0 * np.array([np.cos(np.pi / 6), 0.5, 0.0]), 2.0),
    (25.0 * np.array([np.cos(np.pi / 6), -0.5, 0.0]), 2.0),
]

# Length over which the vessels blend, mm.
BLEND = 0.35

# Facets around a vessel, an even number, and rings along it.
AROUND, ALONG = 32, 14


def artery_distance(points):
    """Returns a smooth minimum of the distances to three capsules that extend beyond the ends, mm."""
    shares = np.zeros(len(points))
    for end, radius in VESSELS:
        axis = end / np.linalg.norm(end)
        along = np.maximum(points @ axis, 0.0)
        distance = np.linalg.norm(points - along[:, None] * axis, axis=1) - radius
        shares += np.exp(-distance / BLEND)
    return -BLEND * np.log(shares)


def onto_surface(points, directions):
    """Returns points moved along directions to where `artery_distance` is zero, by Newton's method."""
    step = 1e-4
    for _ in range(30):
        distance = artery_distance(points)
        slope = (artery_distance(points + step * directions) - distance) / step
        slope = np.where(np.abs(slope) < 0.2, 0.2, slope)
        points = points - np.clip(distance / slope, -0.5, 0.5)[:, None] * directions
    return points


def gradient(points):
    """Returns the outward unit normals of the surface near points."""
    step = 1e-4
    sides = [artery_distance(points + step * axis) - artery_distance(points - step * axis) for axis in np.eye(3)]
    normals = np.stack(sides, axis=1)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def artery():
    """Returns the bifurcation: three tubes of rings that share three half rings between two poles.

    The vertices lie on the smooth union to 1e-6 mm; the ends are flat, with 32 corners on their circle.
    """
    up, half = np.array([0.0, 0.0, 1.0]), AROUND // 2
    vertices, fixed = [], []

    def add(points, fix):
        vertices.extend(points)
        fixed.extend([fix] * len(points))
        return list(range(len(vertices) - len(points), len(vertices)))

    poles = add(list(onto_surface(np.array([3.0 * up, -3.0 * up]), np.array([up, -up]))), False)
    axes = [end / np.linalg.norm(end) for end, _ in VESSELS]
    between = {}
    for first, second in [(0, 1), (1, 2), (2, 0)]:
        middle = (axes[first] + axes[second]) / np.linalg.norm(axes[first] + axes[second])
        angles = np.pi * np.arange(1, half)[:, None] / half
        rays = np.cos(angles) * up + np.sin(angles) * middle
        # Outwards from the origin: the surface is the first zero along a ray.
        reach = np.linspace(1.0, 8.0, 1401)
        inside = artery_distance((rays[:, None, :] * reach[:, None]).reshape(-1, 3)).reshape(len(rays), -1) < 0
        start = reach[np.argmin(inside, axis=1)]
        between[first, second] = add(list(onto_surface(rays * start[:, None], rays)), False)

    triangles = []
    for number, (end, radius) in enumerate(VESSELS):
        towards, back = between[number, (number + 1) % 3], between[(number + 2) % 3, number]
        # From the upper pole along one half ring to the lower pole, and back along the other.
        ring = [poles[0], *towards, poles[1], *reversed(back)]
        axis, length = axes[number], np.linalg.norm(end)
        side = np.cross(axis, up)
        sign = np.sign(np.mean([vertices[at] for at in towards], axis=0) @ side)
        angles = 2 * np.pi * np.arange(AROUND)[:, None] / AROUND
        circle = radius * (np.cos(angles) * up + sign * np.sin(angles) * side)
        begin = np.array([vertices[at] for at in ring])
        rings = [ring]
        for share in np.linspace(0.0, 1.0, ALONG + 1)[1:]:
            # Rings lie close together near the division and far apart along the straight part.
            share = 0.35 * share + 0.65 * share**3
            points = (1 - share) * begin + share * (circle + end)
            if share == 1.0:
                rings.append(add(list(circle + end), True))
                continue
            blend = min(1.0, 3 * share)
            points = (1 - blend) * points + blend * (circle + (points @ axis)[:, None] * axis)
            rings.append(add(list(points), False))
        middle = add([end], True)[0]
        tube = strips(rings)
        last = rings[-1]
        tube += [(middle, last[i], last[(i + 1) % AROUND]) for i in range(AROUND)]
        if sign < 0:
            tube = [(a, c, b) for a, b, c in tube]
        triangles += tube

    points, fixed = np.array(vertices), np.array(fixed)
    edges = np.array([(t[i], t[(i + 1) % 3]) for t in triangles for i in range(3)])
    count = np.bincount(edges[:, 0], minlength=len(points))
    free = ~fixed
    for _ in range(12):
        mean = np.zeros_like(points)
        np.add.at(mean, edges[:, 0], points[edges[:, 1]])
        shift = 0.5 * (mean / count[:, None] - points)
        # Only the vertices near the division move: elsewhere the rings are in place.
        near = free & (np.linalg.norm(points, axis=1) < 9.0)
        points[near] += shift[near]
        points[free] = onto_surface(points[free], gradient(points[free]))
    return points, triangles


# The turbine ----------------------------------------------------------------------------------------------------------


def rushton():
    """Returns a turbine of 60 mm with six blades of 15 by 12 by 3 mm, a disc of 45 by 3 mm, a shaft of 12 mm.

    All parts are prisms along z, so the solid is the set of filled cells of one grid: rings of radii, angles and
    layers. Within a blade the angles follow its plane sides. The shaft reaches from the disc 80 mm upwards.
    """
    shaft, inner, disc, outer = 6.0, 15.0, 22.5, 30.0
    thickness, blades, within, beyond = 3.0, 6, 4, 8
    radii = [shaft, 10.5, inner, disc, outer]
    heights = [-6.0, -1.5, 1.5, 6.0, 80.0]
    sector = within + beyond
    around = blades * sector
    vertices, plane = [], []
    for height in heights:
        level = [len(vertices)]
        vertices.append((0.0, 0.0, height))
        for radius in radii:
            flank = np.arcsin(thickness / 2 / max(radius, inner))
            ring = []
            for step in range(around):
                blade, place = divmod(step, sector)
                middle = 2 * np.pi * blade / blades
                if place <= within:
                    angle = np.arcsin(np.sin(flank) * (2 * place / within - 1))
                else:
                    gap = 2 * np.pi / blades - 2 * flank
                    angle = flank + gap * (place - within) / beyond
                ring.append(len(vertices))
                vertices.append((radius * np.cos(middle + angle), radius * np.sin(middle + angle), height))
            level.append(ring)
        plane.append(level)

    def filled(layer, ring, step):
        if not (0 <= layer < 4 and 0 <= ring < 5):
            return False
        on_blade = step % sector < within
        return (
            (ring == 0 and layer >= 1)
            or (ring <= 3 and layer == 1)
            or (ring >= 3 and layer <= 2 and on_blade)
        )

    triangles = []
    for layer in range(4):
        for ring in range(5):
            for step in range(around):
                if not filled(layer, ring, step):
                    continue
                following = (step + 1) % around
                below, above = plane[layer], plane[layer + 1]

                def corner(level, at, which):
                    return level[0] if at == 0 else level[at][which]

                def quad(a, b, c, d):
                    triangles.extend(t for t in [(a, b, c), (a, c, d)] if len(set(t)) == 3)

                low = [corner(below, at, which) for at, which in
                       [(ring, step), (ring + 1, step), (ring + 1, following), (ring, following)]]
                high = [corner(above, at, which) for at, which in
                        [(ring, step), (ring + 1, step), (ring + 1, following), (ring, following)]]
                if not filled(layer - 1, ring, step):
                    quad(*reversed(low))
                if not filled(layer + 1, ring, step):
                    quad(*high)
                if not filled(layer, ring + 1, step):
                    quad(low[1], low[2], high[2], high[1])
                if ring > 0 and not filled(layer, ring - 1, step):
                    quad(low[3], low[0], high[0], high[3])
                if not filled(layer, ring, following):
                    quad(low[2], low[3], high[3], high[2])
                if not filled(layer, ring, (step - 1) % around):
                    quad(low[0], low[1], high[1], high[0])
    return vertices, triangles


# Files ----------------------------------------------------------------------------------------------------------------


def check(points, triangles):
    """Returns the faults of a surface: edges without two facets of opposite directions, and a negative volume."""
    _, welded = np.unique(points, axis=0, return_inverse=True)
    welded = welded.reshape(-1)[triangles]
    faults = []
    if (welded == np.roll(welded, 1, axis=1)).any():
        faults.append("a facet has two corners at one place")
    edges = np.concatenate([welded[:, [0, 1]], welded[:, [1, 2]], welded[:, [2, 0]]])
    once, counts = np.unique(edges, axis=0, return_counts=True)
    back = np.unique(edges[:, ::-1], axis=0)
    if (counts != 1).any() or once.shape != back.shape or (once != back).any():
        faults.append("an edge has not exactly two facets of opposite directions")
    if volume(points, triangles) <= 0:
        faults.append("the normals point inwards")
    return faults


def volume(points, triangles):
    """Returns the enclosed volume, mm³."""
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def write(path, points, triangles):
    """Writes a binary STL file."""
    corners = points[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    facets = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    facets["normal"], facets["corners"] = normals, corners
    header = f"{path.stem}, unit mm, by scripts/meshes.py".encode().ljust(80)
    path.write_bytes(header + np.uint32(len(triangles)).astype("<u4").tobytes() + facets.tobytes())


def ball():
    """Returns a ball of 1 m: 316 bands of latitude with 317 pairs of facets, one facet a pair at the poles."""
    bands, around = 316, 317
    vertices = [(0.0, 0.0, 1000.0)]
    for band in range(1, bands):
        tilt = np.pi * band / bands
        for i in range(around):
            turn = 2.0 * np.pi * i / around
            vertices.append(
                tuple(1000.0 * c for c in (np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)))
            )
    vertices.append((0.0, 0.0, -1000.0))
    rings = [[1 + (band - 1) * around + i for i in range(around)] for band in range(1, bands)]
    triangles = strips(rings[::-1])
    for i in range(around):
        j = (i + 1) % around
        triangles += [(0, rings[0][i], rings[0][j]), (len(vertices) - 1, rings[-1][j], rings[-1][i])]
    return vertices, triangles


MESHES = {"square_bend": square_bend, "artery": artery, "rushton": rushton}

# Written only when named.
OTHERS = {"ball": ball}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=ROOT / "scenes" / "meshes", help="folder of the files")
    parser.add_argument("names", nargs="*", metavar="NAME", help="name of a mesh, all by default")
    options = parser.parse_args()
    unknown = set(options.names) - set(MESHES) - set(OTHERS)
    if unknown:
        sys.exit(f"no such mesh: {', '.join(sorted(unknown))}; meshes: {', '.join(MESHES | OTHERS)}")
    options.out.mkdir(parents=True, exist_ok=True)
    failed = False
    for name in options.names or MESHES:
        points, triangles = (MESHES | OTHERS)[name]()
        points, triangles = np.float32(points).astype(float) + 0.0, np.array(triangles)
        faults = check(points, triangles)
        path = options.out / f"{name}.stl"
        write(path, points, triangles)
        size = path.stat().st_size
        if size > LARGEST and name in MESHES:
            faults.append(f"has {size} bytes, must have {LARGEST} at most")
        verdict = "; ".join(faults) if faults else "closed"
        print(f"{name}: {len(triangles)} facets, {volume(points, triangles):.6g} mm³, {size} bytes: {verdict}")
        failed |= bool(faults)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()

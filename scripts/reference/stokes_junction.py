"""Stokes flow in a T-junction: the lengths that the node adds to its three channels.

Three channels of width 1 meet at right angles, each three widths long. The Stokes equations are solved on a staggered
grid for a unit pressure at each end in turn; the star of three resistances 12 (3 + a) that has the same flows gives
the lengths a. Two grids are extrapolated to second order. Needs numpy and scipy:

    python3 scripts/reference/stokes_junction.py
"""

import numpy
import scipy.sparse
import scipy.sparse.linalg

LENGTH = 3


def flows(cells):
    """Returns the outflow of each end (rows) for a unit pressure at each end (columns)."""
    step, width, height = 1 / cells, (2 * LENGTH + 1) * cells, (1 + LENGTH) * cells
    fluid = numpy.zeros((width, height), bool)
    fluid[:, :cells] = True
    fluid[LENGTH * cells : (LENGTH + 1) * cells, :] = True

    def inside(i, j):
        return 0 <= i < width and 0 <= j < height and fluid[i, j]

    # Faces with a velocity: between cells of the fluid, and at the open ends.
    along_x = [
        (i, j)
        for i in range(width + 1)
        for j in range(height)
        if (inside(i - 1, j) and inside(i, j)) or (i in (0, width) and (inside(i, j) or inside(i - 1, j)))
    ]
    along_y = [
        (i, j)
        for i in range(width)
        for j in range(height + 1)
        if (inside(i, j - 1) and inside(i, j)) or (j == height and inside(i, j - 1))
    ]
    pressures = [(i, j) for i in range(width) for j in range(height) if fluid[i, j]]
    number = {("u", *at): n for n, at in enumerate(along_x)}
    number |= {("v", *at): n + len(along_x) for n, at in enumerate(along_y)}
    number |= {("p", *at): n + len(along_x) + len(along_y) for n, at in enumerate(pressures)}
    entries, right = [], numpy.zeros((len(number), 3))

    def momentum(kind, i, j, axis, ends):
        row, diagonal = number[kind, i, j], 0
        for direction in range(2):
            for sign in (-1, 1):
                other = (kind, i + sign * (direction == 0), j + sign * (direction == 1))
                if other in number:
                    entries.append((row, number[other], step**-2))
                    diagonal -= step**-2
                elif direction != axis:
                    diagonal -= 2 * step**-2  # No slip at half a cell.
                elif (i, j)[axis] not in ends:
                    diagonal -= step**-2  # A wall across the velocity.
        entries.append((row, row, diagonal))
        after, before = ("p", i, j), ("p", i - (axis == 0), j - (axis == 1))
        # The pressure of an end is given half a cell away.
        weight = 1 if after in number and before in number else 2
        for cell, sign in ((after, -1), (before, 1)):
            if cell in number:
                entries.append((row, number[cell], weight * sign / step))
            else:
                right[row, ends[(i, j)[axis]]] -= weight * sign / step

    for i, j in along_x:
        momentum("u", i, j, 0, {0: 0, width: 1})
    for i, j in along_y:
        momentum("v", i, j, 1, {height: 2})
    for i, j in pressures:
        for face, sign in ((("u", i, j), -1), (("u", i + 1, j), 1), (("v", i, j), -1), (("v", i, j + 1), 1)):
            if face in number:
                entries.append((number["p", i, j], number[face], sign / step))
    rows, columns, values = zip(*entries)
    matrix = scipy.sparse.csc_matrix((values, (rows, columns)), shape=(len(number), len(number)))
    solved = scipy.sparse.linalg.splu(matrix).solve(right)
    ends = [
        -sum(solved[number["u", 0, j]] for j in range(cells)) * step,
        sum(solved[number["u", width, j]] for j in range(cells)) * step,
        sum(solved[number["v", i, height]] for i in range(LENGTH * cells, (LENGTH + 1) * cells)) * step,
    ]
    return numpy.array(ends)


def added_lengths(cells):
    """Returns the lengths that the node adds to the channels, in widths."""
    between = abs(flows(cells))
    a, b, c = between[0, 1], between[0, 2], between[1, 2]
    conductances = numpy.array([a * b / c + a + b, a * c / b + a + c, b * c / a + b + c])
    return 1 / conductances / 12 - LENGTH


coarse, fine = added_lengths(24), added_lengths(36)
print("left, right, branch:", fine + (fine - coarse) / (1.5**2 - 1))

"""Fields at points from particles, by weighted least squares as in the probes of the engine.

A polynomial is fitted to the particles within two smoothing lengths of a point, with the weight
w = (1 - q/2)^4 (1 + 2 q), q = r/h, of Wendland (1995). Velocities use a quadratic polynomial where it does not amplify the
noise of the particles, all else a linear one. The result is NaN where fewer particles are near than the polynomial needs.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ._exceptions import needs

#: Largest amplification of particle noise by a quadratic fit, as in the engine.
MAX_GAIN = 5.0

#: Largest condition number of a fit; beyond it the particles lie on one side of the point.
MAX_CONDITION = 1e8

#: Number of points that are fitted at a time: bounds the memory.
CHUNK = 20_000


class Neighbours:
    """Weights by which the values of particles give those at points."""

    def __init__(self, positions: Any, points: Any, h: float, reach: float = np.inf) -> None:
        spatial = needs("scipy.spatial", "results", "sampling of fields")
        self.positions = np.ascontiguousarray(positions, dtype=float)
        self.points = np.ascontiguousarray(points, dtype=float)
        self.h = h
        self.tree = spatial.cKDTree(self.positions)
        # Farther from every particle there is no fluid, even if a polynomial can be extrapolated to the point.
        nearest = self.tree.query(self.points, distance_upper_bound=reach * (1 + 1e-12))[0]
        self.inside = np.isfinite(nearest)
        self._weights: dict[bool, list[tuple[Any, Any, Any, Any]]] = {}

    def sample(self, values: Any, quadratic: bool = False) -> Any:
        """Returns the values at the points, NaN where there are none."""
        values = np.asarray(values, dtype=float)
        result = np.full(len(self.points), np.nan)
        for points, owner, particle, weight in self._chunks(quadratic):
            sums = np.bincount(owner, weight * values[particle], minlength=len(points))
            found = np.bincount(owner, minlength=len(points)) > 0
            result[points[found]] = sums[found]
        return result

    def _chunks(self, quadratic: bool) -> list[tuple[Any, Any, Any, Any]]:
        if quadratic not in self._weights:
            inside = np.flatnonzero(self.inside)
            parts = [inside[start : start + CHUNK] for start in range(0, len(inside), CHUNK)]
            self._weights[quadratic] = [self._fit(points, quadratic) for points in parts]
        return self._weights[quadratic]

    def _fit(self, points: Any, quadratic: bool) -> tuple[Any, Any, Any, Any]:
        """Returns the points, and for each pair its point in the chunk, its particle and the weight."""
        near = self.tree.query_ball_point(self.points[points], 2 * self.h)
        counts = np.array([len(found) for found in near])
        owner = np.repeat(np.arange(len(points)), counts)
        particle = np.concatenate([np.asarray(found, dtype=int) for found in near]) if counts.sum() else owner
        offset = (self.positions[particle] - self.points[points][owner]) / self.h
        q = np.linalg.norm(offset, axis=1)
        weight = np.clip(1 - q / 2, 0, None) ** 4 * (1 + 2 * q)
        linear = np.column_stack([np.ones(len(offset)), offset])
        weights, valid = fit(linear, weight, owner, len(points))
        if quadratic:
            dimensions = offset.shape[1]
            products = [offset[:, a] * offset[:, b] for a in range(dimensions) for b in range(a, dimensions)]
            better, fits = fit(np.column_stack([linear, *products]), weight, owner, len(points))
            fits &= np.bincount(owner, better**2, minlength=len(points)) <= MAX_GAIN
            weights = np.where(fits[owner], better, weights)
            valid |= fits
        keep = valid[owner]
        return points, owner[keep], particle[keep], weights[keep]


def fit(basis: Any, weight: Any, owner: Any, count: int) -> tuple[Any, Any]:
    """Returns the weight of each pair in the value of the polynomial at its point, and the points with a valid fit."""
    size = basis.shape[1]
    moment = np.empty((count, size, size))
    for row in range(size):
        for column in range(row, size):
            sums = np.bincount(owner, weight * basis[:, row] * basis[:, column], minlength=count)
            moment[:, row, column] = moment[:, column, row] = sums
    valid = np.bincount(owner, minlength=count) > size
    # Singular values of symmetric matrices, several at once.
    values = np.abs(np.linalg.eigvalsh(moment))
    valid &= values.max(axis=1) < MAX_CONDITION * np.maximum(values.min(axis=1), 1e-300)
    moment[~valid] = np.eye(size)
    first = np.zeros((count, size, 1))
    first[:, 0] = 1
    coefficients = np.linalg.solve(moment, first)[:, :, 0]
    return weight * np.einsum("ij,ij->i", basis, coefficients[owner]), valid

"""Reference flow in the throat of scenes/constricted_r*.ron by finite volumes: python throat_reference.py CELLS [--free-slip]

Solves the incompressible Navier–Stokes equations on a staggered grid with CELLS cells over half the throat: van Leer's
limiter for the momentum fluxes, central differences for the viscous ones, Heun's method in time with an exact
projection. The domain is the upper half of the channel with a plane of symmetry, from 0.06 m upstream of the throat to
its end, which has a uniform pressure: the jet downstream is omitted. Prints the largest mean u in the throat and its
position, over the second half of 3 s.
"""

import sys

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import splu

V0, T0, D1, D, L, L1, NU = 4.45e-2, 0.2, 0.0889, 0.0133, 0.0778, 0.06, 1e-6  # SI, names as in the scene
END = 3.0  # s


def shifted(field, along_x, along_y):
    """Returns the field shifted by that many cells; the outermost values continue beyond the edge."""
    rows = np.clip(np.arange(field.shape[0]) + along_x, 0, field.shape[0] - 1)
    columns = np.clip(np.arange(field.shape[1]) + along_y, 0, field.shape[1] - 1)
    return field[np.ix_(rows, columns)]


def upwind(behind, left, right, ahead, speed):
    """Returns the upwind value on the face between `left` and `right`, limited by van Leer's function."""

    def half_slope(a, b):
        product = a * b
        return np.where(product > 0.0, product / np.where(product > 0.0, a + b, 1.0), 0.0)

    from_left = left + half_slope(left - behind, right - left)
    from_right = right - half_slope(ahead - right, right - left)
    return np.where(speed > 0.0, from_left, from_right)


class Throat:
    """Flow in channel and throat on a grid of square cells; u on the left faces of the cells, v on the lower ones."""

    def __init__(self, cells, free_slip=False):
        self.mirror = 1.0 if free_slip else -1.0  # sign of the mirrored tangential velocity in a wall
        self.h = h = 0.5 * D / cells
        before, inside = round(L1 / h), round(L / h)
        nx, ny = before + inside, round(0.5 * D1 / h)
        self.begin, self.cells = before, cells
        self.fluid = fluid = np.zeros((nx, ny), bool)
        fluid[:before], fluid[before:, :cells] = True, True
        self.u, self.v = np.zeros((nx + 1, ny)), np.zeros((nx, ny + 1))
        # Faces whose velocity is unknown; the last column of u is the outlet.
        self.u_free, self.v_free = np.zeros(self.u.shape, bool), np.zeros(self.v.shape, bool)
        self.u_free[1:nx], self.u_free[nx] = fluid[1:] & fluid[:-1], fluid[-1]
        self.v_free[:, 1:ny] = fluid[:, 1:] & fluid[:, :-1]
        y = (np.arange(ny) + 0.5) * h
        self.inflow = V0 * (1.0 - (2.0 * y / D1) ** 2)
        self.poisson = self.factorised()

    def factorised(self):
        """Returns the factors of −h²∇² over the fluid cells; the pressure half a cell beyond the last, at the outlet, is 0."""
        nx = self.fluid.shape[0]
        index = np.where(self.fluid, np.cumsum(self.fluid).reshape(self.fluid.shape) - 1, -1)
        diagonal = np.zeros(self.fluid.sum())
        rows, columns = [], []
        for one, other in ((index[1:], index[:-1]), (index[:, 1:], index[:, :-1])):
            pairs = (one >= 0) & (other >= 0)
            rows += [one[pairs], other[pairs]]
            columns += [other[pairs], one[pairs]]
        rows, columns = np.concatenate(rows), np.concatenate(columns)
        np.add.at(diagonal, rows, 1.0)
        diagonal[index[nx - 1][index[nx - 1] >= 0]] += 2.0
        own = np.arange(diagonal.size)
        values = np.concatenate([-np.ones(rows.size), diagonal])
        entries = (np.concatenate([rows, own]), np.concatenate([columns, own]))
        return splu(coo_matrix((values, entries)).tocsc())

    def neighbours(self, field, free, along_x):
        """Returns the two values before and the two after in one direction, reflected at walls."""
        step = (lambda n: shifted(field, n, 0)) if along_x else (lambda n: shifted(field, 0, n))
        solved = (lambda n: shifted(free, n, 0)) if along_x else (lambda n: shifted(free, 0, n))
        one, two = solved(1), solved(1) & solved(2)
        behind = np.where(one, step(1), self.mirror * field)
        return step(-2), step(-1), behind, np.where(two, step(2), self.mirror * np.where(one, step(1), step(-1)))

    def rates(self, u, v):
        """Returns ∂u/∂t and ∂v/∂t by convection and friction."""
        h = self.h
        # u: faces normal to x lie at the cell centres, those normal to y at the cell corners.
        west2, west, east, east2 = (shifted(u, n, 0) for n in (-2, -1, 1, 2))
        to_east, from_west = 0.5 * (u + east), 0.5 * (west + u)
        flux = to_east * upwind(west, u, east, east2, to_east) - from_west * upwind(west2, west, u, east, from_west)
        south2, south, north, north2 = self.neighbours(u, self.u_free, along_x=False)
        south2[:, 0], south2[:, 1] = u[:, 1], u[:, 0]  # symmetry about y = 0
        corner = np.zeros((u.shape[0], v.shape[1]))
        corner[1:-1] = 0.5 * (v[1:] + v[:-1])
        corner[-1] = v[-1]
        to_north, from_south = corner[:, 1:], corner[:, :-1]
        flux += to_north * upwind(south, u, north, north2, to_north)
        flux -= from_south * upwind(south2, south, u, north, from_south)
        du = -flux / h + NU * (west + east + south + north - 4.0 * u) / h**2

        south2, south, north, north2 = (shifted(v, 0, n) for n in (-2, -1, 1, 2))
        south2[:, 1] = -v[:, 1]
        to_north, from_south = 0.5 * (v + north), 0.5 * (south + v)
        flux = to_north * upwind(south, v, north, north2, to_north)
        flux -= from_south * upwind(south2, south, v, north, from_south)
        west2, west, east, east2 = self.neighbours(v, self.v_free, along_x=True)
        east[-1], east2[-1], east2[-2] = v[-1], v[-1], v[-1]  # zero gradient beyond the outlet
        west[0] = west2[0] = -v[0]
        corner = np.zeros((u.shape[0], v.shape[1]))
        corner[:, 1:-1] = 0.5 * (u[:, 1:] + u[:, :-1])
        to_east, from_west = corner[1:], corner[:-1]
        flux += to_east * upwind(west, v, east, east2, to_east)
        flux -= from_west * upwind(west2, west, v, east, from_west)
        dv = -flux / h + NU * (west + east + south + north - 4.0 * v) / h**2
        return du * self.u_free, dv * self.v_free

    def project(self, u, v):
        """Removes the divergence from a velocity, in place."""
        divergence = (u[1:] - u[:-1] + v[:, 1:] - v[:, :-1])[self.fluid]
        pressure = np.zeros(self.fluid.shape)  # over ρ, times Δt/h
        pressure[self.fluid] = self.poisson.solve(-divergence)
        u[1:-1] -= (pressure[1:] - pressure[:-1]) * self.u_free[1:-1]
        u[-1] += 2.0 * pressure[-1] * self.u_free[-1]
        v[:, 1:-1] -= (pressure[:, 1:] - pressure[:, :-1]) * self.v_free[:, 1:-1]
        return u, v

    def mean_velocity(self):
        """Returns the time average of u in the throat, from its axis to its wall, over the second half of END."""
        time = total = 0.0
        mean = np.zeros_like(self.u)
        while time < END:
            fastest = max(np.abs(self.u).max(), np.abs(self.v).max(), V0)
            dt = min(0.4 * self.h / fastest, 0.2 * self.h**2 / NU)
            time += dt
            self.u[0] = self.inflow * min(time / T0, 1.0)
            du, dv = self.rates(self.u, self.v)
            u, v = self.project(self.u + dt * du, self.v + dt * dv)
            du, dv = self.rates(u, v)
            self.u, self.v = self.project(0.5 * (self.u + u + dt * du), 0.5 * (self.v + v + dt * dv))
            if time > 0.5 * END:
                mean, total = mean + dt * self.u, total + dt
        return mean[self.begin :, : self.cells] / total


def main(cells, *options):
    throat = Throat(int(cells), free_slip="--free-slip" in options)
    mean = throat.mean_velocity()
    i, j = np.unravel_index(mean.argmax(), mean.shape)
    print(f"largest mean u in the throat {mean.max():.4f} m/s at x = {i * throat.h:.4f}, y = {(j + 0.5) * throat.h:.4f} m")
    for x in (0.005, 0.01, 0.02, 0.04, 0.07):
        print(f"on the axis at x = {x:.3f} m   {mean[round(x / throat.h), 0]:.4f} m/s")


if __name__ == "__main__":
    main(*sys.argv[1:])

"""Accessor `.sphecs` of xarray datasets with the particles of a run.

`import sphecs.accessor` adds it; so does `sphecs.open`.

    particles = sphecs.open("runs/quickstart").particles
    frame = particles.sel(time=1.0, method="nearest")
    frame.sphecs.grid("speed", spacing=0.002).plot()
    frame.sphecs.profile((0.08, -0.01), (0.08, 0.01), 41)
    particles.sphecs.track(17, passage=0)
    frame.sphecs.plot("pressure")

`grid` and `profile` fit polynomials to the particles of the flow within two smoothing lengths, as probes do. The file holds
densities and pressures of the flow alone, so walls do not count.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from ._exceptions import needs
from ._sampling import Neighbours
from ._tracks import track

#: Zones of the flow: fluid, inflow and outflow.
FLOW = (0, 2, 3)

#: Farthest that a point of the flow is from the nearest particle, in spacings; on a cubic lattice it is 0.87.
REACH = 1.25

AXES = ("x", "y", "z")
VELOCITIES = ("u", "v", "w")


@xr.register_dataset_accessor("sphecs")  # type: ignore[no-untyped-call]
class ParticlesAccessor:
    """Particles of a run as fields, histories and pictures."""

    def __init__(self, dataset: xr.Dataset) -> None:
        self._data = dataset

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the coordinates: x, y and, in 3D, z."""
        data = self._data
        if "zone" not in data or "x" not in data or "smoothing_length" not in data.attrs:
            raise ValueError(
                "the dataset has no particles of a run: open `particles.nc` by `sphecs.open(folder).particles`"
            )
        return AXES[: int(data.attrs["dimensions"])]

    def frames(self) -> Iterator[xr.Dataset]:
        """Returns the particles of the flow, frame by frame."""
        self.axes  # noqa: B018 - refuses other datasets
        data = self._data
        names = [name for name, variable in data.variables.items() if "wall" not in variable.dims]
        present = data[names] if "time" in data.dims else data[names].expand_dims("time")
        for index in range(present.sizes["time"]):
            frame = present.isel(time=index).load()
            yield frame.isel(particle=np.flatnonzero(np.isin(frame.zone, FLOW)))

    def bounds(self) -> tuple[list[float], list[float]]:
        """Returns the lower and upper corner of the box around the particles of the flow, m."""
        lower, upper = np.full(len(self.axes), np.inf), np.full(len(self.axes), -np.inf)
        for frame in self.frames():
            for axis, name in enumerate(self.axes):
                lower[axis] = min(lower[axis], float(frame[name].min()))
                upper[axis] = max(upper[axis], float(frame[name].max()))
        return lower.tolist(), upper.tolist()

    def value(self, frame: xr.Dataset, variable: str) -> npt.NDArray[np.float64]:
        """Returns a variable of the particles of a frame; `speed` is made from the velocity."""
        if variable == "speed":
            return np.sqrt(sum(frame[name].values.astype(float) ** 2 for name in VELOCITIES[: len(self.axes)]))
        if variable not in frame or frame[variable].dims != ("particle",):
            known = [name for name in frame.data_vars if frame[name].dims == ("particle",)]
            raise ValueError(
                f"`{variable}`: is no variable of the particles, must be one of {', '.join(map(str, known))}, speed"
            )
        return frame[variable].values.astype(float)

    def grid(
        self, variable: str, spacing: float | None = None, bounds: Sequence[Sequence[float]] | None = None
    ) -> xr.DataArray:
        """Returns a variable on a regular grid, NaN outside the flow.

        Parameters
        ----------
        variable: a variable of the particles, or "speed".
        spacing: distance of the grid points, m; None: the spacing of the particles.
        bounds: lower and upper corner of the grid, m; None: the box around the particles of all frames.
        """
        spacing = float(self._data.attrs["spacing"] if spacing is None else spacing)
        if not 0 < spacing < np.inf:
            raise ValueError(f"spacing: is {spacing}, must be a finite number above zero")
        if bounds is None:
            lower, upper = self.bounds()
        else:
            lower, upper = (list(map(float, corner)) for corner in bounds)
        if len(lower) != len(self.axes) or any(a >= b for a, b in zip(lower, upper)):
            raise ValueError(
                f"bounds: are {lower} and {upper}, must be a lower and an upper corner in {len(self.axes)}D"
            )
        # Points on multiples of the spacing, so that grids of several runs agree.
        ticks = [spacing * np.arange(np.ceil(a / spacing), np.floor(b / spacing) + 0.5) for a, b in zip(lower, upper)]
        shape = tuple(len(axis) for axis in reversed(ticks))
        mesh = np.meshgrid(*reversed(ticks), indexing="ij")
        points = np.column_stack([axis.ravel() for axis in reversed(mesh)])
        coordinates = {name: (name, axis, {"units": "m"}) for name, axis in zip(self.axes, ticks)}
        values = [self._sampled(frame, self._near(frame, points), variable).reshape(shape) for frame in self.frames()]
        return self._stacked(values, tuple(reversed(self.axes)), coordinates, variable)

    def profile(
        self, start: Sequence[float], end: Sequence[float], n: int = 101, variables: Sequence[str] | None = None
    ) -> xr.Dataset:
        """Returns the fields at `n` points from `start` to `end`, m, over the distance from `start`."""
        ends = np.asarray([start, end], dtype=float)
        if ends.shape != (2, len(self.axes)):
            raise ValueError(f"start, end: are {start} and {end}, must be points in {len(self.axes)}D")
        if n != int(n) or n < 2:
            raise ValueError(f"n: is {n}, must be a whole number from 2")
        points = ends[0] + np.linspace(0, 1, int(n))[:, np.newaxis] * (ends[1] - ends[0])
        along = np.linalg.norm(points - points[0], axis=1)
        names = variables or [*VELOCITIES[: len(self.axes)], "speed", "pressure", "density"]
        coordinates = {"distance": ("distance", along, {"units": "m"})}
        coordinates |= {name: ("distance", points[:, axis], {"units": "m"}) for axis, name in enumerate(self.axes)}
        values: dict[str, list[Any]] = {name: [] for name in names}
        for frame in self.frames():
            near = self._near(frame, points)
            for name in names:
                values[name].append(self._sampled(frame, near, name))
        fields = {name: self._stacked(values[name], ("distance",), coordinates, name) for name in names}
        return xr.Dataset(fields)

    def track(
        self, id: int | Sequence[int], passage: int | None = None, zones: Sequence[str] = ("fluid",)
    ) -> xr.Dataset:
        """Returns the trajectory of a piece of fluid over all frames, NaN where it is not in the flow.

        It is the row of `tracks.nc` with the same number. A particle that leaves and enters again is another piece of
        fluid, of another `passage`, so the history of a particle number may be several trajectories.

        Parameters
        ----------
        id: number of the particle; with several numbers, the dataset has the dimension `trajectory`.
        passage: times that the particle had entered again; None: the only one, or for several numbers all of them.
        zones: zones in which the particle has a trajectory, as `flag_meanings` of `zone` names them.
        """
        return track(self._data, id, passage, zones)

    def plot(
        self,
        variable: str = "speed",
        *,
        ax: Any = None,
        slab: tuple[str, float] | None = None,
        size: float | None = None,
        **options: Any,
    ) -> Any:
        """Draws the particles of a frame, coloured by a variable, with the walls; returns the axes of matplotlib.

        Without a choice it draws the last frame. In 3D it draws the particles within half a spacing of a plane:
        `slab=("z", 0.0)`, by default the middle of z. `options` go to `scatter`.
        """
        pyplot = needs("matplotlib.pyplot", "plot", "plotting")
        data = self._data.isel(time=-1) if "time" in self._data.dims else self._data
        frame = next(ParticlesAccessor(data).frames())
        shown = self.axes
        keep = np.ones(frame.sizes["particle"], dtype=bool)
        walls = all(f"wall_{axis}" in data for axis in shown)
        of_wall = np.ones(data.sizes.get("wall", 0), dtype=bool)
        if len(shown) == 3:
            normal, at = slab or ("z", float(frame.z.min() + frame.z.max()) / 2)
            if normal not in shown:
                raise ValueError(f"slab: is {slab}, must be an axis and its position, as ('z', 0.0)")
            half = 0.5 * data.attrs["spacing"]
            keep = np.abs(frame[normal].values - at) <= half
            of_wall = np.abs(data[f"wall_{normal}"].values - at) <= half if walls else of_wall
            shown = tuple(axis for axis in shown if axis != normal)
        elif slab is not None:
            raise ValueError("slab: the flow is in 2D, must be left out")
        ax = ax or pyplot.subplots(figsize=(9, 4), layout="constrained")[1]
        first, second = shown
        size = size or 4.0
        if walls:
            ax.scatter(
                data[f"wall_{first}"][of_wall], data[f"wall_{second}"][of_wall], s=size, color="0.7", linewidths=0
            )
        values = self.value(frame, variable)[keep]
        dots = ax.scatter(frame[first][keep], frame[second][keep], c=values, s=size, linewidths=0, **options)
        units = self._units(variable)
        ax.figure.colorbar(dots, ax=ax, label=f"{variable} [{units}]" if units else variable)
        ax.set(aspect="equal", xlabel=f"{first} [m]", ylabel=f"{second} [m]", title=f"t = {float(data.time):.4g} s")
        return ax

    def _near(self, frame: xr.Dataset, points: Any) -> Neighbours:
        attributes = self._data.attrs
        positions = np.column_stack([frame[axis].values for axis in self.axes])
        return Neighbours(
            positions, points, float(attributes["smoothing_length"]), REACH * float(attributes["spacing"])
        )

    def _sampled(self, frame: xr.Dataset, near: Neighbours, variable: str) -> Any:
        if variable == "speed":
            # A fit of the speed itself would be negative next to a wall.
            parts = [near.sample(self.value(frame, name), quadratic=True) for name in VELOCITIES[: len(self.axes)]]
            return np.sqrt(sum(part**2 for part in parts))
        return near.sample(self.value(frame, variable), quadratic=variable in VELOCITIES)

    def _units(self, variable: str) -> str:
        source = self._data.get("u" if variable == "speed" else variable)
        return "" if source is None else source.attrs.get("units", "")

    def _stacked(
        self,
        values: list[Any],
        dims: tuple[str, ...],
        coordinates: dict[str, Any],
        variable: str,
    ) -> xr.DataArray:
        """Returns sampled values with their coordinates, with a dimension of time if the dataset has one."""
        attributes = {
            "units": self._units(variable),
            "long_name": "speed" if variable == "speed" else self._data[variable].attrs.get("long_name", variable),
        }
        if "time" not in self._data.dims:
            return xr.DataArray(values[0], coordinates | {"time": self._data.time}, dims, variable, attributes)
        return xr.DataArray(
            np.stack(values), coordinates | {"time": self._data.time}, ("time", *dims), variable, attributes
        )

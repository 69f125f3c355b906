"""Frames of a run under way as arrays that are read when they are used.

A run writes one file per frame into its journal. When it ends, `particles.nc` replaces them; an array then reads from that
file, whose frames have the same order.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

from . import _sphecs


class JournalArray(BackendArray):
    """Variable of all frames; a frame is read for every access to it."""

    def __init__(self, frames: list[Path], name: str, like: xr.Variable) -> None:
        self.frames = frames
        self.name = name
        self.dtype = like.dtype
        self.shape = (len(frames), *like.shape[1:])

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        support = indexing.IndexingSupport.OUTER
        return indexing.explicit_indexing_adapter(key, self.shape, support, self._read)

    def _read(self, key: tuple[Any, ...]) -> Any:
        times, *rest = key
        chosen = np.arange(len(self.frames))[times]
        if np.ndim(chosen) == 0:
            return self._frame(int(chosen), tuple(rest))
        frames = [self._frame(int(index), tuple(rest)) for index in chosen]
        return np.stack(frames) if frames else self._frame(0, tuple(rest))[np.newaxis][:0]

    def _frame(self, index: int, key: tuple[Any, ...]) -> Any:
        path = self.frames[index]
        try:
            with xr.open_dataset(path) as data:
                values = data[self.name].values[0]
        except FileNotFoundError:
            # The run has ended in the meantime.
            with xr.open_dataset(path.parent.parent / "particles.nc") as data:
                values = data[self.name].isel(time=index).values
        return self._padded(values)[key]

    def _padded(self, values: Any) -> Any:
        """Returns the values with absent slots behind: the reservoir may have grown after the frame."""
        if values.shape == self.shape[1:]:
            return values
        filler = np.nan if self.dtype.kind == "f" else ABSENT if self.name == "zone" else 0
        padded = np.full(self.shape[1:], filler, self.dtype)
        count = min(len(values), len(padded))
        padded[:count] = values[:count]
        return padded


#: Zone of a slot without a particle.
ABSENT = 255


def open_journal(folder: Path) -> xr.Dataset:
    """Returns the frames of a journal as a dataset in the layout of `particles.nc`."""
    found, walls = _sphecs.journal_frames(folder)
    frames = [Path(path) for path in found]
    if not frames:
        raise FileNotFoundError(f"{folder}: has no frames yet")
    times: dict[str, list[Any]] = {"time": [], "step": [], "time_step": []}
    for path in frames:
        with xr.open_dataset(path) as data:
            for series, values in times.items():
                values.append(data[series].values[0])
    with xr.open_dataset(frames[-1]) as data:
        last = data.load()
    variables: dict[str, xr.Variable] = {}
    for name, variable in last.variables.items():
        if name in times:
            variables[str(name)] = xr.Variable("time", np.asarray(times[str(name)]), variable.attrs)
        elif "time" in variable.dims:
            lazy = indexing.LazilyIndexedArray(JournalArray(frames, str(name), variable))
            variables[str(name)] = xr.Variable(variable.dims, lazy, variable.attrs, variable.encoding)
        else:
            variables[str(name)] = variable
    if Path(walls).exists():
        with xr.open_dataset(walls) as data:
            fixed = data.load()
        variables.update({str(name): v for name, v in fixed.variables.items() if v.dims == ("wall",)})
    coordinates = {name: variables.pop(name) for name in map(str, last.coords)}
    return xr.Dataset(variables, coordinates, last.attrs)

"""Trajectories of pieces of fluid, from the particles of a run or from its `tracks.nc`.

Both have the same identity: the number of a trajectory is passage * 10**10 + particle_id.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

#: Factor of the passage in the number of a trajectory, above every particle number.
PASSAGE = 10**10

#: Zones in which a particle may have a trajectory; walls have one if they move.
ZONES = {"fluid": 0, "wall": 1, "inflow": 2, "outflow": 3}

#: Zone of a trajectory where it has no sample.
ABSENT = 255


def track(data: xr.Dataset, id: int | Sequence[int], passage: int | None, zones: Sequence[str]) -> xr.Dataset:
    """Returns the trajectory of one particle number, or those of several, over all frames."""
    wrong = [zone for zone in zones if zone not in ZONES]
    if wrong or isinstance(zones, str) or not len(zones):
        raise ValueError(f"zones: are {zones!r}, must be a list of {', '.join(ZONES)}")
    ids = np.unique(np.atleast_1d(np.asarray(id)))
    chosen = _rows(data, ids) if "trajectory" in data.dims else _histories(data, ids, zones)
    if passage is not None:
        chosen = chosen.isel(trajectory=np.flatnonzero(chosen.passage.values == passage))
    absent = sorted(set(ids.tolist()) - set(chosen.particle_id.values.tolist()))
    if absent:
        which = "" if passage is None else f" with the passage {passage}"
        raise KeyError(
            f"particle {absent}: is in none of these frames in {', '.join(zones)}{which}; give other numbers or zones"
        )
    if np.ndim(id):
        return chosen
    if chosen.sizes["trajectory"] > 1:
        found = ", ".join(map(str, chosen.passage.values))
        raise ValueError(f"particle {id}: was a piece of fluid more than once, choose a passage: {found}")
    return chosen.isel(trajectory=0)


def _rows(tracks: xr.Dataset, ids: Any) -> xr.Dataset:
    """Returns the trajectories of some particle numbers of `tracks.nc`."""
    return tracks.isel(trajectory=np.flatnonzero(np.isin(tracks.particle_id.values, ids)))


def _histories(data: xr.Dataset, ids: Any, zones: Sequence[str]) -> xr.Dataset:
    """Returns the trajectories of some particle numbers from the slots of `particles.nc`."""
    data = data if "time" in data.dims else data.expand_dims("time")
    slots = np.flatnonzero(np.isin(data.particle_id.values, ids))
    names = [str(name) for name, variable in data.variables.items() if variable.dims == ("time", "particle")]
    slot = data[names].isel(particle=slots).load()
    sampled = np.isin(slot.zone.values, [ZONES[zone] for zone in zones])
    numbers = slot.passage.values.astype(np.int64) * PASSAGE + data.particle_id.values[slots].astype(np.int64)
    trajectories = np.unique(numbers[sampled])
    row = np.searchsorted(trajectories, numbers)[sampled]
    shape = (len(trajectories), slot.sizes["time"])
    variables = {}
    for name in names:
        if name == "passage" or (name == "zone" and tuple(zones) == ("fluid",)):
            continue
        values = np.full(shape, ABSENT if name == "zone" else np.nan, slot[name].dtype)
        values[row, np.nonzero(sampled)[0]] = slot[name].values[sampled]
        variables[name] = xr.Variable(("trajectory", "time"), values, slot[name].attrs)
    coordinates = {
        "trajectory": ("trajectory", trajectories, {"units": "1", "long_name": "number of the trajectory"}),
        "particle_id": ("trajectory", (trajectories % PASSAGE).astype("u4"), data.particle_id.attrs),
        "passage": ("trajectory", (trajectories // PASSAGE).astype("u4"), slot.passage.attrs),
        "time": data.time,
    }
    places = {name: variables.pop(name) for name in ("x", "y", "z") if name in variables}
    return xr.Dataset(variables, coordinates | places, data.attrs)

"""Results of a parameter sweep as one tree of datasets."""

from __future__ import annotations

import csv
import os
from pathlib import Path
from typing import TYPE_CHECKING

from ._exceptions import needs

if TYPE_CHECKING:
    import xarray as xr


def open_sweep(folder: str | os.PathLike[str], file: str = "monitor.nc") -> xr.DataTree:
    """Opens a file of all runs of `sphecs sweep` that have it.

    A node has the name of the run; its attributes are those of the file and the values of the run, as numbers
    where they are numbers.
    """
    xarray = needs("xarray", "results", "reading results")
    needs("netCDF4", "results", "reading results")
    index = Path(folder) / "sweep.csv"
    if not index.exists():
        raise FileNotFoundError(f"{index} does not exist: {folder} is not the folder of a sweep")
    tree = xarray.DataTree(name=Path(folder).name)
    with index.open(newline="", encoding="utf-8") as lines:
        for line in csv.DictReader(lines):
            path = index.parent / line["run"] / file
            if path.exists():
                values = {name: _number(text) for name, text in line.items() if name != "run"}
                run = xarray.open_datatree(path)
                run.attrs.update(values)
                tree[line["run"]] = run
    return tree


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text

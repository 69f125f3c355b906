"""Results of a run as xarray datasets, also of a run that is under way."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _sphecs
from ._exceptions import needs

if TYPE_CHECKING:
    import xarray as xr

#: Files of a run that its tables are made from.
SOURCES = ("scene.ron", "summary.json", "tables.json", "monitor.csv", "forces.csv", "probes_points.csv")


def open_run(folder: str | os.PathLike[str]) -> Run:
    """Opens the results of a run, which may be under way."""
    return Run(folder)


class Run:
    """Results of a run.

    Every access reads the files as they are: `run.particles` of a run under way has the frames written so far.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        #: Folder of the run.
        self.folder = Path(folder)
        self.summary  # noqa: B018 - a folder without a run is refused here

    def __repr__(self) -> str:
        summary = self.summary
        if summary["status"] == "running" and (self.folder / "journal").exists():
            # The summary has its numbers when the run ends.
            frames, _ = _sphecs.journal_frames(self.folder)
            return f"<sphecs.Run {str(self.folder)!r}: running or killed, {len(frames)} frames>"
        return (
            f"<sphecs.Run {str(self.folder)!r}: {summary['status']}, {summary['steps']} steps, "
            f"t = {summary['time']:.6g} s, {summary['frames']} frames>"
        )

    @property
    def summary(self) -> dict[str, Any]:
        """Contents of `summary.json`: status, steps, counts, wall times, notes and the properties of the run."""
        return json.loads(_sphecs.run_summary(self.folder))

    @property
    def status(self) -> str:
        """State: "running", "completed", "interrupted", "terminated", "out of time", "diverged" or "failed".

        A run that was killed is "running", too.
        """
        return self.summary["status"]

    @property
    def notes(self) -> list[str]:
        """Notes on choices and flow states that may not be meant."""
        return self.summary.get("notes", [])

    @property
    def scene(self) -> str:
        """Text of the scene as run."""
        return (self.folder / "scene.ron").read_text(encoding="utf-8")

    @property
    def is_packed(self) -> bool:
        """True if the run has ended and its frames are in `particles.nc`."""
        return (self.folder / "particles.nc").exists() and not (self.folder / "journal").exists()

    @property
    def particles(self) -> xr.Dataset:
        """Particles of all frames; values are read when they are used."""
        if self.is_packed:
            return self._open("particles.nc")
        self._xarray()
        from ._journal import open_journal

        return open_journal(self.folder)

    @property
    def monitor(self) -> xr.Dataset:
        """Integral quantities over time."""
        return self._table("monitor.nc")

    @property
    def probes(self) -> xr.DataTree:
        """Probes: one group each, with its own times."""
        return self._table("probes.nc", tree=True)

    @property
    def forces(self) -> xr.DataTree:
        """Forces on bodies: one group each."""
        return self._table("forces.nc", tree=True)

    @property
    def fields(self) -> xr.Dataset:
        """Fields on a grid and their means, if the scene asks for them; planes are groups of `fields.nc`."""
        return self._open("fields.nc")

    @property
    def walls(self) -> xr.Dataset:
        """Pressure and shear stress at the walls and their means, if the scene asks for them."""
        return self._open("walls.nc")

    def _xarray(self) -> Any:
        xarray = needs("xarray", "results", "reading results")
        needs("netCDF4", "results", "reading results")
        from . import accessor  # noqa: F401 - adds `Dataset.sphecs`

        return xarray

    def _open(self, name: str, tree: bool = False, folder: Path | None = None) -> Any:
        xarray = self._xarray()
        path = (folder or self.folder) / name
        if not path.exists():
            raise FileNotFoundError(f"{path} does not exist: the scene writes none, or the run is under way")
        return (xarray.open_datatree if tree else xarray.open_dataset)(path)

    def _table(self, name: str, tree: bool = False) -> Any:
        """Opens a table; that of a run under way is made from a copy of its rows."""
        if self.is_packed:
            return self._open(name, tree)
        self._xarray()
        with tempfile.TemporaryDirectory(prefix="sphecs-") as copied:
            copy = Path(copied)
            for source in SOURCES:
                if (self.folder / source).exists():
                    shutil.copy(self.folder / source, copy / source)
            for source in ("probes", "meshes"):
                if (self.folder / source).is_dir():
                    shutil.copytree(self.folder / source, copy / source)
            _sphecs.pack(copy)
            with self._open(name, tree, copy) as data:
                return data.load()

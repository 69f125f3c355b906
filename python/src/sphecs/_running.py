"""Functions that run and check a scene as the command line does."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from . import _sphecs
from ._exceptions import Fault
from ._forces import Force, force_functions
from ._results import Run, open_run
from ._scene import SceneLike, scene_input


def run(
    scene: SceneLike,
    *,
    set: Mapping[str, Any] | None = None,
    forces: Force | Iterable[Force] = (),
    smoke: bool = False,
    until: float | None = None,
    steps: int | None = None,
    out: str | os.PathLike[str] | None = None,
    force: bool = False,
    threads: int | None = None,
    ranks: int | None = None,
    checkpoint_every: float | None = None,
    max_walltime: float | None = None,
    allow_oversize: bool = False,
    verbosity: str = "quiet",
    name: str | None = None,
) -> Run:
    """Runs a scene to its end and returns its results.

    The options are those of `sphecs run`. Ctrl-C finishes the step, writes a checkpoint, closes the files and raises
    `KeyboardInterrupt`; `sphecs resume` continues such a run.

    Parameters
    ----------
    scene: path or text of a scene file, or a dictionary (see `sphecs.variant`).
    set: changes of the scene, as `{"fluid.sound_speed": 1.0, "outlets.0.condition": "Mirror()"}`; text is taken as on the
        command line.
    forces: functions that return the acceleration of the fluid particles, as those of `sphecs.Simulation`. An exception
        ends the run, whose files stay. `sphecs resume` refuses a run with forces, which it would lack.
    smoke: take the coarse smoke spacing of the scene.
    until: end, s; None: that of the scene.
    steps: largest number of steps.
    out: folder of the results; None: `runs/` and the name of the scene.
    force: replace an earlier run in the folder.
    threads: number of threads of each rank; None: one for each core, shared among the ranks. The results do not depend
        on it.
    ranks: number of groups of threads that share the flow, each with a domain of its own; None: one. The results do not
        depend on it. Forces need one rank.
    checkpoint_every: wall time between checkpoints, s.
    max_walltime: wall time after which the run stops, s; it returns with `status` "out of time".
    allow_oversize: start although memory or disk space look too small.
    verbosity: "quiet", "normal" or "verbose", text on the standard output of the process.
    name: name of a scene given as text or dictionary.

    Raises
    ------
    SceneError: the scene has faults. RunError: the flow diverged, a file cannot be written, …
    """
    if verbosity not in ("quiet", "normal", "verbose"):
        raise ValueError(f"verbosity: is `{verbosity}`, must be `quiet`, `normal` or `verbose`")
    given = scene_input(scene, set, smoke, name)
    options: dict[str, Any] = {
        "out": None if out is None else os.fspath(out),
        "force": force,
        "threads": count(threads, "threads"),
        "ranks": count(ranks, "ranks"),
        "until": positive(until, "until"),
        "steps": count(steps, "steps"),
        "checkpoint_every": positive(checkpoint_every, "checkpoint_every"),
        "max_walltime": positive(max_walltime, "max_walltime"),
        "allow_oversize": allow_oversize,
        "verbosity": verbosity,
    }
    return open_run(_sphecs.run(given, force_functions(forces), options))


@dataclass(frozen=True)
class Report:
    """Report on a scene before its run."""

    #: Table and notes, or the message on the faults, as `sphecs check` prints them.
    text: str
    #: Faults, for which the scene cannot be run.
    faults: tuple[Fault, ...]
    #: Notes on choices that may not be meant.
    notes: tuple[str, ...]

    @property
    def ok(self) -> bool:
        """True if the scene can be run."""
        return not self.faults

    def __str__(self) -> str:
        return self.text


def check(
    scene: SceneLike,
    *,
    set: Mapping[str, Any] | None = None,
    smoke: bool = False,
    until: float | None = None,
    threads: int | None = None,
    timed: bool = True,
    name: str | None = None,
) -> Report:
    """Checks a scene and returns its faults or its figures, cost and notes, as `sphecs check` does.

    `timed=False` leaves out the first steps of the flow, by which the run time is measured.
    """
    given = scene_input(scene, set, smoke, name)
    found = _sphecs.check(given, positive(until, "until"), count(threads, "threads"), timed)
    return Report(found["text"], tuple(Fault(**fault) for fault in found["faults"]), tuple(found["notes"]))


def positive(value: float | None, name: str) -> float | None:
    """Returns a finite number above zero."""
    if value is None:
        return None
    if not 0 < value < float("inf"):
        raise ValueError(f"{name}: is {value}, must be a finite number above zero")
    return float(value)


def count(value: int | None, name: str) -> int | None:
    """Returns a whole number above zero."""
    if value is None:
        return None
    if value != int(value) or value < 1:
        raise ValueError(f"{name}: is {value}, must be a whole number from 1")
    return int(value)

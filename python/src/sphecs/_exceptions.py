"""Exceptions, with the messages of the command line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Fault:
    """One fault of a scene."""

    #: Description in one line.
    message: str
    #: File or text that has it.
    file: str
    #: Line from 1; None for a fault without a place.
    line: int | None
    #: Column from 1, in characters.
    column: int | None
    #: Value found and values allowed.
    found: str
    #: Advice on how to correct it.
    help: str | None

    def __str__(self) -> str:
        place = self.file if self.line is None else f"{self.file}:{self.line}:{self.column}"
        return f"{place}: {self.message}" + (f": {self.found}" if self.found else "")


class SphecsError(Exception):
    """Base of the exceptions of this package."""


class SceneError(SphecsError, ValueError):
    """A scene has faults; the message shows all of them with their lines."""

    def __init__(self, message: str, faults: Sequence[Mapping[str, Any]] = ()) -> None:
        super().__init__(message)
        #: The faults, in the order of the text.
        self.faults: tuple[Fault, ...] = tuple(Fault(**fault) for fault in faults)


class RunError(SphecsError, RuntimeError):
    """A run or simulation was stopped by an error, or cannot start."""

    def __init__(self, message: str, reason: str = "", step: int | None = None, time: float | None = None) -> None:
        super().__init__(message)
        #: Reason for programs: "diverged", "drained", "reservoir empty", "exists", "foreign", "busy", "not a run",
        #: "request", "disk", "files", "build", "threads", "ended" or "internal".
        self.reason = reason
        #: Step at which the flow stopped; None for other reasons.
        self.step = step
        #: Time at which the flow stopped, s; None for other reasons.
        self.time = time


class StaleStateError(SphecsError, RuntimeError):
    """The state belongs to a step that the simulation has left."""


class MissingPackageError(SphecsError, ImportError):
    """A package is needed that `sphecs` alone does not install."""


def needs(package: str, extra: str, what: str) -> Any:
    """Returns a module, or raises an error that says how to install it."""
    import importlib

    try:
        return importlib.import_module(package)
    except ImportError as error:
        raise MissingPackageError(
            f"{what} needs {package}, which is not installed: pip install 'sphecs[{extra}]'"
        ) from error

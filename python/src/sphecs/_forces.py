"""Forces that functions of the caller compute for all fluid particles."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Floats: TypeAlias = npt.NDArray[np.float64]

#: Acceleration (n, dimensions), m/s², of all fluid particles from time, s, position, m, and velocity, m/s.
Force: TypeAlias = Callable[[float, Floats, Floats], npt.ArrayLike]


def force_functions(forces: Force | Iterable[Force]) -> list[Force]:
    """Returns one or several functions as a list."""
    functions = [forces] if callable(forces) else list(forces)
    for function in functions:
        if not callable(function):
            raise TypeError(f"forces: has {function!r}, must be functions of time, position and velocity")
    return functions

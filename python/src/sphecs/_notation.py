"""Scenes and values written in Python, as the text of the scene file.

| Python | scene file |
|---|---|
| `{"density": 1000.0}` | `(density: 1000.0)` |
| `{"Box": {"min": (0, 0), "max": (1, 1)}}` | `Box(min: (0, 0), max: (1, 1))` |
| `{"Normal": 0.1}`, `{"Union": [a, b]}` | `Normal(0.1)`, `Union([a, b])` |
| `variant("Cylinder", centre=(0, 0), radius=1)` | `Cylinder(centre: (0, 0), radius: 1)` |
| `"WaveEquation"`, `"2*D"` | `"WaveEquation"`, `"2*D"` |
| list, tuple, NumPy array | `[…]`, `(…)`, `(…)` |
| `None` | the field is left out |

A dictionary with one key that begins with a capital letter is a choice with its name, whose content is one value or named
fields; `variant` takes several values, too. The keys of `constants` are names of
constants, whatever they begin with.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np


class Variant:
    """A choice of the scene file with its content: `variant("Normal", 0.1)` is `Normal(0.1)`."""

    __slots__ = ("content", "fields", "name")

    def __init__(self, name: str, *content: Any, **fields: Any) -> None:
        if not name.isidentifier():
            raise ValueError(f"variant: the name is `{name}`, must be a name as `WaveEquation`")
        if content and fields:
            raise ValueError(f"variant {name}: has values and named fields, must have one kind of them")
        self.name = name
        self.content = content
        self.fields = fields

    def __repr__(self) -> str:
        return text_of(self)


def variant(name: str, *content: Any, **fields: Any) -> Variant:
    """Returns a choice of the scene file: `variant("Box", min=(0, 0), max=(1, 1))`."""
    return Variant(name, *content, **fields)


def scene_text(scene: Mapping[str, Any]) -> str:
    """Returns the text of a scene that is a dictionary."""
    return "Scene" + fields_of(scene, "the scene", 0) + "\n"


def text_of(value: Any, where: str = "the value", depth: int = 0) -> str:
    """Returns a value in the notation of the scene file."""
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        if not math.isfinite(value):
            raise ValueError(f"{where}: is {value}, must be finite")
        return repr(float(value))
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, Variant):
        if value.fields:
            return value.name + fields_of(value.fields, f"{where}.{value.name}", depth)
        return value.name + sequence(value.content, where, depth, "()")
    if isinstance(value, Mapping):
        return mapping(value, where, depth)
    if isinstance(value, np.ndarray):
        if value.ndim == 0:
            return text_of(value.item(), where, depth)
        return sequence(list(value), where, depth, "()" if value.ndim == 1 else "[]")
    if isinstance(value, tuple):
        return sequence(value, where, depth, "()")
    if isinstance(value, list):
        return sequence(value, where, depth, "[]")
    kind = type(value).__name__
    raise TypeError(
        f"{where}: is of type {kind}, must be a number, text, dictionary, list, tuple, array or `variant(…)`"
    )


def mapping(value: Mapping[Any, Any], where: str, depth: int) -> str:
    """Returns a dictionary as a struct, or as a choice."""
    if is_choice(value):
        name, content = next(iter(value.items()))
        if content is None:
            return name
        if isinstance(content, Mapping) and not is_choice(content):
            return name + fields_of(content, f"{where}.{name}", depth)
        return name + sequence((content,), f"{where}.{name}", depth, "()")
    return fields_of(value, where, depth)


def is_choice(value: Mapping[Any, Any]) -> bool:
    """Returns true for one key that begins with a capital letter."""
    keys = list(value)
    return len(keys) == 1 and isinstance(keys[0], str) and keys[0][:1].isupper()


def fields_of(value: Mapping[Any, Any], where: str, depth: int) -> str:
    """Returns named fields in brackets; None leaves a field out."""
    lines = []
    for key, content in value.items():
        if not isinstance(key, str) or not key.isidentifier():
            raise ValueError(f"{where}: has a field `{key}`, must have names as `sound_speed`")
        if content is None:
            continue
        inner = key if where == "the scene" else f"{where}.{key}"
        if key == "constants" and depth == 0 and isinstance(content, Mapping):
            entries = [f"{quoted(str(name))}: {text_of(number, inner, depth + 2)}" for name, number in content.items()]
            lines.append(f"{key}: {block(entries, depth + 1, '{}')}")
        else:
            lines.append(f"{key}: {text_of(content, inner, depth + 1)}")
    return block(lines, depth, "()")


def sequence(values: Any, where: str, depth: int, brackets: str) -> str:
    return block([text_of(value, f"{where}.{index}", depth + 1) for index, value in enumerate(values)], depth, brackets)


#: Longest line of a short list, characters.
SHORT = 80


def block(parts: list[str], depth: int, brackets: str) -> str:
    """Returns parts in brackets, on one line if they are short, so that messages show little."""
    line = ", ".join(parts)
    if len(line) + 4 * depth <= SHORT and "\n" not in line:
        return brackets[0] + line + brackets[1]
    indent = "    " * (depth + 1)
    inner = "".join(f"{indent}{part},\n" for part in parts)
    return f"{brackets[0]}\n{inner}{'    ' * depth}{brackets[1]}"


def quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n").replace("\t", "\\t")
    return f'"{escaped}"'


def sets_of(values: Mapping[str, Any] | None) -> list[tuple[str, str]]:
    """Returns changes of a scene as paths and texts; text is taken as on the command line."""
    if values is None:
        return []
    if not isinstance(values, Mapping):
        raise TypeError("`set` must be a dictionary, as {'fluid.sound_speed': 1.0}")
    return [(str(path), value if isinstance(value, str) else text_of(value, path)) for path, value in values.items()]

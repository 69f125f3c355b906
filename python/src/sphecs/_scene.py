"""Scenes as the package takes them: a path, a text or a dictionary."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, TypeAlias, TypedDict

from ._notation import scene_text, sets_of

#: Path or text of a scene file, or the scene as a dictionary.
SceneLike: TypeAlias = "str | os.PathLike[str] | Mapping[str, Any]"


class SceneInput(TypedDict):
    """Scene as the compiled module takes it."""

    path: str | None
    name: str
    text: str
    sets: list[tuple[str, str]]
    smoke: bool


def scene_input(scene: SceneLike, changes: Mapping[str, Any] | None, smoke: bool, name: str | None) -> SceneInput:
    """Returns the scene with its changes."""
    given: SceneInput = {"path": None, "name": name or "scene", "text": "", "sets": sets_of(changes), "smoke": smoke}
    if isinstance(scene, Mapping):
        given["text"] = scene_text(scene)
    elif isinstance(scene, str) and is_text(scene):
        given["text"] = scene
    elif isinstance(scene, (str, os.PathLike)):
        if name is not None:
            raise TypeError("`name` names a scene given as text or dictionary; a file has its own")
        given["path"] = os.fspath(scene)
    else:
        kind = type(scene).__name__
        raise TypeError(f"the scene is of type {kind}, must be a path, the text of a scene file or a dictionary")
    return given


def is_text(scene: str) -> bool:
    """Returns true for the text of a scene; a path has one line and begins with no bracket."""
    return "\n" in scene or scene.lstrip().startswith(("Scene(", "("))

# SPDX-License-Identifier: GPL-3.0-or-later
"""Which model is used: the library's, else the one of the preferences, else the shipped one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy

if TYPE_CHECKING:
    from shapegoogle_core import ShapeModel

__all__ = ["clear", "current_model"]

_loaded: dict[tuple[str, float], ShapeModel] = {}


def current_model(context: Any) -> ShapeModel:
    """Return the model of the chosen library; without one, that of the preferences.

    Parameters
    ----------
    context : bpy.types.Context

    Returns
    -------
    model : ShapeModel
        Loaded once, and again when its file has changed.

    Raises
    ------
    ModelError, LibraryError
        If the file cannot be read.
    """
    from shapegoogle_core import Library, load_model

    library = bpy.path.abspath(getattr(context.window_manager.shape_google, "library", ""))
    if library and Path(library).is_file():
        return _once(library, lambda: _model_of(Library, library))
    addon = context.preferences.addons.get(__package__)
    chosen = bpy.path.abspath(getattr(getattr(addon, "preferences", None), "model", "")) or "default"
    return _once(chosen, lambda: load_model(chosen))


def clear() -> None:
    """Forget loaded models."""
    _loaded.clear()


def _model_of(opener: Any, path: str) -> ShapeModel:
    with opener.open(path, read_only=True) as library:
        model: ShapeModel = library.model
    return model


def _once(path: str, load: Any) -> ShapeModel:
    key = path, Path(path).stat().st_mtime if Path(path).is_file() else 0.0
    if key not in _loaded:
        _loaded.clear()
        _loaded[key] = load()
    return _loaded[key]

# SPDX-License-Identifier: GPL-3.0-or-later
"""The model in use: that of the library, else that of the preferences, else the shipped one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import state
from ..preferences import preferences
from .address import is_on_server

if TYPE_CHECKING:
    from shapegoogle_core import ShapeModel

__all__ = ["current_model", "model_source"]


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

    source = model_source(context)
    if isinstance(source, Path):
        return _once(str(source), lambda: _model_of(Library, str(source)))
    return _once(source, lambda: load_model(source))


def model_source(context: Any) -> Path | str:
    """Return the source of `current_model`: a library, or a name or path for `load_model`."""
    chosen = preferences(context)
    if is_on_server(context):
        known = state.current().library.service_model
        # Before the model was downloaded, that of the preferences.
        return known[1] if known is not None and known[0] == chosen.library else str(chosen.model_name())
    library: Path = chosen.library_path()
    return library if library.is_file() else str(chosen.model_name())


def _model_of(opener: Any, path: str) -> ShapeModel:
    with opener.open(path, read_only=True) as library:
        model: ShapeModel = library.model
    return model


def _once(path: str, load: Callable[[], ShapeModel]) -> ShapeModel:
    library = state.current().library
    changed = Path(path).stat().st_mtime if Path(path).is_file() else 0.0
    if library.model is None or library.model[:2] != (path, changed):
        library.model = path, changed, load()
    return library.model[2]

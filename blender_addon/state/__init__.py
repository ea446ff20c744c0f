# SPDX-License-Identifier: GPL-3.0-or-later
"""All that the add-on keeps in memory while it is switched on, in one object.

Values that Blender can show or save are properties of Blender's own data (`session`, `preferences`,
``properties.py`` of the features). The rest is here: processes, computed results, icons, and what must
outlast a change of file. `register` makes the one `State` of a Blender session, `unregister` drops it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from types import ModuleType
from typing import TYPE_CHECKING, Any

from .parts import (
    DuplicatesState,
    GalleryState,
    JobsState,
    LibraryState,
    NewObjectsState,
    ReplacingState,
    SearchState,
    SignatureState,
    TransferState,
)

if TYPE_CHECKING:
    from ..session import SHAPEGOOGLE_PG_session

__all__ = [
    "State",
    "current",
    "is_registered",
    "session_of",
    "start",
    "stop",
]


@dataclass
class State:
    """State of the add-on, by feature.

    Attributes
    ----------
    jobs, library, search, gallery, signature, duplicates, transfer, replacing, new_objects
        Parts that belong to one feature each.
    kept_session : dict or None
        Values of the session while another file is being opened.
    command : object or None
        Blender's handle of `blender --command shape_google`.
    registered : tuple of module
        What was registered, in this order.
    """

    jobs: JobsState = field(default_factory=JobsState)
    library: LibraryState = field(default_factory=LibraryState)
    search: SearchState = field(default_factory=SearchState)
    gallery: GalleryState = field(default_factory=GalleryState)
    signature: SignatureState = field(default_factory=SignatureState)
    duplicates: DuplicatesState = field(default_factory=DuplicatesState)
    transfer: TransferState = field(default_factory=TransferState)
    replacing: ReplacingState = field(default_factory=ReplacingState)
    new_objects: NewObjectsState = field(default_factory=NewObjectsState)
    kept_session: dict[str, Any] | None = None
    command: object = None
    registered: tuple[ModuleType, ...] = ()


class _Holder:
    """Holds the one state between `start` and `stop`."""

    state: State | None = None


def start() -> None:
    """Make the state; for `register`."""
    _Holder.state = State()


def stop() -> None:
    """Drop the state; for `unregister`."""
    _Holder.state = None


def is_registered() -> bool:
    """Whether the add-on is switched on; timers that outlast it must ask."""
    return _Holder.state is not None


def current() -> State:
    """Return the state of the add-on.

    Returns
    -------
    state : State

    Raises
    ------
    RuntimeError
        If the add-on is switched off.
    """
    if _Holder.state is None:
        raise RuntimeError("Shape Google is switched off; enable the add-on in Blender's preferences")
    return _Holder.state


def session_of(context: Any) -> SHAPEGOOGLE_PG_session:
    """Return what Blender itself keeps of this session, as properties on the window manager; see `session`.

    Parameters
    ----------
    context : bpy.types.Context

    Returns
    -------
    session : SHAPEGOOGLE_PG_session
    """
    session: SHAPEGOOGLE_PG_session = context.window_manager.shape_google
    return session

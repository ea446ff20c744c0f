# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison that is shown."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from .turning import Direction

if TYPE_CHECKING:
    from shapegoogle_core.worker.comparison import SurfaceComparison

__all__ = ["Shown"]


@dataclass(eq=False)
class Shown:
    """A query and a match, side by side.

    Attributes
    ----------
    query, match : str
        Their names.
    shape_id : int
        Of the match.
    surfaces : SurfaceComparison or None
        None until they have been compared.
    problem : str
        Why they could not be compared; empty if they could.
    direction : Direction
        From where both are seen.
    zoom : float
    prepared : list or None
        What is drawn of each, made at the first redraw.
    pictures : dict
        Drawn surfaces by what they depend on, so that they are drawn only when they change.
    """

    query: str
    match: str
    shape_id: int
    surfaces: SurfaceComparison | None = None
    problem: str = ""
    direction: Direction = field(default_factory=Direction)
    zoom: float = 1.0
    prepared: list[Any] | None = None
    pictures: dict[int, tuple[Any, Any]] = field(default_factory=dict)

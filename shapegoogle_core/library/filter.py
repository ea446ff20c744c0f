# SPDX-License-Identifier: MIT
"""`Filter`: conditions on the shapes that a search returns."""

from __future__ import annotations

import math
import os
import re
from dataclasses import dataclass
from numbers import Real
from typing import TYPE_CHECKING

from shapegoogle_core.api.arguments import as_tuple, check_number, check_type
from shapegoogle_core.library.evidence import KINDS, EvidenceKind
from shapegoogle_core.library.origin import SHAPE_TYPES, ShapeType

if TYPE_CHECKING:
    from shapegoogle_core.library.placement import Placement

__all__ = ["Filter"]

Range = tuple[float | None, float | None]


@dataclass(frozen=True, kw_only=True)
class Filter:
    """Conditions that every match of a search must meet.

    Kind and similarity are known after the search, all else before it: only shapes that meet these
    conditions are compared. Objects that share a mesh are one shape with several placements; it meets a name
    or a size if one of its placements does.

    Attributes
    ----------
    name : str or None
        Text that the name of the shape contains, ignoring case. With the wildcards ``*`` (any characters) and
        ``?`` (one character) it is a pattern for the whole name.
    text : str or None
        As `name`, but in the name of the shape, its tags and its catalog, or anywhere in the path of its
        source.
    folder : str or None
        Folder that the source of the shape lies in, or in a folder below it; absolute, or relative to the
        working directory.
    sources, not_sources : tuple of str, or None
        Sources that the shape must come from one of, or from none of: paths of files, or labels as they were
        given to `Library.add`.
    tag : str or None
        One of the tags of the shape.
    catalog : str or None
        Path of an asset catalog, such as "Props/Chairs": the shape is in it, or in one below it.
    shape_type : str or None
        What the shape is in its file, one of `SHAPE_TYPES`, such as "collection".
    file_type : str or None
        Ending of the source's name, such as "blend" or ".stl", ignoring case.
    faces : (int or None, int or None) or None
        Least and largest number of faces, both included; None for no limit.
    size : (float or None, float or None) or None
        Least and largest extent of the shape along its longest axis, in units of its file; None for no limit.
    area : (float or None, float or None) or None
        Least and largest area of the shape's surface, in squared units of its file, at any of its placements;
        None for no limit. It stays about the same in every pose.
    kind : str or None
        Kind of the evidence, one of `KINDS`. A search explains as many matches as this needs, up to
        `EvidenceSettings.max_filtered`.
    min_similarity : float or None
        Least similarity, from 0 to 1.

    Raises
    ------
    ValueError
        If a condition is of a wrong type, or cannot be met by any shape: an empty text, a low limit above the
        high limit, a kind that does not exist, a similarity outside 0 to 1.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> chairs = sg.Filter(name="chair", faces=(1_000, None), min_similarity=0.5)
    >>> chairs.faces
    (1000, None)
    >>> sg.Filter(faces=(10, 5))
    Traceback (most recent call last):
    ...
    ValueError: faces must be a range from low to high, not 10 to 5
    """

    name: str | None = None
    text: str | None = None
    folder: str | os.PathLike[str] | None = None
    sources: tuple[str, ...] | None = None
    not_sources: tuple[str, ...] | None = None
    tag: str | None = None
    catalog: str | None = None
    shape_type: ShapeType | None = None
    file_type: str | None = None
    faces: Range | None = None
    size: Range | None = None
    area: Range | None = None
    kind: EvidenceKind | None = None
    min_similarity: float | None = None

    def __post_init__(self) -> None:
        if isinstance(self.folder, os.PathLike):
            object.__setattr__(self, "folder", os.fspath(self.folder))
        for field, sources in (("sources", self.sources), ("not_sources", self.not_sources)):
            if sources is not None:
                listed = as_tuple(field, sources, (str, os.PathLike), "a path or a label, or several")
                object.__setattr__(self, field, tuple(os.fspath(source) for source in listed))
        for field, text in (
            ("name", self.name),
            ("text", self.text),
            ("folder", self.folder),
            ("tag", self.tag),
            ("catalog", self.catalog),
            ("file_type", self.file_type),
        ):
            if text is not None and (not isinstance(text, str) or not text.strip()):
                raise ValueError(
                    f"{field} must be a text that is not empty, not {text!r}; leave it out for any"
                )
        for field, limits in (("faces", self.faces), ("size", self.size), ("area", self.area)):
            if limits is not None:
                _check_range(field, limits)
        if self.kind is not None and self.kind not in KINDS:
            raise ValueError(f"there is no kind of evidence {self.kind!r}; choose one of {', '.join(KINDS)}")
        if self.shape_type is not None and self.shape_type not in SHAPE_TYPES:
            known = ", ".join(SHAPE_TYPES)
            raise ValueError(f"there is no type of shape {self.shape_type!r}; choose one of {known}")
        if self.min_similarity is not None:
            check_number("min_similarity", self.min_similarity, most=1)

    @property
    def selects_shapes(self) -> bool:
        """Whether it has a condition that is known before the search: all but kind and similarity."""
        texts = (self.name, self.text, self.folder, self.sources, self.not_sources, self.tag, self.file_type)
        conditions = (*texts, self.catalog, self.shape_type, self.faces, self.size, self.area)
        return any(condition is not None for condition in conditions)

    def accepts_area(self, area: float) -> bool:
        """Decide whether an area is in the range of the filter.

        Parameters
        ----------
        area : float
            In squared units of the file.

        Returns
        -------
        accepted : bool
        """
        low, high = self.area or (None, None)
        return (low is None or area >= low) and (high is None or area <= high)

    def accepts(self, placement: Placement, area: float) -> bool:
        """Decide whether a placement meets the conditions on the name, the size and the area.

        Parameters
        ----------
        placement : Placement
            With its extents.
        area : float
            Of the surface at that placement.

        Returns
        -------
        accepted : bool
        """
        if self.size is not None and placement.extents is not None:
            low, high = (None if limit is None else float(limit) for limit in self.size)
            largest = max(placement.extents)
            if (low is not None and largest < low) or (high is not None and largest > high):
                return False
        if not self.accepts_area(area):
            return False
        if self.name is None:
            return True
        name, pattern = placement.object_name.casefold(), self.name.casefold()
        if not set(pattern) & {"*", "?"}:
            return pattern in name
        wildcards = {"*": ".*", "?": "."}
        expression = "".join(wildcards.get(character, re.escape(character)) for character in pattern)
        return re.fullmatch(expression, name, re.DOTALL) is not None


def _check_range(field: str, limits: Range) -> None:
    """Raise ValueError if a range has not two limits or contains no number."""
    if not isinstance(limits, tuple | list) or len(limits) != 2:
        raise ValueError(f"{field} must have a low and a high limit, such as (1000, None), not {limits!r}")
    for limit in limits:
        check_type(f"a limit of {field}", limit, (Real, type(None)), "a number or None")
    low, high = (
        default if limit is None else limit for limit, default in zip(limits, (0, math.inf), strict=True)
    )
    if not low >= 0:
        raise ValueError(f"{field} must not be below 0, not {limits[0]}")
    if not low <= high:
        raise ValueError(f"{field} must be a range from low to high, not {limits[0]} to {limits[1]}")

# SPDX-License-Identifier: MIT
"""`Decision`: what a person decided about one or two shapes, which are named by place and content."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import PurePath
from typing import Literal, get_args

__all__ = [
    "DECISION_KINDS",
    "PAIR_KINDS",
    "TAG_KINDS",
    "Decision",
    "DecisionKind",
    "ShapeKey",
    "told_apart",
]

DecisionKind = Literal["not a match", "keep both", "master", "tag", "no tag"]

DECISION_KINDS: tuple[DecisionKind, ...] = get_args(DecisionKind)
"""All kinds of decisions."""

PAIR_KINDS: frozenset[DecisionKind] = frozenset({"not a match", "keep both"})
"""Decisions about two shapes."""

TAG_KINDS: frozenset[DecisionKind] = frozenset({"tag", "no tag"})
"""Decisions that add a tag to a shape, or take one away."""


@dataclass(frozen=True)
class ShapeKey:
    """Name of a shape by its place and content, which survives indexing its file again and moving it.

    Attributes
    ----------
    root, path : str
        Key of its source, see `SourceKey`; both empty for a shape without a source, or from outside the
        library.
    object_name, name : str
        As in `ShapeRecord`.
    file_hash : str
        Hash of the content of its file; empty if it is not known.
    fingerprint : str
        Of its mesh, see `shapegoogle_core.library.decisions.fingerprint`.
    """

    root: str = ""
    path: str = ""
    object_name: str = ""
    name: str = ""
    file_hash: str = ""
    fingerprint: str = ""

    @property
    def title(self) -> str:
        """The name for people: that of the shape, which says more than an object's "Icosphere"."""
        return self.name or self.object_name or "a shape from outside the library"

    def to_json(self) -> dict[str, str]:
        """Convert to an object with ``root``, ``path``, ``object_name`` and ``name``."""
        return {
            "root": self.root,
            "path": self.path,
            "object_name": self.object_name,
            "name": self.name,
        }


@dataclass(frozen=True)
class Decision:
    """What a person decided about one or two shapes of a library.

    Attributes
    ----------
    kind : str
        "not a match": a search with `shape` does not find `other`. "keep both": neither of them is listed as
        a duplicate of the other. "master": `shape` comes first among its duplicates. "tag", "no tag": `shape`
        has the tag, or has it no more, also after its file was indexed again.
    shape : ShapeKey
    other : ShapeKey or None
        The second shape of a pair.
    tag : str
        Empty for other kinds.
    author : str
        May be empty.
    time : float
        In seconds since 1970.
    number : int
        Given by the library, and never to another decision.

    Examples
    --------
    >>> from shapegoogle_core.library.decisions.decision import Decision, ShapeKey
    >>> Decision("master", ShapeKey(path="chairs.blend", object_name="Oak"), author="ana", number=3).sentence
    "'Oak' is the master among its duplicates"
    """

    kind: DecisionKind
    shape: ShapeKey
    other: ShapeKey | None = None
    tag: str = ""
    author: str = ""
    time: float = 0.0
    number: int = 0

    @property
    def titles(self) -> tuple[str, str]:
        """Names of the two shapes for people, told apart by their files; the second may be empty."""
        if self.other is None:
            return self.shape.title, ""
        return told_apart((self.shape.title, self.shape.path), (self.other.title, self.other.path))

    @property
    def sentence(self) -> str:
        """The decision for people."""
        first, second = map(repr, self.titles)
        return {
            "not a match": f"{second} is not a match for {first}",
            "keep both": f"keep both {first} and {second}",
            "master": f"{first} is the master among its duplicates",
            "tag": f"{first} has the tag {self.tag!r}",
            "no tag": f"{first} does not have the tag {self.tag!r}",
        }[self.kind]

    def to_json(self) -> dict[str, object]:
        """Convert to the object that ``shapegoogle decisions --json`` prints.

        Returns
        -------
        record : dict
            ``number``, ``kind``, ``shape``, ``other`` (an object or None), ``tag``, ``author`` and ``time``
            (ISO 8601).
        """
        return {
            "number": self.number,
            "kind": self.kind,
            "shape": self.shape.to_json(),
            "other": None if self.other is None else self.other.to_json(),
            "tag": self.tag,
            "author": self.author,
            "time": datetime.fromtimestamp(self.time, UTC).isoformat(timespec="seconds"),
        }


def told_apart(first: tuple[str, str], second: tuple[str, str]) -> tuple[str, str]:
    """Name two shapes, each with its file if the names alone are the same.

    Parameters
    ----------
    first, second : (str, str)
        Name, and path of the file; empty if it is not known.

    Returns
    -------
    names : (str, str)

    Examples
    --------
    >>> from shapegoogle_core.library.decisions.decision import told_apart
    >>> told_apart(("Cow", "farm/Cow.blend"), ("Calf", "farm/Calf.blend"))
    ('Cow', 'Calf')
    >>> told_apart(("Cow", "farm/Cow.blend"), ("Cow", "farm/herd.blend"))
    ('Cow (Cow.blend)', 'Cow (herd.blend)')
    >>> told_apart(("Cow", "farm/Cow.blend"), ("Cow", "zoo/Cow.blend"))
    ('Cow (farm/Cow.blend)', 'Cow (zoo/Cow.blend)')
    """
    (name, path), (other_name, other_path) = first, second
    parts, other_parts = PurePath(path).parts, PurePath(other_path).parts
    if name != other_name or parts == other_parts:
        return name, other_name
    # As many of the last folders as the two do not have in common.
    count = 1
    while parts[-count:] == other_parts[-count:]:
        count += 1
    return _with_file(name, parts[-count:]), _with_file(other_name, other_parts[-count:])


def _with_file(name: str, parts: tuple[str, ...]) -> str:
    return f"{name} ({PurePath(*parts).as_posix()})" if parts else name

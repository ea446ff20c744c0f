# SPDX-License-Identifier: MIT
"""`DuplicateGroup`: shapes or files of which one would be enough."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass

__all__ = ["NOT_COMPARED", "DuplicateGroup", "DuplicateMember", "largest_saving_first"]


NOT_COMPARED = "not compared"
"""Kind of a group of shapes with similar bags whose surfaces were not compared: they may differ."""

# Largest relative difference of sizes that are called equal.
_EQUAL = 1e-3


@dataclass(frozen=True)
class DuplicateMember:
    """A shape, or a file, of a group.

    Attributes
    ----------
    name, source, object_name : str
        As in `Match`. In a group of copies the file stands for all of its shapes; `name` is the file's.
    shape_id : int
        In a group of copies, id of the file's first shape.
    similarity : float
        To the first member; 1 for itself.
    scale : float
        Linear size relative to the first member, from the areas; 1 if an area is 0.
    placements : int
        Number of objects of its file that show the shape, which are no duplicates; in a group of copies 1.
    """

    name: str
    source: str
    object_name: str
    shape_id: int
    similarity: float
    scale: float
    placements: int = 1

    def to_json(self) -> dict[str, object]:
        """Convert to an element of "members" in `DuplicateGroup.to_json`.

        Returns
        -------
        record : dict
        """
        return asdict(self) | {"similarity": round(self.similarity, 6), "scale": round(self.scale, 6)}


@dataclass(frozen=True)
class DuplicateGroup:
    """Shapes or files of which one would be enough.

    Attributes
    ----------
    kind : str
        "copies": files that are equal byte for byte. Otherwise the kind of evidence, with the first member as
        the query, see `Evidence.kind`; or "not compared": shapes of at least the requested similarity whose
        surfaces were not compared.
    members : tuple of DuplicateMember
        The first one represents the group: the others are compared with it, and follow by falling similarity.
    similarity : float
        Lowest similarity of the members.
    saved_faces : int
        Number of faces of all members but the first.
    saved_bytes : int
        Size of all files but the first in a group of copies; 0 for other kinds, which may be parts of files.

    Examples
    --------
    >>> from shapegoogle_core.library.duplicates.groups import DuplicateGroup, DuplicateMember
    >>> first = DuplicateMember("bolt", "kit.blend", "bolt", 1, similarity=1.0, scale=1.0)
    >>> second = DuplicateMember("bolt.001", "kit.blend", "bolt.001", 2, similarity=0.999, scale=2.0)
    >>> group = DuplicateGroup("scaled", (first, second), similarity=0.999, saved_faces=300)
    >>> group.to_json()["saving"]
    {'faces': 300, 'bytes': 0}
    """

    kind: str
    members: tuple[DuplicateMember, ...]
    similarity: float
    saved_faces: int
    saved_bytes: int = 0

    @property
    def title(self) -> str:
        """The kind for people; of shapes that were not compared, also whether their sizes are equal."""
        equal = all(abs(member.scale - 1) <= _EQUAL for member in self.members)
        return f"{self.kind} (equal size)" if self.kind == NOT_COMPARED and equal else self.kind

    def to_json(self) -> dict[str, object]:
        """Convert to the object that ``shapegoogle duplicates --json`` prints.

        Returns
        -------
        record : dict
            ``kind``, ``similarity``, ``saving`` (``faces``, ``bytes``) and ``members``, each with ``name``,
            ``source``, ``object_name``, ``shape_id``, ``similarity``, ``scale`` and ``placements``.
        """
        return {
            "kind": self.kind,
            "similarity": round(self.similarity, 6),
            "saving": {"faces": self.saved_faces, "bytes": self.saved_bytes},
            "members": [member.to_json() for member in self.members],
        }


def largest_saving_first(groups: Iterable[DuplicateGroup]) -> list[DuplicateGroup]:
    """Sort groups by the faces of all members but the first, then by the bytes.

    Parameters
    ----------
    groups : iterable of DuplicateGroup

    Returns
    -------
    ordered : list of DuplicateGroup
    """
    return sorted(
        groups,
        key=lambda group: (-group.saved_faces, -group.saved_bytes, group.kind, group.members[0].shape_id),
    )

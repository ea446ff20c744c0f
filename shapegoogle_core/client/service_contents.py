# SPDX-License-Identifier: MIT
"""`ServiceContents`: numbers, shapes, pictures and roots of a library behind a service."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any, Self, TypeVar

from shapegoogle_core.api.arguments import as_path, check_count, check_type
from shapegoogle_core.client.connection import Connection, NotThereError, understood
from shapegoogle_core.client.places import Places
from shapegoogle_core.client.records import placement_from, shape_from
from shapegoogle_core.client.values import picture, text
from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.parts.listing import PAGE
from shapegoogle_core.library.placement import Placement
from shapegoogle_core.library.storage.records import Root, ShapeRecord
from shapegoogle_core.library.storage.signature_file import signature_from_bytes
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["AT_ONCE", "ServiceContents", "as_in_library", "portions"]

Function = TypeVar("Function", bound=Callable[..., Any])
Item = TypeVar("Item")

AT_ONCE = 100
"""Shapes that one request is about at most."""


def as_in_library(method: Function) -> Function:
    """Give a method the description of the method of `Library` with its name."""
    method.__doc__ = getattr(Library, method.__name__).__doc__
    return method


def portions(items: Sequence[Item], size: int = AT_ONCE) -> Iterator[Sequence[Item]]:
    """Cut a sequence into pieces."""
    return (items[start : start + size] for start in range(0, len(items), size))


class ServiceContents:
    """What a library behind a service contains; the base of `ServiceLibrary`.

    Parameters
    ----------
    connection : Connection
    info : mapping
        What the service says of itself.
    model : ShapeModel

    Attributes
    ----------
    name : str
        Address of the service.
    """

    def __init__(self, connection: Connection, info: Mapping[str, Any], model: ShapeModel) -> None:
        self._connection = connection
        self.name = str(connection.address)
        self.model = model
        with understood(connection.address):
            self._places = Places([text(name) for name in info["roots"]])
            self._count = int(info["shapes"])
            self._without_views = int(info["without_views"])

    def close(self) -> None:
        """Close the connection; the next request opens another one."""
        self._connection.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"{type(self).__name__}('{self.name}', model {self.model.identifier})"

    def __len__(self) -> int:
        return self._count

    def info(self) -> dict[str, object]:
        """Describe the library in numbers.

        Returns
        -------
        info : dict
            As from `Library.info`, without ``bytes`` and ``schema``; and ``library``, its name on the
            service, and ``version``, that of the service. The ``path`` of a root is where it is on this
            computer, empty where that is not known.

        Raises
        ------
        LibraryError
            If the service does not answer.
        """
        info = self._connection.get("info")
        with understood(self._connection.address):
            self._count, self._without_views = int(info["shapes"]), int(info["without_views"])
            known: dict[str, object] = {name: int(info[name]) for name in ("shapes", "sources", "failed")}
            known |= {name: text(info[name]) for name in ("model", "model_name")}
            return {
                "path": self.name,
                "library": text(info["library"]),
                "version": text(info["version"]),
                **known,
                "code_bits": self.model.code_bits,
                "bag_size": self.model.bag_size,
                "without_views": self._without_views,
                "roots": [{"name": root.name, "path": root.path} for root in self.roots()],
            }

    @as_in_library
    def count_without_views(self) -> int:
        """See `Library.count_without_views`."""
        return self._without_views

    def reindexing_advice(self) -> str:
        """Say what whoever runs the service should do if shapes have no views.

        Returns
        -------
        sentence : str
            Empty if there is nothing to do.
        """
        if not self._without_views:
            return ""
        return (
            f"views are missing for {self._without_views:,} of {self._count:,} shapes of '{self.name}', "
            "described by an earlier version of Shape Google; more of the same kind is found among them once "
            "their files are indexed again"
        )

    def roots(self) -> list[Root]:
        """Return the named folders that the indexed files lie below.

        Returns
        -------
        roots : list of Root
            In the order of their names; without a path where it is not known on this computer, see
            `map_root`.
        """
        return self._places.roots()

    def map_root(self, name: str, folder: str | os.PathLike[str]) -> None:
        """Say where a root lies on this computer: its files are then found, and sources are their paths.

        Parameters
        ----------
        name : str
            Of a root.
        folder : str or path-like
            Where it is here.

        Raises
        ------
        LibraryError
            If the library has no such root.
        """
        check_type("name", name, str, "a text")
        if name not in self._places.names:
            listed = ", ".join(map(repr, sorted(self._places.names))) or "none"
            raise LibraryError(f"'{self.name}' has no root {name!r}; its roots: {listed}")
        self._places.folders[name] = os.path.realpath(as_path(folder))

    @as_in_library
    def find(self, where: Filter | None = None, *, after: int = 0, limit: int = 100) -> list[ShapeRecord]:
        """See `Library.find`."""
        check_count("limit", limit, 1)
        check_type("where", where, (Filter, type(None)), "a shapegoogle_core.Filter")
        conditions = self._places.conditions(where)
        found: list[ShapeRecord] = []
        while conditions is not None and len(found) < limit:
            asked: dict[str, object] = {"after": after, "limit": min(limit - len(found), PAGE)}
            if conditions:
                asked["where"] = conditions
            page = self._connection.post("shapes", asked)
            with understood(self._connection.address):
                listed = [shape_from(record, self._places) for record in page["shapes"]]
                _check_follow(after, [record.shape_id for record in listed])
                found += listed
                if page["next"] is None:
                    break
                _check_follow(after, [int(page["next"])])
                after = int(page["next"])
        return found

    @as_in_library
    def shapes(self) -> Iterator[ShapeRecord]:
        """See `Library.shapes`."""
        last_id = 0
        while page := self.find(after=last_id, limit=PAGE):
            yield from page
            last_id = page[-1].shape_id

    @as_in_library
    def records(self, shape_ids: Sequence[int]) -> list[ShapeRecord]:
        """See `Library.records`."""
        found = []
        for some in portions(list(shape_ids), PAGE):
            page = self._connection.post("shapes", {"shape_ids": list(some)})
            with understood(self._connection.address):
                found += [shape_from(record, self._places) for record in page["shapes"]]
        return found

    @as_in_library
    def shape(self, shape_id: int) -> ShapeRecord:
        """See `Library.shape`."""
        records = self.records([shape_id])
        if not records:
            raise self._unknown(shape_id)
        return records[0]

    @as_in_library
    def has_shape(self, shape_id: int) -> bool:
        """See `Library.has_shape`."""
        return bool(self.records([shape_id]))

    @as_in_library
    def signature(self, shape_id: int) -> ShapeSignature:
        """See `Library.signature`."""
        content = self._connection.get_bytes(f"shapes/{int(shape_id)}/signature")
        with understood(self._connection.address):
            return signature_from_bytes(content, self.model, self.name)

    @as_in_library
    def placements(self, shape_id: int) -> tuple[Placement, ...]:
        """See `Library.placements`."""
        found = self._connection.post("placements", {"shape_ids": [shape_id]})
        with understood(self._connection.address):
            listed = found["placements"].get(str(shape_id))
            placements = None if listed is None else tuple(placement_from(record) for record in listed)
        if placements is None:
            raise self._unknown(shape_id)
        return placements

    @as_in_library
    def thumbnail(self, shape_id: int) -> bytes | None:
        """See `Library.thumbnail`."""
        picture = self.thumbnails([shape_id]).get(shape_id)
        if picture is None and not self.has_shape(shape_id):
            raise self._unknown(shape_id)
        return picture

    @as_in_library
    def thumbnails(self, shape_ids: Sequence[int]) -> dict[int, bytes]:
        """See `Library.thumbnails`."""
        pictures: dict[int, bytes] = {}
        for some in portions(list(shape_ids)):
            found = self._connection.post("thumbnails", {"shape_ids": list(some)})
            with understood(self._connection.address):
                sent = {int(number): picture(content) for number, content in found["pictures"].items()}
            pictures |= {number: sent[number] for number in some if number in sent}
        return pictures

    @as_in_library
    def preview(self, shape_id: int) -> bytes | None:
        """See `Library.preview`."""
        try:
            return self._connection.get_bytes(f"shapes/{int(shape_id)}/preview")
        except NotThereError:
            if self.has_shape(shape_id):
                return None
            raise

    def _unknown(self, shape_id: int) -> LibraryError:
        return LibraryError(
            f"'{self.name}' has no shape {shape_id}; it was removed or replaced: search again"
        )


def _check_follow(after: int, numbers: Sequence[int]) -> None:
    """Refuse a page that does not go on, which would be asked for without an end."""
    if any(later <= earlier for earlier, later in pairwise([after, *numbers])):
        raise ValueError

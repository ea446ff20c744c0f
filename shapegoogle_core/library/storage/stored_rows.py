# SPDX-License-Identifier: MIT
"""`StoredRows`: queries whose SQL is that of both databases."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import Any

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.placement import Placement
from shapegoogle_core.library.roots.paths import joined, path_key
from shapegoogle_core.library.storage.filter_conditions import Dialect
from shapegoogle_core.library.storage.local_folders import LocalFolders
from shapegoogle_core.library.storage.placement_rows import placements_from
from shapegoogle_core.library.storage.records import Root, SourceKey, SourceRecord

__all__ = ["StoredRows"]

NO_ROOT, UNKNOWN_ROOT = 0, -1


class StoredRows(ABC):
    """Roots, placements, samples, measures and pictures of a library."""

    dialect: Dialect
    """How values are written."""

    local_folders: LocalFolders

    # -- what the database provides -------------------------------------------------------------------------

    @abstractmethod
    def rows(self, statement: str, *parameters: object) -> list[tuple[Any, ...]]:
        """Run a query and return all rows."""

    @abstractmethod
    def rows_with_ids(self, statement: str, ids: Sequence[int]) -> list[tuple[Any, ...]]:
        """Run a query that ends with the column of ids, for these ids; rows come in the order of ids."""

    @abstractmethod
    def value(self, statement: str, *parameters: object) -> Any:
        """Run a query and return its first value, None if there is none."""

    @abstractmethod
    def execute(self, statement: str, *parameters: object) -> int:
        """Run a change, inside `writing`; return how many rows it met."""

    @abstractmethod
    def writing(self) -> AbstractContextManager[None]:
        """Run the changes inside as one transaction."""

    @abstractmethod
    def damaged(self, detail: str) -> LibraryError:
        """Make the error for content that contradicts itself."""

    # -- roots ----------------------------------------------------------------------------------------------

    def roots(self, *, counted: bool = False) -> list[Root]:
        """Return all roots, see `Store.roots`."""
        # By the expression of the index `source_keys`.
        count = "(SELECT count(*) FROM sources WHERE coalesce(root_id, 0) = roots.id)" if counted else "0"
        return [
            self.local_folders.root(*row)
            for row in self.rows(f"SELECT name, path, {count} FROM roots ORDER BY name")
        ]

    def map_root(self, root: Root, path: str) -> None:
        """Let a root lie elsewhere on this computer, see `Store.map_root`."""
        self.local_folders.put(root, path)

    def places(self, sources: Sequence[SourceKey]) -> list[tuple[int, str]]:
        """Return the number of the root of each source, and its path as it is compared."""
        known = {}
        if any(source.root for source in sources):
            known = {
                name: (number, path) for number, name, path in self.rows("SELECT id, name, path FROM roots")
            }
        places = []
        for source in sources:
            if not source.root:
                places.append((NO_ROOT, source.path))
            elif source.root in known:
                number, folder = known[source.root]
                places.append((number, path_key(folder, source.path)))
            else:
                places.append((UNKNOWN_ROOT, ""))
        return places

    def source_of(self, shape_id: int) -> SourceRecord | None:
        """Return the source of a shape, see `Store.source_of`."""
        rows = self.rows(
            "SELECT sources.path, size, mtime_ns, sha256, error,"
            " (SELECT count(*) FROM shapes AS own WHERE own.source_id = sources.id), roots.name, roots.path"
            " FROM shapes"
            " JOIN sources ON sources.id = source_id LEFT JOIN roots ON roots.id = root_id"
            f" WHERE shapes.id = {self.dialect.value}",
            shape_id,
        )
        if not rows:
            return None
        path, size, mtime_ns, sha256, error, count, root, folder = rows[0]
        known = SourceRecord(path, size, mtime_ns, sha256, error, count)
        if root is None:
            return known
        return replace(known, path=joined(self.local_folders.of(folder), path), root=root, relative=path)

    # -- shapes ---------------------------------------------------------------------------------------------

    def placements(self, shape_ids: Sequence[int]) -> dict[int, tuple[Placement, ...]]:
        """Return the placements of some shapes, see `Store.placements`."""
        columns = "shape_id, position, object_name, matrix, extent_x, extent_y, extent_z"
        rows = self.rows_with_ids(f"SELECT {columns} FROM placements WHERE shape_id", shape_ids)
        return placements_from(rows, self.damaged)

    def samples(self, shape_ids: Sequence[int]) -> dict[int, bytes]:
        """Return the surface samples of some shapes, see `Store.samples`."""
        return dict(self.rows_with_ids("SELECT shape_id, content FROM samples WHERE shape_id", shape_ids))

    def measures(self, shape_ids: Sequence[int]) -> dict[int, bytes]:
        """Return the measures of some shapes, see `Store.measures`."""
        return dict(self.rows_with_ids("SELECT shape_id, content FROM measures WHERE shape_id", shape_ids))

    def thumbnail(self, shape_id: int) -> bytes | None:
        """Return the picture of a shape, see `Store.thumbnail`."""
        statement = f"SELECT png FROM thumbnails WHERE shape_id = {self.dialect.value}"
        picture: bytes | None = self.value(statement, shape_id)
        return picture

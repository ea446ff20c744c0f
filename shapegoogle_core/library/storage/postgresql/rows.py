# SPDX-License-Identifier: MIT
"""Rows of new shapes for all tables, and their way into the database."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from typing import Any

import psycopg

from shapegoogle_core.library.origin import UNKNOWN
from shapegoogle_core.library.storage.filter_conditions import folded
from shapegoogle_core.library.storage.placement_rows import placement_rows
from shapegoogle_core.library.storage.postgresql.adapters import Bits
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.library.storage.signatures import BAG_TYPE
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["insert_rows", "rows_of_shape"]

# Columns and their types, `shapes` first, since the others refer to it.
_COLUMNS: dict[str, dict[str, str]] = {
    "shapes": {
        "id": "int8",
        "source_id": "int8",
        "object_name": "text",
        "name": "text",
        "folded": "text",
        "vertex_count": "int8",
        "face_count": "int8",
        "area": "float8",
        "extent_x": "float8",
        "extent_y": "float8",
        "extent_z": "float8",
        "placement_count": "int4",
    },
    "tags": {"shape_id": "int8", "tag": "text"},
    "placements": {
        "shape_id": "int8",
        "position": "int4",
        "object_name": "text",
        "folded": "text",
        "matrix": "bytea",
        "extent_x": "float8",
        "extent_y": "float8",
        "extent_z": "float8",
    },
    "origins": {"shape_id": "int8", "shape_type": "text", "catalog": "text", "frame": "int8"},
    "codes": {"shape_id": "int8", "code": "bit"},
    "local_words": {"shape_id": "int8", "code": "bit"},
    "view_codes": {"shape_id": "int8", "code": "bit"},
    "bags": {"shape_id": "int8", "halves": "bytea"},
    "samples": {"shape_id": "int8", "content": "bytea"},
    "measures": {"shape_id": "int8", "content": "bytea"},
    "thumbnails": {"shape_id": "int8", "png": "bytea"},
    "views": {"shape_id": "int8", "descriptors": "bytea"},
    "previews": {"shape_id": "int8", "content": "bytea"},
}
# From this number of shapes on COPY takes less time than single INSERTs in one message.
_COPIED_FROM = 20

Rows = Iterable[tuple[str, tuple[Any, ...]]]
"""Names of tables, and rows for them."""


def rows_of_shape(shape_id: int, source_id: int | None, shape: NewShape[ShapeSignature]) -> Rows:
    """Make the rows of a new shape.

    Parameters
    ----------
    shape_id : int
    source_id : int or None
        Number of its source.
    shape : NewShape

    Yields
    ------
    table : str
    row : tuple
        In the order of the columns.
    """
    signature = shape.signature
    yield (
        "shapes",
        (
            *(shape_id, source_id, shape.object_name, shape.name, folded(shape.name)),
            *(int(signature.vertex_count), int(signature.face_count)),
            *(float(signature.area), *map(float, signature.extents)),
            max(1, len(shape.placements)),
        ),
    )
    for tag in dict.fromkeys(shape.tags):
        yield "tags", (shape_id, tag)
    origin = shape.origin.completed(shape.object_name)
    if origin != UNKNOWN.completed(shape.object_name):
        yield "origins", (shape_id, origin.shape_type, origin.catalog, origin.frame)
    for position, placement, matrix, *extents in placement_rows(shape.placements, signature.extents):
        yield "placements", (shape_id, position, placement, folded(placement), matrix, *extents)
    for table, code in (
        ("codes", signature.code),
        ("local_words", signature.local_code),
        ("view_codes", signature.view_code),
    ):
        if code is not None:
            yield table, (shape_id, Bits(code.tobytes()))
    yield "bags", (shape_id, signature.bags.astype(BAG_TYPE).tobytes())
    for table, content in (
        ("samples", signature.sample),
        ("measures", signature.measures),
        ("views", signature.views),
    ):
        if content is not None:
            yield table, (shape_id, content.to_bytes())
    for table, picture in (("thumbnails", shape.thumbnail), ("previews", shape.preview)):
        if picture is not None:
            yield table, (shape_id, picture)


def insert_rows(connection: psycopg.Connection[Any], rows: Rows) -> None:
    """Insert rows, inside a transaction.

    Parameters
    ----------
    connection : psycopg.Connection
    rows : iterable of (str, tuple)
        Of any tables, see `rows_of_shape`.
    """
    by_table: defaultdict[str, list[tuple[Any, ...]]] = defaultdict(list)
    for table, row in rows:
        by_table[table].append(row)
    if len(by_table["shapes"]) >= _COPIED_FROM:
        for table, columns in _COLUMNS.items():
            if by_table[table]:
                _copy(connection, table, columns, by_table[table])
        return
    with connection.pipeline(), connection.cursor() as cursor:
        for table, columns in _COLUMNS.items():
            for row in by_table[table]:
                marks = ", ".join(["%b"] * len(columns))
                cursor.execute(f"INSERT INTO {table} ({', '.join(columns)}) VALUES ({marks})".encode(), row)


def _copy(
    connection: psycopg.Connection[Any], table: str, columns: dict[str, str], rows: list[tuple[Any, ...]]
) -> None:
    statement = f"COPY {table} ({', '.join(columns)}) FROM STDIN (FORMAT BINARY)"
    with connection.cursor() as cursor, cursor.copy(statement.encode()) as copy:
        copy.set_types(list(columns.values()))
        for row in rows:
            copy.write_row(row)

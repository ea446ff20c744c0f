# SPDX-License-Identifier: MIT
"""SQL of the tables `samples` and `thumbnails`: surface samples and pictures of shapes."""

from __future__ import annotations

from collections.abc import Sequence

from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.library.storage.sqlite.database import Database
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["SampleAndThumbnailTables"]


class SampleAndThumbnailTables(Database):
    """Samples and thumbnails of a library file."""

    def insert_sample_and_thumbnail(self, shape_id: int, shape: NewShape[ShapeSignature]) -> None:
        """Insert the sample and the thumbnail of a new shape if it has them, inside `writing`."""
        sample = shape.signature.sample
        if sample is not None:
            self.connection.execute("INSERT INTO samples VALUES (?, ?)", (shape_id, sample.to_bytes()))
        if shape.thumbnail is not None:
            self.connection.execute("INSERT INTO thumbnails VALUES (?, ?)", (shape_id, shape.thumbnail))

    def samples(self, shape_ids: Sequence[int]) -> dict[int, bytes]:
        """Return the surface samples of some shapes, see `Store.samples`."""
        return dict(self.rows_with_ids("SELECT shape_id, content FROM samples WHERE shape_id", shape_ids))

    def thumbnail(self, shape_id: int) -> bytes | None:
        """Return the picture of a shape, see `Store.thumbnail`."""
        picture: bytes | None = self.value("SELECT png FROM thumbnails WHERE shape_id = ?", shape_id)
        return picture

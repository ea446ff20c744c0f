# SPDX-License-Identifier: MIT
"""`LibraryContents`: the part of a library that adds, replaces and removes shapes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from shapegoogle_core.api.arguments import as_tuple, check_type, path_text
from shapegoogle_core.library.parts.folders import PathLike
from shapegoogle_core.library.parts.listing import LibraryListing
from shapegoogle_core.library.storage.records import NewShape, SourceKey
from shapegoogle_core.library.storage.signatures import check_signature
from shapegoogle_core.mesh import MeshLike, as_mesh
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["LibraryContents", "PathLike"]


class LibraryContents(LibraryListing):
    """The shapes of a library and the files they come from; the base of `LibraryComparison`.

    Parameters and attributes are those of `LibrarySources`.
    """

    def add(
        self,
        mesh: MeshLike,
        name: str = "",
        source: PathLike = "",
        object_name: str = "",
        thumbnail: bytes | None = None,
        tags: str | Sequence[str] = (),
    ) -> int:
        """Describe a shape and add it.

        Within a source a shape is known by its object name and name: adding it again replaces it. A shape
        without a source is always a new one.

        Parameters
        ----------
        mesh : MeshLike
            A `Mesh`, a tuple ``(vertices, faces)``, or an object with ``.vertices`` and ``.faces``.
        name : str, optional
            By default the file name of the source, such as "horse.ply"; without a source, the name of the
            mesh.
        source : str or path-like, optional
            The file it comes from: the path of an indexed file, or any other text, which is kept as it is.
        object_name : str, optional
            Name of the object inside the source.
        thumbnail : bytes, optional
            A picture as PNG.
        tags : str or sequence of str, optional
            Labels to filter searches by.

        Returns
        -------
        shape_id : int
            Number of the shape; never given to another shape of this library.

        Raises
        ------
        MeshError
            If it is not a mesh, or the model cannot describe it.
        LibraryError
            If the file cannot be written.
        ValueError
            If another argument is of a wrong type.

        Examples
        --------
        >>> import tempfile, trimesh
        >>> import shapegoogle_core as sg
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     with sg.Library.open(f"{folder}/shapes.sglib") as library:
        ...         _ = library.add(trimesh.creation.box(), source="models/box.stl", tags=["wood"])
        ...         [shape.name for shape in library.shapes()]
        ['box.stl']
        """
        source = path_text(source)
        # Before the mesh is described, which takes longer.
        _check_labels(name, object_name, thumbnail, tags)
        mesh = as_mesh(mesh, name or Path(source).name)
        return self.add_signature(
            self.model.describe(mesh),
            name or Path(source).name or mesh.name,
            source=source,
            object_name=object_name,
            thumbnail=thumbnail,
            tags=tags,
        )

    def add_signature(
        self,
        signature: ShapeSignature,
        name: str,
        source: PathLike = "",
        object_name: str = "",
        thumbnail: bytes | None = None,
        tags: str | Sequence[str] = (),
    ) -> int:
        """Add a shape that the model of this library has described already; otherwise like `add`.

        Parameters
        ----------
        signature : ShapeSignature
            From `ShapeModel.describe`.
        name : str
            Name of the object or of the file.
        source, object_name, thumbnail, tags
            See `add`.

        Returns
        -------
        shape_id : int
            Number of the shape; never given to another shape of this library.

        Raises
        ------
        LibraryError
            If another model made the signature, or the file cannot be written.
        ValueError
            If another argument is of a wrong type.
        """
        _check_labels(name, object_name, thumbnail, tags)
        tags = as_tuple("tags", tags, str, "a text, or several")
        shape = NewShape(signature, name, object_name, thumbnail, tags)
        check_signature(signature, name, self.model, self._store.name)
        source = path_text(source)
        shape_id = self._store.add(self._known(source) or SourceKey("", source) if source else None, shape)
        self._added([shape_id])
        return shape_id

    def remove_shape(self, shape_id: int) -> bool:
        """Remove one shape.

        Parameters
        ----------
        shape_id : int
            See `ShapeRecord`.

        Returns
        -------
        known : bool
            Whether there was such a shape.
        """
        return self._store.remove_shapes([shape_id]) > 0


def _check_labels(name: str, object_name: str, thumbnail: bytes | None, tags: str | Sequence[str]) -> None:
    """Raise ValueError if what is stored with a shape is of a wrong type."""
    check_type("name", name, str, "a text")
    check_type("object_name", object_name, str, "a text")
    check_type("thumbnail", thumbnail, (bytes, type(None)), "the bytes of a PNG file")
    as_tuple("tags", tags, str, "a text, or several")

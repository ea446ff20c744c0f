# SPDX-License-Identifier: MIT
"""Requests about meshes that are in no library: describe some at a time, then group all that are similar."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from shapegoogle_core.client import LibraryAddress
from shapegoogle_core.errors import MeshError, ModelError
from shapegoogle_core.library.duplicates.settings import MIN_SIMILARITY
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel, ShapeSignature
from shapegoogle_core.worker.packed import Packed
from shapegoogle_core.worker.requests import model_of

__all__ = ["describe_meshes", "group_meshes"]


def describe_meshes(
    model: ShapeModel | LibraryAddress | Path | str, meshes: Sequence[Mesh]
) -> list[Packed[ShapeSignature] | str]:
    """Describe several meshes; one that cannot be described costs only itself.

    Parameters
    ----------
    model : ShapeModel, LibraryAddress, Path or str
        As for `model_of`.
    meshes : sequence of Mesh

    Returns
    -------
    described : list of Packed or str
        In the order of the meshes; a sentence for a mesh that cannot be described.

    Raises
    ------
    LibraryError
        If the library cannot be opened.
    ModelError
        If the model cannot be loaded.
    """
    model = model_of(model)
    described: list[Packed[ShapeSignature] | str] = []
    for mesh in meshes:
        try:
            signature = model.describe(mesh)
        except MeshError as error:
            described.append(str(error))
            continue
        slim = replace(signature, sample=None, local_code=None, measures=None, views=None, view_code=None)
        described.append(Packed.of(slim, model.identifier))
    return described


def group_meshes(
    model: ShapeModel | LibraryAddress | Path | str,
    described: Sequence[Packed[ShapeSignature] | str],
    min_similarity: float = MIN_SIMILARITY,
) -> list[list[tuple[int, float]]]:
    """Group described meshes around the first of each group; see `group_similar`.

    Parameters
    ----------
    model : ShapeModel, LibraryAddress, Path or str
        As for `describe_meshes`.
    described : sequence of Packed or str
        From `describe_meshes`, with the same model. What could not be described is in no group.
    min_similarity : float, optional
        Above 0, at most 1.

    Returns
    -------
    groups : list of list of (int, float)
        Position in `described` of each member, and its similarity to the first one.

    Raises
    ------
    LibraryError
        If the library cannot be opened.
    ModelError
        If the model cannot be loaded, or is no longer the one that described the meshes.
    ValueError
        If `min_similarity` is out of range.
    """
    from shapegoogle_core.library.duplicates.similar import group_similar

    model = model_of(model)
    places: list[int] = []
    signatures: list[ShapeSignature] = []
    for place, packed in enumerate(described):
        if isinstance(packed, str):
            continue
        if packed.model != model.identifier:
            raise ModelError(
                "the model {name!r} has taken the place of the one that described the meshes; find "
                "duplicates again",
                name=model.name,
            )
        places.append(place)
        signatures.append(packed.unpacked())
    groups = group_similar(model, signatures, min_similarity)
    return [[(places[position], similarity) for position, similarity in group] for group in groups]

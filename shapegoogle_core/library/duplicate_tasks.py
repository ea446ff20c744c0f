# SPDX-License-Identifier: MIT
"""What a program with a window hands to a worker process when it looks for duplicates."""

from __future__ import annotations

import os
from collections.abc import Sequence

import numpy as np

from shapegoogle_core.errors import MeshError
from shapegoogle_core.library.duplicates import (
    MIN_SIMILARITY,
    DuplicateGroup,
    differing_bits,
    distance_at,
    member_positions,
    vector_distances,
)
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.stars import choose_banding, group_stars
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel, ShapeSignature

__all__ = ["describe_meshes", "group_similar", "library_duplicates"]


def library_duplicates(
    path: str | os.PathLike[str], min_similarity: float = MIN_SIMILARITY
) -> list[DuplicateGroup]:
    """Open a library for reading and find its duplicates; see `Library.duplicates`.

    Parameters
    ----------
    path : str or path-like
    min_similarity : float, optional

    Returns
    -------
    groups : list of DuplicateGroup

    Raises
    ------
    LibraryError
        If the library cannot be read.
    """
    with Library.open(path, read_only=True) as library:
        return library.duplicates(min_similarity)


def describe_meshes(model: ShapeModel, meshes: Sequence[Mesh]) -> list[ShapeSignature | str]:
    """Describe several meshes; one that cannot be described costs only itself.

    Parameters
    ----------
    model : ShapeModel
    meshes : sequence of Mesh

    Returns
    -------
    signatures : list of ShapeSignature or str
        In the order of the meshes; a sentence in place of a signature says why there is none.
    """
    described: list[ShapeSignature | str] = []
    for mesh in meshes:
        try:
            described.append(model.describe(mesh))
        except MeshError as error:
            described.append(str(error))
    return described


def group_similar(
    model: ShapeModel, signatures: Sequence[ShapeSignature], min_similarity: float = MIN_SIMILARITY
) -> list[list[tuple[int, float]]]:
    """Group signatures around the first of each group, as `Library.duplicates` groups similar shapes.

    Parameters
    ----------
    model : ShapeModel
        The one that made the signatures.
    signatures : sequence of ShapeSignature
    min_similarity : float, optional
        Above 0, at most 1.

    Returns
    -------
    groups : list of list of (int, float)
        Position of each member and its similarity to the first one, by falling similarity.

    Raises
    ------
    ValueError
        If `min_similarity` is out of range.
    """
    limit = distance_at(model, min_similarity)
    if not signatures:
        return []
    vectors = model.comparable(np.stack([signature.bags for signature in signatures]))
    stars = group_stars(
        np.stack([signature.code for signature in signatures]),
        vector_distances(vectors, np.arange(len(vectors)), model.settings.metric),
        limit,
        choose_banding(len(vectors), differing_bits(model, limit), model.code_bits),
    )
    similarities = model.similarity(stars.distance)
    return [
        [(int(position), float(similarities[position])) for position in group]
        for group in member_positions(stars)
    ]

# SPDX-License-Identifier: MIT
"""Learning of a `ViewModel` from pictures of any shapes; nothing needs a label."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from shapegoogle_core.mesh import MeshLike
from shapegoogle_core.views.directions import DIRECTIONS
from shapegoogle_core.views.view_model import CODE_BYTES, POSES, ViewModel, picture_parts

__all__ = ["learn_views"]

COMPONENTS = 320
"""Components of a picture, an even number: 2 × 12 × 320 half bytes are stored for a shape."""

POWER = 0.375
"""Exponent of the eigenvalues that components are divided by: ½ would be a full whitening."""


def learn_views(meshes: Iterable[MeshLike], components: int = COMPONENTS, power: float = POWER) -> ViewModel:
    """Learn the whitening of pictures.

    Mirrored pictures count as much as the pictures themselves, so that the principal components of symmetric
    and antisymmetric parts are found one by one.

    Parameters
    ----------
    meshes : iterable of MeshLike
        The more varied they are the better; they need not resemble the shapes that are searched for.
    components : int, optional
        Components of all four parts together.
    power : float, optional
        Components are divided by their eigenvalues to this power.

    Returns
    -------
    model : ViewModel

    Raises
    ------
    ValueError
        If there are fewer pictures than components.
    """
    parts = np.concatenate([picture_parts(mesh).astype(np.float64) for mesh in meshes])
    if len(parts) < components:
        raise ValueError(f"{len(parts)} pictures are too few to learn {components} components from")
    mean = parts[:, 0].mean(axis=0)
    parts[:, 0] -= mean
    values, vectors = zip(
        *(np.linalg.eigh(part.T @ part / len(parts)) for part in parts.transpose(1, 0, 2)), strict=True
    )
    least = np.sort(np.concatenate(values))[-components]
    kept = [part >= least for part in values]
    spread = [part[chosen] for part, chosen in zip(values, kept, strict=True)]
    projections = tuple(
        (directions[:, chosen] / part**power).astype(np.float16)
        for directions, chosen, part in zip(vectors, kept, spread, strict=True)
    )
    coded = 8 * CODE_BYTES // POSES // DIRECTIONS
    order = np.argsort(-np.concatenate(spread), kind="stable")[:coded]
    return ViewModel(mean.astype(np.float32), projections, np.sort(order).astype(np.int64))

# SPDX-License-Identifier: MIT
"""Request of a replacement: where a shape has to lie to take the place of others."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.registration.fit.laying import Laid, lay_copy, lay_on
from shapegoogle_core.worker.requests import model_of

__all__ = ["lay_meshes"]


def lay_meshes(
    model: ShapeModel | Path | str, targets: Sequence[Mesh], mesh: Mesh
) -> list[FloatArray | None]:
    """Find the motions and sizes with which a mesh takes the place of others.

    Parameters
    ----------
    model : ShapeModel, Path or str
        As for `model_of`.
    targets : sequence of Mesh
    mesh : Mesh

    Returns
    -------
    matrices : list of (4, 4) array or None
        From the mesh to each place; None where the two do not fit.

    Raises
    ------
    LibraryError
        If the library cannot be opened.
    ModelError
        If the model cannot be loaded.
    """
    found: list[FloatArray | None] = []
    own: Laid | None = None
    for target in targets:
        copy = lay_copy(target.vertices, mesh.vertices)
        if copy is not None:
            found.append(copy)
            continue
        own = own or _laid(model_of(model), mesh)
        place = _laid(model_of(model), target)
        found.append(None if own is None or place is None else lay_on(place, own))
    return found


def _laid(model: ShapeModel, mesh: Mesh) -> Laid | None:
    """Describe a mesh; None if that cannot be."""
    try:
        signature = model.describe(mesh, keep_surface=True)
    except MeshError:
        return None
    if signature.sample is None:
        return None
    return Laid(signature.sample, signature.surface, signature.measures)

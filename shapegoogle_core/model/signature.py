# SPDX-License-Identifier: MIT
"""What a model says of a shape: its signature, which the search compares, and the words on its vertices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model.shape_bags import FloatBags
from shapegoogle_core.registration import SurfaceSample

__all__ = ["ShapeSignature", "WordMap"]


@dataclass(frozen=True, eq=False)
class ShapeSignature:
    """What the search knows of a shape.

    Attributes
    ----------
    bags : (B,) array of float32
        All bags of words and of pairs of words, side by side, as `ShapeModel.distances` compares them.
    code : (s/8,) array of uint8
        The binary code, packed as by `numpy.packbits`.
    area : float
        Of the mesh as given, in squared units. Of points without faces: of the surface they stand on.
    vertex_count, face_count : int
        Of the mesh as given.
    sample : SurfaceSample or None
        Points of the mended mesh, if the model's settings ask for them.
    local_code : (V/8,) array of uint8 or None
        Which local words the sample has, if the model has an index of parts; see `LocalWords.code`.
    surface : Mesh or None
        The mended mesh itself, where the mesh as given was. Of a query; libraries do not keep it.
    extents : (float, float, float)
        Side lengths of the axis-aligned bounding box of the mesh as given; zeros if they are not known.
    """

    bags: FloatBags
    code: NDArray[np.uint8]
    area: float
    vertex_count: int
    face_count: int
    sample: SurfaceSample | None = None
    local_code: NDArray[np.uint8] | None = None
    surface: Mesh | None = None
    extents: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class WordMap:
    """A shape at the working resolution with the words on its vertices.

    Attributes
    ----------
    mesh : Mesh
        Mended and scaled to the model's area.
    words : (n, V) array
        θ(x), the distribution of each vertex over the words.
    """

    mesh: Mesh
    words: FloatArray

    @property
    def nearest(self) -> NDArray[np.int64]:
        """(n,) most likely word of each vertex."""
        return np.asarray(self.words.argmax(axis=1), dtype=np.int64)

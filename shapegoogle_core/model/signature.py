# SPDX-License-Identifier: MIT
"""`ShapeSignature`: the result of a model for one shape, which a search compares."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model.shape_bags import FloatBags
from shapegoogle_core.registration import MeshMeasures, SurfaceSample
from shapegoogle_core.views import ShapeViews

__all__ = ["ShapeSignature"]


@dataclass(frozen=True, eq=False)
class ShapeSignature:
    """Signature of a shape, as a search compares it and a library stores it.

    Attributes
    ----------
    bags : (B,) array of float32
        All bags of words and of pairs of words side by side, for `ShapeModel.distances`.
    code : (s/8,) array of uint8
        Binary code, packed as by `numpy.packbits`.
    area : float
        Area of the mesh as given, in squared units; for a point cloud that of the surface it samples.
    vertex_count, face_count : int
        Numbers of vertices and faces of the mesh as given.
    sample : SurfaceSample or None
        Points of the preprocessed mesh, if the model's settings ask for them.
    local_code : (V/8,) array of uint8 or None
        Local words of the sample, if the model has an index of parts; see `LocalWords.code`.
    surface : Mesh or None
        Preprocessed mesh in the position of the mesh as given. Only queries need it; libraries do not keep
        it.
    extents : (float, float, float)
        Side lengths of the axis-aligned bounding box of the mesh as given; zeros if they are not known.
    measures : MeshMeasures or None
        Of the mesh as given: what tells copies and other triangulations of a surface from other shapes.
    views : ShapeViews or None
        Pictures of the mesh as given, described, if the model has learnt to; for `ViewModel.distances`.
    view_code : (64,) array of uint8 or None
        Binary code of the views, see `ViewModel.code`.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> import trimesh
    >>> signature = sg.load_model().describe(trimesh.creation.icosphere())
    >>> signature.vertex_count, signature.face_count, len(signature.bags), len(signature.sample.points)
    (642, 1280, 2700, 600)
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
    measures: MeshMeasures | None = None
    views: ShapeViews | None = None
    view_code: NDArray[np.uint8] | None = None

# SPDX-License-Identifier: MIT
"""Shape Google: select a shape, find it again."""

from shapegoogle_core.errors import LibraryError, MeshError, ModelError, ShapeGoogleError
from shapegoogle_core.mesh import Mesh

__all__ = ["LibraryError", "Mesh", "MeshError", "ModelError", "ShapeGoogleError"]

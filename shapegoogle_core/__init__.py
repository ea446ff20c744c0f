# SPDX-License-Identifier: MIT
"""Shape Google: select a shape, find it again.

>>> import shapegoogle_core as sg
>>> with sg.Library.open("animals.sglib") as library:
...     library.add(sg.read_mesh("horse.ply"), source="horse.ply")
...     matches = library.query(sg.read_mesh("unknown.ply"), top=5)
"""

from shapegoogle_core.bags import bag_of_features, spatially_sensitive_bag
from shapegoogle_core.correspondence import VertexMatch, match_vertices
from shapegoogle_core.descriptors import (
    heat_kernel,
    heat_kernel_signature,
    scale_invariant_hks,
    wave_kernel_signature,
)
from shapegoogle_core.errors import LibraryError, MeshError, ModelError, ShapeGoogleError
from shapegoogle_core.heat_diffusion import full_heat_kernel, full_heat_kernel_signature
from shapegoogle_core.keypoints import Keypoints, detect_keypoints
from shapegoogle_core.laplacian import Operator, build_operator
from shapegoogle_core.library import Library, Match
from shapegoogle_core.mending import Mending, mend
from shapegoogle_core.mesh import Mesh, read_mesh
from shapegoogle_core.model import ShapeModel, ShapeSignature, load_model
from shapegoogle_core.spectrum import Spectrum, compute_spectrum
from shapegoogle_core.vertex_signatures import (
    VertexKeypoints,
    VertexSpectrum,
    VertexWords,
    vertex_keypoints,
    vertex_spectrum,
    vertex_words,
)
from shapegoogle_core.words import hard_words, soft_words

__all__ = [
    "Keypoints",
    "Library",
    "LibraryError",
    "Match",
    "Mending",
    "Mesh",
    "MeshError",
    "ModelError",
    "Operator",
    "ShapeGoogleError",
    "ShapeModel",
    "ShapeSignature",
    "Spectrum",
    "VertexKeypoints",
    "VertexMatch",
    "VertexSpectrum",
    "VertexWords",
    "bag_of_features",
    "build_operator",
    "compute_spectrum",
    "detect_keypoints",
    "full_heat_kernel",
    "full_heat_kernel_signature",
    "hard_words",
    "heat_kernel",
    "heat_kernel_signature",
    "load_model",
    "match_vertices",
    "mend",
    "read_mesh",
    "scale_invariant_hks",
    "soft_words",
    "spatially_sensitive_bag",
    "vertex_keypoints",
    "vertex_spectrum",
    "vertex_words",
    "wave_kernel_signature",
]

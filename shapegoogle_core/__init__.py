# SPDX-License-Identifier: MIT
"""Shape Google: select a shape, find it again.

A library in five lines::

    import shapegoogle_core as sg

    with sg.Library.open("animals.sglib") as library:
        library.add(sg.read_mesh("horse.ply"), source="horse.ply")
        matches = library.query(sg.read_mesh("unknown.ply"), top=5)

Each step is a function of its own:

>>> import shapegoogle_core as sg
>>> vertices = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
>>> mesh = sg.Mesh(vertices, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]], name="tetrahedron")
>>> spectrum = sg.compute_spectrum(mesh, k=3)
>>> sg.heat_kernel_signature(spectrum, times=[1.0, 10.0]).shape
(4, 2)
"""

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from shapegoogle_core.correspondence import VertexMatch as VertexMatch
    from shapegoogle_core.correspondence import match_vertices as match_vertices
    from shapegoogle_core.descriptors import default_times as default_times
    from shapegoogle_core.descriptors import geodesic_histograms as geodesic_histograms
    from shapegoogle_core.descriptors import global_point_signature as global_point_signature
    from shapegoogle_core.descriptors import heat_kernel_signature as heat_kernel_signature
    from shapegoogle_core.descriptors import log_heat_kernel_signature as log_heat_kernel_signature
    from shapegoogle_core.descriptors import mesh_hog as mesh_hog
    from shapegoogle_core.descriptors import scale_invariant_hks as scale_invariant_hks
    from shapegoogle_core.descriptors import shape_contexts as shape_contexts
    from shapegoogle_core.descriptors import vertex_spin_images as vertex_spin_images
    from shapegoogle_core.descriptors import volumetric_hks as volumetric_hks
    from shapegoogle_core.descriptors import wave_kernel_signature as wave_kernel_signature
    from shapegoogle_core.errors import LibraryError as LibraryError
    from shapegoogle_core.errors import MeshError as MeshError
    from shapegoogle_core.errors import ModelError as ModelError
    from shapegoogle_core.errors import ShapeGoogleError as ShapeGoogleError
    from shapegoogle_core.indexing import IndexReport as IndexReport
    from shapegoogle_core.indexing import IndexSettings as IndexSettings
    from shapegoogle_core.indexing import find_meshes as find_meshes
    from shapegoogle_core.indexing import index_files as index_files
    from shapegoogle_core.keypoints import Keypoints as Keypoints
    from shapegoogle_core.keypoints import detect_keypoints as detect_keypoints
    from shapegoogle_core.laplacian import Operator as Operator
    from shapegoogle_core.laplacian import build_operator as build_operator
    from shapegoogle_core.library import Evidence as Evidence
    from shapegoogle_core.library import Filter as Filter
    from shapegoogle_core.library import Library as Library
    from shapegoogle_core.library import Match as Match
    from shapegoogle_core.library import SearchSettings as SearchSettings
    from shapegoogle_core.library import compare as compare
    from shapegoogle_core.mesh import Mesh as Mesh
    from shapegoogle_core.mesh import as_mesh as as_mesh
    from shapegoogle_core.mesh import read_mesh as read_mesh
    from shapegoogle_core.model import ChannelSettings as ChannelSettings
    from shapegoogle_core.model import ModelSettings as ModelSettings
    from shapegoogle_core.model import ShapeModel as ShapeModel
    from shapegoogle_core.model import ShapeSignature as ShapeSignature
    from shapegoogle_core.model import load_model as load_model
    from shapegoogle_core.model.training import TrainingShape as TrainingShape
    from shapegoogle_core.model.training import train_model as train_model
    from shapegoogle_core.model.vertex_signatures import VertexKeypoints as VertexKeypoints
    from shapegoogle_core.model.vertex_signatures import VertexSpectrum as VertexSpectrum
    from shapegoogle_core.model.vertex_signatures import VertexWords as VertexWords
    from shapegoogle_core.model.vertex_signatures import vertex_keypoints as vertex_keypoints
    from shapegoogle_core.model.vertex_signatures import vertex_spectrum as vertex_spectrum
    from shapegoogle_core.model.vertex_signatures import vertex_words as vertex_words
    from shapegoogle_core.preprocessing import PreprocessingSettings as PreprocessingSettings
    from shapegoogle_core.preprocessing import preprocess as preprocess
    from shapegoogle_core.spectral import Spectrum as Spectrum
    from shapegoogle_core.spectral import compute_spectrum as compute_spectrum
    from shapegoogle_core.spectral import heat_kernel as heat_kernel
    from shapegoogle_core.words import InverseDocumentFrequency as InverseDocumentFrequency
    from shapegoogle_core.words import SimilaritySensitiveHashing as SimilaritySensitiveHashing
    from shapegoogle_core.words import Vocabulary as Vocabulary
    from shapegoogle_core.words import bag_of_features as bag_of_features
    from shapegoogle_core.words import hard_words as hard_words
    from shapegoogle_core.words import soft_words as soft_words
    from shapegoogle_core.words import spatially_sensitive_bag as spatially_sensitive_bag

__version__ = "0.1.0"

# Module of each public name. It is imported when the name is first used, so that help texts, error messages
# and the start of Blender need not wait for numpy, scipy and all that the modules import.
_MODULES = {
    "correspondence": ("VertexMatch", "match_vertices"),
    "descriptors": (
        "default_times",
        "geodesic_histograms",
        "global_point_signature",
        "heat_kernel_signature",
        "log_heat_kernel_signature",
        "mesh_hog",
        "scale_invariant_hks",
        "shape_contexts",
        "vertex_spin_images",
        "volumetric_hks",
        "wave_kernel_signature",
    ),
    "errors": ("LibraryError", "MeshError", "ModelError", "ShapeGoogleError"),
    "indexing": ("IndexReport", "IndexSettings", "find_meshes", "index_files"),
    "keypoints": ("Keypoints", "detect_keypoints"),
    "laplacian": ("Operator", "build_operator"),
    "library": ("Evidence", "Filter", "Library", "Match", "SearchSettings", "compare"),
    "mesh": ("Mesh", "as_mesh", "read_mesh"),
    "model": ("ChannelSettings", "ModelSettings", "ShapeModel", "ShapeSignature", "load_model"),
    "model.training": ("TrainingShape", "train_model"),
    "model.vertex_signatures": (
        "VertexKeypoints",
        "VertexSpectrum",
        "VertexWords",
        "vertex_keypoints",
        "vertex_spectrum",
        "vertex_words",
    ),
    "preprocessing": ("PreprocessingSettings", "preprocess"),
    "spectral": ("Spectrum", "compute_spectrum", "heat_kernel"),
    "words": (
        "InverseDocumentFrequency",
        "SimilaritySensitiveHashing",
        "Vocabulary",
        "bag_of_features",
        "hard_words",
        "soft_words",
        "spatially_sensitive_bag",
    ),
}
_MODULE_OF = {name: module for module, names in _MODULES.items() for name in names}

__all__ = sorted(_MODULE_OF)

if not TYPE_CHECKING:  # or any name would do for the type checker

    def __getattr__(name: str) -> object:
        """Import a public name when it is first used (PEP 562)."""
        if name not in _MODULE_OF:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        value = getattr(importlib.import_module(f"{__name__}.{_MODULE_OF[name]}"), name)
        globals()[name] = value
        return value

    def __dir__() -> list[str]:
        """List the public names too that were not used yet."""
        return sorted({*globals(), *__all__})

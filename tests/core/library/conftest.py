# SPDX-License-Identifier: MIT
"""The tiny model, its signatures, and a library with evidence, for all tests of this folder."""

from tests.core.library.explained_pairs import answers, pairs
from tests.core.postgresql_server import place, postgresql, postgresql_url, postgresql_with_vectors
from tests.core.tiny_model import make_model, make_signature, meshes, model, other_model, path, view_model

__all__ = [
    "answers",
    "make_model",
    "make_signature",
    "meshes",
    "model",
    "other_model",
    "pairs",
    "path",
    "place",
    "postgresql",
    "postgresql_url",
    "postgresql_with_vectors",
    "view_model",
]

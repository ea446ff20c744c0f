# SPDX-License-Identifier: MIT
"""The tiny model and its signatures for all tests of this folder."""

from tests.core.tiny_model import make_model, make_signature, meshes, model, other_model, path

__all__ = ["make_model", "make_signature", "meshes", "model", "other_model", "path"]

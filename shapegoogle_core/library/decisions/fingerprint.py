# SPDX-License-Identifier: MIT
"""Fingerprints of meshes, by which decisions recognise a shape."""

from __future__ import annotations

import hashlib

import numpy as np

from shapegoogle_core.library.storage.signatures import BAG_TYPE
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.registration import MeshMeasures

__all__ = ["fingerprint", "fingerprint_of_measures"]

# Moments are between 0 and 1, and the same to six digits wherever a mesh lies.
_STEPS = 1000
# Simple shapes have round moments; this keeps those away from the borders between two steps.
_AWAY = 0.2718


def fingerprint(signature: ShapeSignature) -> str:
    """Return a text that is the same for the same mesh, whatever its place, size, file and name.

    Parameters
    ----------
    signature : ShapeSignature

    Returns
    -------
    fingerprint : str

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> import trimesh
    >>> from shapegoogle_core.library.decisions.fingerprint import fingerprint
    >>> model = sg.load_model()
    >>> first, second = trimesh.creation.box((1, 2, 3)), trimesh.creation.box((2, 4, 6))
    >>> _ = second.apply_translation((5, 0, 0))
    >>> fingerprint(model.describe(first)) == fingerprint(model.describe(second))
    True
    """
    if signature.measures is not None:
        return fingerprint_of_measures(signature.measures)
    # Of a program that took no measures: the bags as a library rounds them.
    content = signature.code.tobytes() + signature.bags.astype(BAG_TYPE).tobytes()
    return "b" + hashlib.sha256(content).hexdigest()[:32]


def fingerprint_of_measures(measures: MeshMeasures) -> str:
    """Return the fingerprint of a mesh by its measures.

    Parameters
    ----------
    measures : MeshMeasures

    Returns
    -------
    fingerprint : str
    """
    steps = np.floor(measures.moments * _STEPS + _AWAY).astype("<i8")
    moments = hashlib.sha256(steps.tobytes()).hexdigest()[:16]
    return f"m{moments}-{measures.vertex_count:x}-{measures.face_count:x}"

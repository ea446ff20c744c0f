# SPDX-License-Identifier: MIT
"""Fingerprints of meshes, by which decisions recognise a shape."""

from __future__ import annotations

import hashlib

from shapegoogle_core.library.storage.signatures import BAG_TYPE
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.registration import MeshMeasures

__all__ = ["fingerprint", "fingerprint_of_measures"]


def fingerprint(signature: ShapeSignature) -> str:
    """Return a text that is the same for the same mesh in the same place, whatever its file and name.

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
    >>> first, second = (fingerprint(model.describe(trimesh.creation.box((1, 2, 3)))) for _ in range(2))
    >>> first == second
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
    return f"m{measures.hash:016x}-{measures.vertex_count:x}-{measures.face_count:x}"

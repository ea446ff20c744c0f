# SPDX-License-Identifier: MIT
"""Whether a signature belongs into a library."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.storage.sqlite.store import round_bags
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.shape_model import ShapeSignature

__all__ = ["check_signature"]


def check_signature(signature: ShapeSignature, name: str, model: ShapeModel, path: Path) -> None:
    """Refuse a signature that does not belong into a library.

    Parameters
    ----------
    signature : ShapeSignature
    name : str
        What errors call it.
    model : ShapeModel
        The library's.
    path : Path
        The library.

    Raises
    ------
    LibraryError
        If another model made it, or its bags are no numbers that the library can hold.
    """
    misfit = _misfit(model, signature)
    if misfit:
        raise LibraryError(
            f"{name!r} was described with another model than that of '{path}' "
            f"({model.identifier}): {misfit}; describe it with library.model"
        )
    if not np.isfinite(round_bags(signature.bags)).all():
        raise LibraryError(f"{name!r} has a bag with NaN, infinite or huge entries; describe it again")


def _misfit(model: ShapeModel, signature: ShapeSignature) -> str:
    """In what a signature is not of a model; empty if it may be."""
    if (signature.bags.shape, signature.code.shape) != ((model.bag_size,), (model.code_bits // 8,)):
        return (
            f"{signature.bags.size} bag entries and {8 * signature.code.size} bits instead of "
            f"{model.bag_size} and {model.code_bits}"
        )
    if signature.sample is not None and model.settings.sample is None:
        return "that one takes no samples of surfaces"
    local = model.settings.local
    local_bytes = 0 if local is None else local.words // 8
    if signature.local_code is not None and signature.local_code.size != local_bytes:
        return "its local code does not fit"
    return ""

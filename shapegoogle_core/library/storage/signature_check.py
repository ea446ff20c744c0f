# SPDX-License-Identifier: MIT
"""Check that a signature belongs to the model of a library."""

from __future__ import annotations

import numpy as np

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.storage.bag_precision import round_bags
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["check_signature"]


def check_signature(signature: ShapeSignature, name: str, model: ShapeModel, library: str) -> None:
    """Raise LibraryError if a signature cannot be compared with those of a library.

    Parameters
    ----------
    signature : ShapeSignature
    name : str
        Name of the shape in error messages.
    model : ShapeModel
        The library's model.
    library : str
        Name of the library, see `Store.name`.

    Raises
    ------
    LibraryError
        If another model made it, or its bags are not numbers that the library can hold.
    """
    misfit = _misfit(model, signature)
    if misfit:
        raise LibraryError(
            f"{name!r} was described with another model than that of '{library}' "
            f"({model.identifier}): {misfit}; describe it with library.model"
        )
    if not np.isfinite(round_bags(signature.bags)).all():
        raise LibraryError(f"{name!r} has a bag with NaN, infinite or huge entries; describe it again")


def _misfit(model: ShapeModel, signature: ShapeSignature) -> str:
    """Return the difference between a signature and those of a model; empty if there is none."""
    if (signature.bags.shape, signature.code.shape) != ((model.bag_size,), (model.code_bits // 8,)):
        return (
            f"{signature.bags.size} bag entries and {8 * signature.code.size} bits instead of "
            f"{model.bag_size} and {model.code_bits}"
        )
    if signature.sample is not None and model.settings.sample is None:
        return "that model takes no surface samples"
    local = model.settings.local
    local_bytes = 0 if local is None else local.words // 8
    if signature.local_code is not None and signature.local_code.size != local_bytes:
        return "its local code does not fit"
    return ""

# SPDX-License-Identifier: MIT
"""Precision of the bags that libraries store."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["BAG_TYPE", "round_bags"]

BAG_TYPE = np.dtype("<f2")
"""Half floats, little-endian: half the room of float32 and the same rankings (docs/library.md)."""


def round_bags(bags: NDArray[np.float32]) -> NDArray[np.float32]:
    """Round bags to the precision of a library.

    Parameters
    ----------
    bags : array of float32

    Returns
    -------
    rounded : array of float32
        Of the same shape, with 11 significant bits; infinite beyond 65,504.
    """
    with np.errstate(over="ignore"):
        return bags.astype(BAG_TYPE).astype(np.float32)

# SPDX-License-Identifier: MIT
"""Parameter checks and portions of work that the descriptors of neighbourhoods share."""

from __future__ import annotations

import math
from collections.abc import Iterator

__all__ = ["check_bins", "check_radius", "chunks"]


def check_radius(radius: float) -> None:
    """Raise ValueError if a radius is not positive and finite.

    Parameters
    ----------
    radius : float
        A share of the square root of the area.

    Raises
    ------
    ValueError
        If it is not positive and finite.
    """
    if not 0 < radius < math.inf:
        raise ValueError(f"radius must be a positive share of the square root of the area, not {radius}")


def check_bins(name: str, *counts: int) -> None:
    """Raise ValueError if a histogram has no bins.

    Parameters
    ----------
    name : str
        Name of the parameters in the message.
    *counts : int
        Numbers of bins.

    Raises
    ------
    ValueError
        If a number is less than 1.
    """
    if any(count < 1 for count in counts):
        raise ValueError(f"{name} must be at least 1, not {' × '.join(map(str, counts))}")


def chunks(count: int, size: int) -> Iterator[slice]:
    """Cut the range 0 … count - 1 into slices.

    Parameters
    ----------
    count : int
        Length of the range.
    size : int
        Largest length of a slice.

    Returns
    -------
    slices : iterator of slice
    """
    return (slice(start, min(start + size, count)) for start in range(0, count, size))

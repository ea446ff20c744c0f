# SPDX-License-Identifier: MIT
"""What the descriptors of a neighbourhood share: checks of their parameters, and work in portions."""

from __future__ import annotations

import math
from collections.abc import Iterator

__all__ = ["check_bins", "check_radius", "chunks"]


def check_radius(radius: float) -> None:
    """Refuse a radius that is none, by `ValueError`."""
    if not 0 < radius < math.inf:
        raise ValueError(f"radius must be a positive share of the root of the area, not {radius}")


def check_bins(name: str, *counts: int) -> None:
    """Refuse a histogram without bins, by `ValueError`."""
    if any(count < 1 for count in counts):
        raise ValueError(f"{name} must be at least 1, not {' × '.join(map(str, counts))}")


def chunks(count: int, size: int) -> Iterator[slice]:
    """Cut 0 … count into slices of at most `size`."""
    return (slice(start, min(start + size, count)) for start in range(0, count, size))

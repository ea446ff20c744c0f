# SPDX-License-Identifier: MIT
"""Errors of the benchmarks."""

from shapegoogle_core.errors import ShapeGoogleError

__all__ = ["BenchmarkError"]


class BenchmarkError(ShapeGoogleError):
    """A collection, a result of an earlier run, a cache folder or an installation cannot be used."""

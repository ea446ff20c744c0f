# SPDX-License-Identifier: MIT
"""Tasks that leave a trace of each call, and fail as real shapes make real ones fail."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.protocol.cache import Arrays, BenchmarkCache
from benchmarks.protocol.workshop import Source
from shapegoogle_core.errors import MeshError


@dataclass(frozen=True)
class CountVertices:
    """Counts vertices; crashes, fails or stumbles over the shapes that are named so."""

    trace: Path
    crash: str = ""
    fail: str = ""
    stumble: str = ""
    kind: str = "counts"
    key: str = "count"
    title: str = "counting"

    def __call__(self, source: Source, cache: BenchmarkCache) -> Arrays:
        with self.trace.open("a") as file:
            file.write(f"{source.name}\n")
        if source.name == self.crash:
            os._exit(3)
        if source.name == self.fail:
            raise MeshError(f"{source.name!r} has no surface")
        if source.name == self.stumble:
            raise ZeroDivisionError("nobody foresaw this")
        return {"vertices": np.array([len(source.mesh().vertices)])}

    def calls(self) -> list[str]:
        """Names of the shapes it was called with."""
        return sorted(self.trace.read_text().split()) if self.trace.exists() else []

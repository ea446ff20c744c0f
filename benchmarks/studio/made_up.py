# SPDX-License-Identifier: MIT
"""Made-up shapes of the size of real ones, the service of a library, and figures of other processes."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import shapegoogle_core as sg
from benchmarks.errors import BenchmarkError
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.model.signature import ShapeSignature

__all__ = [
    "Row",
    "Service",
    "made_up_shapes",
    "median",
    "percentile",
    "processor_seconds",
    "real_signatures",
    "running_service",
]

Row = dict[str, Any]
"""Figures of one measurement."""

# Creatures that are described; made-up shapes vary them.
_KINDS = ("horse", "hand", "octopus", "human")


@cache
def real_signatures() -> tuple[ShapeSignature, ...]:
    """Describe a few creatures with the shipped model."""
    from benchmarks.creatures import make_creature

    model = sg.load_model()
    return tuple(model.describe(make_creature(kind, 100, 1_500).rest) for kind in _KINDS)


def made_up_shapes(model: sg.ShapeModel, seeds: Sequence[int]) -> list[NewShape[ShapeSignature]]:
    """Vary described creatures at random: bags, codes and counts, with samples and views as they are.

    Parameters
    ----------
    model : ShapeModel
        The shipped one.
    seeds : sequence of int
        One for each shape; every tenth repeats the shape before it, as copies do in real libraries.

    Returns
    -------
    shapes : list of NewShape
    """
    known = real_signatures()
    shapes = []
    for seed in seeds:
        random = np.random.default_rng(seed - seed % 10 // 9)
        like = known[seed % len(known)]
        bags = (like.bags * random.uniform(0.5, 1.5, like.bags.shape)).astype(np.float32)
        signature = replace(like, bags=bags, code=model.codes(bags[None])[0], vertex_count=100 + seed % 1000)
        shapes.append(NewShape(signature, f"shape {seed}", f"{seed}"))
    return shapes


@dataclass(frozen=True)
class Service:
    """A service that runs.

    Attributes
    ----------
    address : str
        Such as "http://127.0.0.1:12345/".
    process_id : int
    """

    address: str
    process_id: int

    def search(self, example: dict[str, Any], limit: int, evidence: int) -> list[dict[str, Any]]:
        """Ask for the best matches of an example."""
        content = json.dumps({"like": [example], "limit": limit, "evidence": evidence}).encode()
        request = urllib.request.Request(
            f"{self.address}api/queries", content, {"Content-Type": "application/json"}
        )
        with urllib.request.urlopen(request, timeout=600) as answer:
            matches: list[dict[str, Any]] = json.load(answer)["matches"]
        return matches


@contextmanager
def running_service(place: str) -> Iterator[Service]:
    """Run the service of a library in a process of its own.

    Parameters
    ----------
    place : str
        Path or address.

    Yields
    ------
    service : Service

    Raises
    ------
    BenchmarkError
        If it does not start.
    """
    options = ["--port", "0", "--rate", "1000000", "--time-limit", "600"]
    command = [sys.executable, "-m", "shapegoogle_core", "serve", "--library", place, *options]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        found = re.search(r"http://\S+", process.stdout.readline())
        if found is None:
            raise BenchmarkError(f"the service of '{place}' does not start")
        yield Service(found[0], process.pid)
    finally:
        process.terminate()
        process.wait()


def processor_seconds(process_id: int) -> float:
    """Return the processor time of another process, 0 where the system does not tell it.

    Parameters
    ----------
    process_id : int

    Returns
    -------
    seconds : float
    """
    try:
        fields = Path(f"/proc/{process_id}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def timed(started: float) -> float:
    """Seconds since a moment of `time.perf_counter`, for a row."""
    return float(f"{time.perf_counter() - started:.3g}")


def percentile(values: Sequence[float], share: float) -> float:
    """Return a percentile with three digits, for a row."""
    return float(f"{np.percentile(values, share):.3g}")


def median(values: Sequence[float]) -> float:
    """Return the median with three digits, for a row."""
    return percentile(values, 50)

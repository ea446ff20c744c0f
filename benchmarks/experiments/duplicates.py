# SPDX-License-Identifier: MIT
"""Measure the duplicate search in a library of synthetic signatures, a fifth of them planted duplicates.

    python -m benchmarks duplicates [--shapes N] [--min-similarity S] [--samples]

Bags are drawn so that the vectors the model compares have the same decreasing variances as those of real
shapes. A duplicate lies in a random direction from a shape without another duplicate, at a random distance up
to the limit.

With --samples, every shape also has a surface, that of one of 31 creatures, and a duplicate has its
original's surface in other units: a copy with the same order of vertices or, every second one, with another
number of vertices, so that the surfaces must be aligned.

Prints one line of JSON.
"""

from __future__ import annotations

import argparse
import json
import resource
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

import shapegoogle_core as sg
from benchmarks.creatures import CREATURE_KINDS, make_creature
from shapegoogle_core.cli.arguments import number_from, share
from shapegoogle_core.library.duplicates.settings import MIN_SIMILARITY
from shapegoogle_core.library.duplicates.similar import distance_at
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.registration import SurfaceSample

__all__ = ["DECAY", "add_options", "run"]

# Variance of direction i, relative to the first: 1 / (1 + i / 4)². On 702 shapes of TOSCA and the Princeton
# Shape Benchmark the variances of directions 1, 5, 10, 20 and 50 are 0.54, 0.20, 0.09, 0.06 and 0.02.
DECAY = 4
SHAPES_AT_ONCE = 1_000


def made_up_bags(model: sg.ShapeModel, embedded: np.ndarray, inverse: np.ndarray) -> np.ndarray:
    """Return the bags that the model embeds at these vectors."""
    return np.asarray(model.mean + embedded @ inverse, np.float32)


def creature_samples() -> list[SurfaceSample]:
    """Sample the surface of one creature of each kind."""
    model = sg.load_model()
    signatures = [model.describe(make_creature(kind, 100).rest) for kind in CREATURE_KINDS]
    return [signature.sample for signature in signatures if signature.sample is not None]


def fill(
    library: sg.Library,
    count: int,
    limit: float,
    random: np.random.Generator,
    samples: Sequence[SurfaceSample] = (),
) -> int:
    """Add shapes to a library; return the number of planted duplicates."""
    model = library.model
    inverse = np.linalg.pinv(model.projection.astype(np.float64))
    dimensions = len(inverse)
    spread = 1 / (1 + np.arange(dimensions) / DECAY)
    planted = 0
    for start in range(0, count, SHAPES_AT_ONCE):
        size = min(SHAPES_AT_ONCE, count - start)
        pairs = size // 5
        vectors = random.standard_normal((size, dimensions)) * spread
        vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
        originals = vectors[:pairs]
        turned = random.standard_normal((pairs, dimensions)) * spread
        turned -= (turned * originals).sum(axis=1, keepdims=True) * originals
        turned /= np.linalg.norm(turned, axis=1, keepdims=True)
        angles = np.arccos(1 - random.uniform(0, 0.98 * limit, pairs))[:, None]
        vectors[size - pairs :] = np.cos(angles) * originals + np.sin(angles) * turned
        planted += pairs
        bags = made_up_bags(model, 2 * vectors, inverse)
        codes = model.codes(bags)
        shapes = []
        for i, (bag, code) in enumerate(zip(bags, codes, strict=True)):
            original = i - (size - pairs)  # index of a duplicate's original; negative for other shapes
            vertices, sample = 1000 + start + i, samples[i % len(samples)] if samples else None
            if samples and original >= 0:
                sample = replace(samples[original % len(samples)], unit=2 * random.random() + 0.5)
                vertices = 1000 + start + original + original % 2 * count
            signature = sg.ShapeSignature(bag, code, 1.0, vertices, 2 * vertices, sample)
            shapes.append(NewShape(signature, f"shape {start + i}"))
        library.replace_source(f"made-up/{start}", size=0, mtime_ns=0, sha256=None, shapes=shapes)
    return planted


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument(
        "--shapes", type=number_from(5), default=100_000, metavar="N", help="in the library (%(default)s)"
    )
    parser.add_argument(
        "--min-similarity",
        type=share,
        default=MIN_SIMILARITY,
        metavar="S",
        help="least similarity of duplicates (%(default)s)",
    )
    parser.add_argument("--samples", action="store_true", help="with surfaces, which must be aligned")


def run(options: argparse.Namespace) -> int:
    """Make the library, search it for duplicates and print the figures.

    Parameters
    ----------
    options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    model = sg.load_model()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "made-up.sglib"
        with sg.Library.open(path, model) as library:
            limit = distance_at(model, options.min_similarity)
            samples = creature_samples() if options.samples else []
            planted = fill(library, options.shapes, limit, np.random.default_rng(0), samples)
            before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
            started = time.perf_counter()
            groups = library.duplicates(options.min_similarity)
            seconds = time.perf_counter() - started
            bytes_of_library = path.stat().st_size
    found = sum(len(group.members) - 1 for group in groups)
    print(
        json.dumps(
            {
                "shapes": options.shapes,
                "library_bytes": bytes_of_library,
                "planted": planted,
                "found": found,
                "recall": round(found / planted, 4) if planted else None,
                "kinds": Counter(group.kind for group in groups),
                "largest_group": max((len(group.members) for group in groups), default=0),
                "seconds": round(seconds, 2),
                # On Linux in kilobytes; pages of the temporary file count as long as they are mapped.
                "peak_memory_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024,
                "peak_memory_before_mb": before // 1024,
            }
        )
    )
    return 0

# SPDX-License-Identifier: MIT
"""Measure the search for duplicates in a library of made-up shapes, a fifth of them planted duplicates.

    python3 scripts/benchmark_duplicates.py [--shapes 100000] [--min-similarity 0.95]

Bags are drawn so that what the model compares spreads as on real shapes: over directions with falling
variance. A duplicate lies in a random direction from a shape that has no other, at a random distance up to
the limit.
"""

from __future__ import annotations

import argparse
import json
import resource
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import shapegoogle_core as sg
from shapegoogle_core.library import NewShape
from shapegoogle_core.library.duplicates import MIN_SIMILARITY, distance_at

# Variance of direction i, relative to the first: 1 / (1 + i / 4)². On 702 shapes of TOSCA and the Princeton
# Shape Benchmark the variances of directions 1, 5, 10, 20 and 50 are 0.54, 0.20, 0.09, 0.06 and 0.02.
DECAY = 4
SHAPES_AT_ONCE = 1_000


def made_up_bags(model: sg.ShapeModel, embedded: np.ndarray, inverse: np.ndarray) -> np.ndarray:
    """Bags that the model embeds where we want them."""
    return np.asarray(model.mean + embedded @ inverse, np.float32)


def fill(library: sg.Library, count: int, limit: float, random: np.random.Generator) -> int:
    """Put shapes in; returns how many of them are planted duplicates."""
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
        shapes = [
            NewShape(
                sg.ShapeSignature(bag, code, 1.0, 1000 + start + i, 2000 + start + i), f"shape {start + i}"
            )
            for i, (bag, code) in enumerate(zip(bags, codes, strict=True))
        ]
        library.replace_source(f"made-up/{start}", size=0, mtime_ns=0, sha256=None, shapes=shapes)
    return planted


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--shapes", type=int, default=100_000, metavar="N")
    parser.add_argument("--min-similarity", type=float, default=MIN_SIMILARITY, metavar="S")
    options = parser.parse_args()
    model = sg.load_model()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "made-up.sglib"
        with sg.Library.open(path, model) as library:
            limit = distance_at(model, options.min_similarity)
            planted = fill(library, options.shapes, limit, np.random.default_rng(0))
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
                "largest_group": max((len(group.members) for group in groups), default=0),
                "seconds": round(seconds, 2),
                # On Linux in kilobytes; pages of the temporary file count as long as they are mapped.
                "peak_memory_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024,
                "peak_memory_before_mb": before // 1024,
            }
        )
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())

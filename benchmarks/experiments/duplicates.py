# SPDX-License-Identifier: MIT
"""Measure the search for duplicates in a library of made-up shapes, a fifth of them planted duplicates.

    python -m benchmarks.experiments.duplicates [--shapes N] [--min-similarity 0.95] [--samples]

Bags are drawn so that what the model compares spreads as on real shapes: over directions with falling
variance. A duplicate lies in a random direction from a shape that has no other, at a random distance up to
the limit.

With --samples every shape has a surface too, that of one of 31 creatures, and a duplicate that of its
original in other units: a copy with its vertices in the same order, or, every second one, with another number
of them, so that surfaces have to be laid over one another.
"""

from __future__ import annotations

import argparse
import json
import resource
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

import shapegoogle_core as sg
from shapegoogle_core.library import NewShape
from shapegoogle_core.library.duplicates.settings import MIN_SIMILARITY
from shapegoogle_core.library.duplicates.similar import distance_at
from shapegoogle_core.registration import SurfaceSample

# Variance of direction i, relative to the first: 1 / (1 + i / 4)². On 702 shapes of TOSCA and the Princeton
# Shape Benchmark the variances of directions 1, 5, 10, 20 and 50 are 0.54, 0.20, 0.09, 0.06 and 0.02.
DECAY = 4
SHAPES_AT_ONCE = 1_000


def made_up_bags(model: sg.ShapeModel, embedded: np.ndarray, inverse: np.ndarray) -> np.ndarray:
    """Bags that the model embeds where we want them."""
    return np.asarray(model.mean + embedded @ inverse, np.float32)


def creature_samples() -> list[SurfaceSample]:
    """Surfaces of one creature of each kind."""
    from benchmarks.creatures import CREATURE_KINDS, make_creature

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
        shapes = []
        for i, (bag, code) in enumerate(zip(bags, codes, strict=True)):
            original = i - (size - pairs)  # of a duplicate: its place; of others below 0
            vertices, sample = 1000 + start + i, samples[i % len(samples)] if samples else None
            if samples and original >= 0:
                sample = replace(samples[original % len(samples)], unit=2 * random.random() + 0.5)
                vertices = 1000 + start + original + original % 2 * count
            signature = sg.ShapeSignature(bag, code, 1.0, vertices, 2 * vertices, sample)
            shapes.append(NewShape(signature, f"shape {start + i}"))
        library.replace_source(f"made-up/{start}", size=0, mtime_ns=0, sha256=None, shapes=shapes)
    return planted


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--shapes", type=int, default=100_000, metavar="N")
    parser.add_argument("--min-similarity", type=float, default=MIN_SIMILARITY, metavar="S")
    parser.add_argument("--samples", action="store_true", help="with surfaces, to be laid over one another")
    options = parser.parse_args()
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


if __name__ == "__main__":
    sys.exit(main())

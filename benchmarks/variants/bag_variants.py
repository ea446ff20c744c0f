# SPDX-License-Identifier: MIT
"""Variants of the paper: descriptors, bags, vocabulary sizes, tf-idf and codes.

They learn from `training_versions`. Bags are compared by their L1 distance, as in the paper, and codes by
their Hamming distance.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from benchmarks.errors import BenchmarkError
from benchmarks.protocol.cache import Arrays, code_digest, digest
from benchmarks.protocol.collection import BenchmarkShape
from benchmarks.protocol.learning import INDIVIDUALS, training_versions
from benchmarks.protocol.matching import Matched, Variant, between, median_seconds, stacked
from benchmarks.protocol.workshop import Workshop
from benchmarks.variants.bag_tasks import BagKey, BagsTask, Descriptor, Preparation, SampleTask
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model.shape_bags import FloatBags

__all__ = ["BAG_NAMES", "BagGroup", "Descriptor", "Preparation", "bag_group"]

BAG_NAMES = {
    "plain": "bag of features",
    "plain-pairs": "spatially sensitive bag",
    "area": "bag of features, by area",
    "pairs": "spatially sensitive bag, by area",
}
"""Names of the kinds of bags of `shapegoogle_core.model.settings.BAGS` in the table."""

MOST_BITS = 512
HASHED_DIMENSIONS = 100
"""Largest number of principal components of bags of pairs before hashing."""

_PAIRS = 5_000  # of each kind, to learn codes from


@dataclass(frozen=True)
class _Learnt:
    """Result of training: the computation of bags, and the bags of the training shapes."""

    task: BagsTask
    labels: NDArray[np.int64]
    bags: FloatBags
    hard: FloatBags


@dataclass(frozen=True, eq=False)
class BagGroup:
    """Variants of one descriptor on one preparation.

    Attributes
    ----------
    preparation : Preparation
    descriptor : Descriptor
    variants : tuple of Variant
        Defined by their parameters "words" and "bag" (one of `BAG_NAMES`, optionally with ", tf-idf"), for
        bags of keypoints "detector", and for codes "bits" and "projection".
    bags : tuple of BagKey
        Bags that are computed: those of all existing variants, not only of the chosen ones, so that every
        choice uses the same results in the cache.
    train : str, Path or None
        Folder of additional training meshes, see `training_versions`.
    seed : int
    individuals : int
        Of each kind of creature to learn from.
    """

    preparation: Preparation
    descriptor: Descriptor
    variants: tuple[Variant, ...]
    bags: tuple[BagKey, ...]
    train: str | Path | None = None
    seed: int = 0
    individuals: int = INDIVIDUALS

    def only(self, names: set[str]) -> Self:
        """Return the group without the variants of other names."""
        return replace(self, variants=tuple(v for v in self.variants if v.name in names))

    def match(
        self, workshop: Workshop, queries: Sequence[BenchmarkShape], database: Sequence[BenchmarkShape]
    ) -> Iterator[Matched]:
        """Compare all queries with the database, for each of the variants."""
        learnt = self._learn(workshop)
        entries = [workshop.describe(learnt.task, shapes) for shapes in (database, queries)]
        known, asked = (stacked(described, "bags") for described in entries)
        cost = median_seconds(chain(*entries))
        slices = learnt.task.slices()
        for variant in self.variants:
            _, bag, _ = key = _bag_of(variant)
            part = slices[key]
            first, second = asked[:, part], known[:, part]
            if "bits" in variant.parameters:
                encode = self._hashing(workshop, learnt, part, variant)
                bytes_per_shape = int(variant.parameters["bits"]) // 8
                yield between(variant, _hamming, encode(first), encode(second), bytes_per_shape, cost)
                continue
            if _weighting(variant) == "tf-idf":
                weights = _document_weights(learnt.hard[:, part], pairs="pairs" in bag)
                if not weights.any():
                    workshop.notes[variant.name] = (
                        "left out: every word occurs on every training shape, so that tf-idf weighs none"
                    )
                    continue
                first, second = first * weights, second * weights
            yield between(variant, _l1, first, second, 4 * first.shape[1], cost)

    def _learn(self, workshop: Workshop) -> _Learnt:
        versions = training_versions(self.train, self.seed, self.individuals)
        sizes = sorted({words for words, _, _ in self.bags})
        sampled = workshop.describe_sources(SampleTask(self.preparation, self.descriptor), versions)
        usable = [entry["descriptors"] for entry in sampled if entry is not None]
        if not usable:
            raise BenchmarkError("none of the shapes to learn from could be described; see the failures")
        samples = np.concatenate(usable)
        code = code_digest(("shapegoogle_core/words/vocabulary.py",))
        found = workshop.remembered(
            "vocabularies",
            partial(_fit_vocabulary, samples, self.seed),
            sizes,
            [digest(samples, self.seed, size, code) for size in sizes],
            f"{self.descriptor.name}, {self.preparation.name}: vocabularies",
        )
        vocabularies = dict(zip(sizes, found, strict=True))
        task = BagsTask(self.preparation, self.descriptor, vocabularies, self.bags)
        described = workshop.describe_sources(replace(task, hard=True), versions)
        names = sorted({version.label for version in versions})
        rows = [
            (names.index(version.label), entry)
            for version, entry in zip(versions, described, strict=True)
            if entry is not None
        ]
        return _Learnt(
            task,
            np.array([label for label, _ in rows], np.int64),
            np.array([entry["bags"] for _, entry in rows]),
            np.array([entry["hard"] for _, entry in rows]),
        )

    def _hashing(
        self, workshop: Workshop, learnt: _Learnt, part: slice, variant: Variant
    ) -> partial[FloatBags]:
        projection = str(variant.parameters["projection"])
        bags = np.ascontiguousarray(learnt.bags[:, part])
        (fitted,) = workshop.remembered(
            "hashing",
            partial(_fit_hashing, bags, learnt.labels, self.seed),
            [projection],
            [
                digest(
                    bags,
                    learnt.labels,
                    self.seed,
                    projection,
                    MOST_BITS,
                    code_digest(("shapegoogle_core/words/hashing.py",)),
                )
            ],
            f"{self.descriptor.name}: codes by {projection}",
        )
        return partial(_encode, fitted, int(variant.parameters["bits"]))


def bag_group(
    preparation: Preparation,
    descriptor: Descriptor,
    variants: tuple[Variant, ...],
    *,
    train: str | Path | None = None,
    seed: int = 0,
    individuals: int = INDIVIDUALS,
) -> BagGroup:
    """Make a group of all variants of one descriptor on one preparation.

    Parameters
    ----------
    preparation, descriptor, variants, train, seed, individuals
        As in `BagGroup`.

    Returns
    -------
    group : BagGroup
    """
    bags = tuple(sorted({_bag_of(variant) for variant in variants}))
    return BagGroup(preparation, descriptor, variants, bags, train, seed, individuals)


def _bag_of(variant: Variant) -> BagKey:
    names = {name: bag for bag, name in BAG_NAMES.items()}
    bag = names[str(variant.parameters["bag"]).removesuffix(", tf-idf")]
    return int(variant.parameters["words"]), bag, str(variant.parameters.get("detector", ""))


def _weighting(variant: Variant) -> str:
    return "tf-idf" if str(variant.parameters["bag"]).endswith(", tf-idf") else "none"


def _l1(first: FloatBags, second: FloatBags) -> FloatArray:
    return np.asarray(cdist(first, second, "cityblock"), np.float64)


def _hamming(first: FloatBags, second: FloatBags) -> FloatArray:
    return np.asarray(cdist(first, second, "cityblock"), np.float64)


def _document_weights(hard: FloatBags, *, pairs: bool) -> FloatBags:
    """Compute the weights of tf-idf (paper, equations 17 and 18) from bags of hard words.

    A word occurs on a shape if it is the nearest word of any vertex. Because almost every pair of words has
    some weight, a pair occurs if its weight is above the mean of all pairs.
    """
    from shapegoogle_core.words import InverseDocumentFrequency

    threshold = 1 / hard.shape[1] if pairs else 0.0
    weights = InverseDocumentFrequency(threshold).fit(hard.astype(np.float64)).weights_
    return np.asarray(weights, np.float32)


def _fit_vocabulary(samples: FloatArray, seed: int, words: int) -> Arrays:
    from shapegoogle_core.words import Vocabulary

    vocabulary = Vocabulary(words, random_state=seed).fit(samples)
    return {"centers": vocabulary.centers_, "sigma": np.array(vocabulary.sigma_)}


def _fit_hashing(bags: FloatBags, labels: NDArray[np.int64], seed: int, projection: str) -> Arrays:
    """Learn principal components and `MOST_BITS` bits.

    Bits are learnt one after the other, so that a shorter code is a prefix of a longer one.
    """
    from shapegoogle_core.model.metric import choose_pairs
    from shapegoogle_core.words import SimilaritySensitiveHashing

    mean = bags.mean(axis=0, dtype=np.float64)
    components = np.linalg.svd(bags - mean, full_matrices=False)[2][:HASHED_DIMENSIONS]
    vectors = (bags - mean) @ components.T
    first, second, similar = choose_pairs(labels, np.random.default_rng(seed), _PAIRS)
    hashing = SimilaritySensitiveHashing(MOST_BITS, projection=projection, random_state=seed)
    hashing.fit(vectors[first], vectors[second], similar)
    return {
        "mean": mean,
        "components": components,
        "directions": hashing.directions_,
        "thresholds": hashing.thresholds_,
    }


def _encode(fitted: Arrays, bits: int, bags: FloatBags) -> FloatBags:
    """Compute codes as rows of 0 and 1; NaN for bags with NaN."""
    vectors = (bags - fitted["mean"]) @ fitted["components"].T
    values = vectors @ fitted["directions"][:bits].T + fitted["thresholds"][:bits]
    return np.asarray(np.where(np.isnan(values), np.nan, values > 0), np.float32)

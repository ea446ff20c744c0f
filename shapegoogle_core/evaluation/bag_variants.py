# SPDX-License-Identifier: MIT
"""The paper's variants as rows of the benchmark: descriptors, bags, vocabulary sizes, tf-idf and codes.

All are learnt from `training_versions`, and compared by the L1 distance of their bags, as in the paper, or
by the Hamming distance of codes made of them.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import accumulate, chain, pairwise
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from shapegoogle_core.bags import bag_of_features, spatially_sensitive_bag
from shapegoogle_core.describing import FloatBags, WorkingShape, counted_points
from shapegoogle_core.errors import BenchmarkError, MeshError
from shapegoogle_core.evaluation.collection import BenchmarkShape
from shapegoogle_core.evaluation.learning import INDIVIDUALS, training_versions
from shapegoogle_core.evaluation.matching import Matched, Variant, between, median_seconds, stacked
from shapegoogle_core.evaluation.spectra_cache import (
    PREPARATION_CODE,
    Arrays,
    BenchmarkCache,
    cached_shape,
    code_digest,
    digest,
    preparation_of,
)
from shapegoogle_core.evaluation.workshop import Source, Workshop
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.settings import DESCRIPTORS, ModelSettings
from shapegoogle_core.words import hard_words, soft_words

__all__ = ["BAG_NAMES", "BagGroup", "Descriptor", "Preparation", "bag_group"]

BAG_NAMES = {
    "plain": "bag of features",
    "plain-pairs": "spatially sensitive bag",
    "area": "bag of features, by area",
    "pairs": "spatially sensitive bag, by area",
}
"""What the table calls the kinds of bags of `shapegoogle_core.settings.BAGS`."""

BagKey = tuple[int, str, str]
"""Words of the vocabulary, kind of `BAGS`, and detector of the points that count, "" for all vertices."""

MOST_BITS = 512
HASHED_DIMENSIONS = 100
"""Most principal components that bags of pairs are brought to before they are hashed."""

_NO_WAVE = -10.0  # the least logarithm in the wave kernel signature of `DESCRIPTORS`
_SAMPLED_VERTICES = 100  # of each version, to learn vocabularies from
_PAIRS = 5_000  # of each kind, to learn codes from


@dataclass(frozen=True)
class Preparation:
    """How meshes become spectra.

    Attributes
    ----------
    name : str
    settings : ModelSettings
        Only its mending, area, Laplacian and number of eigenpairs matter.
    """

    name: str
    settings: ModelSettings


@dataclass(frozen=True)
class Descriptor:
    """A local descriptor.

    Attributes
    ----------
    name : str
        In the table.
    kind : str
        A key of `shapegoogle_core.settings.DESCRIPTORS`.
    parameters : dict
        Of it.
    pair_time : float
        t of the kernel in bags of pairs.
    """

    name: str
    kind: str
    parameters: dict[str, Any]
    pair_time: float

    @property
    def key(self) -> str:
        """Digest of what its values depend on."""
        return digest(self.kind, self.parameters, code_digest(("descriptors",)))

    def values(self, shape: WorkingShape, name: str) -> FloatArray:
        """Compute the descriptor of every vertex.

        Parameters
        ----------
        shape : WorkingShape
        name : str
            Of the shape, for errors.

        Returns
        -------
        values : (n, d) array

        Raises
        ------
        MeshError
            If the shape has no such descriptor.

        Notes
        -----
        A soup in more parts than there are eigenpairs, as much of PSB is, has only eigenvalues of 0 and no
        wave on it. It gets the wave kernel signature of parts that the spectrum leaves out, so that it is
        compared like any other shape and not put last.
        """
        try:
            return DESCRIPTORS[self.kind](shape.mesh, shape.spectrum, **self.parameters)
        except ValueError as error:
            spectrum = shape.spectrum
            if self.kind == "wks" and not spectrum.eigenvalues.any():
                return np.full((len(spectrum.mass), self.parameters["count"]), _NO_WAVE)
            raise MeshError(f"{name!r} has no {self.name}: {error}") from error


Vocabularies = dict[int, Arrays]
"""By their number of words: "centers" (V, d) and "sigma" ()."""


@dataclass(frozen=True)
class _SampleTask:
    """Take descriptors at some vertices of a shape."""

    preparation: Preparation
    descriptor: Descriptor
    kind: str = "samples"

    @property
    def title(self) -> str:
        return f"{self.descriptor.name}, {self.preparation.name}: descriptors to learn from"

    @property
    def key(self) -> str:
        return digest(preparation_of(self.preparation.settings), self.descriptor.key, _SAMPLED_VERTICES)

    def __call__(self, source: Source, cache: BenchmarkCache) -> Arrays:
        shape = cached_shape(cache, self.preparation.settings, source.key, source.mesh)
        random = np.random.default_rng(int(source.key[:8], 16))
        chosen = random.permutation(len(shape.mesh.vertices))[:_SAMPLED_VERTICES]
        return {"descriptors": self.descriptor.values(shape, source.name)[chosen]}


@dataclass(frozen=True)
class _BagsTask:
    """Compute bags of a shape for several vocabularies, one after the other in one array."""

    preparation: Preparation
    descriptor: Descriptor
    vocabularies: Vocabularies
    bags: tuple[BagKey, ...]
    hard: bool = False
    kind: str = "bags"

    @property
    def title(self) -> str:
        to_learn = " to learn from" if self.hard else ""
        return f"{self.descriptor.name}, {self.preparation.name}: bags{to_learn}"

    @property
    def key(self) -> str:
        vocabularies = [
            [words, entry["centers"], entry["sigma"]] for words, entry in sorted(self.vocabularies.items())
        ]
        code = code_digest(("bags.py", "words.py", "keypoints", "evaluation/bag_variants.py"))
        chosen = [self.bags, self.descriptor.pair_time, self.hard]
        return digest(
            preparation_of(self.preparation.settings), self.descriptor.key, vocabularies, chosen, code
        )

    def __call__(self, source: Source, cache: BenchmarkCache) -> Arrays:
        shape = cached_shape(cache, self.preparation.settings, source.key, source.mesh)
        started = time.process_time()
        values = self.descriptor.values(shape, source.name)
        seconds = time.process_time() - started
        spectrum = shape.spectrum
        points = self._points(shape, source, cache)
        computed: dict[str, list[FloatArray]] = {"bags": [], "hard": []}
        for name, parts in computed.items():
            if name == "hard" and not self.hard:
                continue
            for size, vocabulary in self.vocabularies.items():
                centers = vocabulary["centers"]
                if name == "hard":
                    words = hard_words(values, centers)
                else:
                    words = soft_words(values, centers, float(vocabulary["sigma"]))
                upper, double = np.triu_indices(size), 2 - np.eye(size)
                for _, bag, detector in (chosen for chosen in self.bags if chosen[0] == size):
                    by_area = bag in ("area", "pairs")
                    there, counted = words, spectrum
                    if detector:
                        there, counted = words[points[detector]], spectrum.at(points[detector])
                    if "pairs" in bag:
                        pairs = spatially_sensitive_bag(
                            there, counted, self.descriptor.pair_time, area_weighted=by_area
                        )
                        parts.append((double * pairs)[upper])
                    else:
                        parts.append(bag_of_features(there, counted.mass if by_area else None))
        bags = {name: np.concatenate(parts).astype(np.float32) for name, parts in computed.items() if parts}
        return {**bags, "seconds": np.array(seconds)}

    def _points(self, shape: WorkingShape, source: Source, cache: BenchmarkCache) -> Arrays:
        """Points that the detectors of the bags find, by detector."""
        detectors = sorted({detector for _, _, detector in self.bags} - {""})
        if not detectors:
            return {}
        settings = self.preparation.settings

        def detect() -> Arrays:
            return {one: counted_points(shape.mesh, shape.spectrum, one) for one in detectors}

        code = code_digest((*PREPARATION_CODE, "keypoints"))
        return cache.remembered(
            "keypoints", digest(source.key, preparation_of(settings), detectors, code), detect
        )

    def slices(self) -> dict[BagKey, slice]:
        """Where each bag stands in the array."""
        order = [chosen for size in self.vocabularies for chosen in self.bags if chosen[0] == size]
        sizes = [size * (size + 1) // 2 if "pairs" in bag else size for size, bag, _ in order]
        ends = pairwise(accumulate(sizes, initial=0))
        return {chosen: slice(*span) for chosen, span in zip(order, ends, strict=True)}


@dataclass(frozen=True)
class _Learnt:
    """What a group learnt: how to compute bags, and the bags of the training versions."""

    task: _BagsTask
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
        Their parameters "words" and "bag" (of `BAG_NAMES`, with ", tf-idf" behind it or not), for bags of
        detected points "detector", and for codes "bits" and "projection", say what is done.
    bags : tuple of BagKey
        Every bag that is computed: those of all variants that there are, not only of the chosen ones, so that
        any choice finds what another one left in the cache.
    train : str, Path or None
        Folder to learn from, see `training_versions`.
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
        """Leave the variants with other names out."""
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
        sampled = workshop.describe_sources(_SampleTask(self.preparation, self.descriptor), versions)
        usable = [entry["descriptors"] for entry in sampled if entry is not None]
        if not usable:
            raise BenchmarkError("none of the shapes to learn from could be described; see the failures")
        samples = np.concatenate(usable)
        code = code_digest(("vocabulary.py",))
        found = workshop.remembered(
            "vocabularies",
            partial(_fit_vocabulary, samples, self.seed),
            sizes,
            [digest(samples, self.seed, size, code) for size in sizes],
            f"{self.descriptor.name}, {self.preparation.name}: vocabularies",
        )
        vocabularies = dict(zip(sizes, found, strict=True))
        task = _BagsTask(self.preparation, self.descriptor, vocabularies, self.bags)
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
            [digest(bags, learnt.labels, self.seed, projection, MOST_BITS, code_digest(("hashing.py",)))],
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
    """Make a group of all variants of one descriptor on one preparation; arguments as in `BagGroup`."""
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
    """Weights of tf-idf (paper, equations 17 and 18), from bags of hard words.

    A word occurs on a shape if it is the nearest of any vertex. Almost every pair of words is a little near
    each other: it occurs if it has more than the share it would have if all pairs had the same.
    """
    from shapegoogle_core.weighting import InverseDocumentFrequency

    threshold = 1 / hard.shape[1] if pairs else 0.0
    weights = InverseDocumentFrequency(threshold).fit(hard.astype(np.float64)).weights_
    return np.asarray(weights, np.float32)


def _fit_vocabulary(samples: FloatArray, seed: int, words: int) -> Arrays:
    from shapegoogle_core.vocabulary import Vocabulary

    vocabulary = Vocabulary(words, random_state=seed).fit(samples)
    return {"centers": vocabulary.centers_, "sigma": np.array(vocabulary.sigma_)}


def _fit_hashing(bags: FloatBags, labels: NDArray[np.int64], seed: int, projection: str) -> Arrays:
    """Learn principal components and as many bits as are ever asked for.

    Bits are learnt one after the other, so that a shorter code is the beginning of a longer one.
    """
    from shapegoogle_core.hashing import SimilaritySensitiveHashing
    from shapegoogle_core.metric import choose_pairs

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
    """Codes as rows of 0 and 1; NaN where the bags are."""
    vectors = (bags - fitted["mean"]) @ fitted["components"].T
    values = vectors @ fitted["directions"][:bits].T + fitted["thresholds"][:bits]
    return np.asarray(np.where(np.isnan(values), np.nan, values > 0), np.float32)

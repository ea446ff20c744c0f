# SPDX-License-Identifier: MIT
"""What a training learns after the bags: weights, the metric, codes, and the calibration of similarities."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model.metric import (
    calibrate,
    choose_pairs,
    learn_projection,
    rival_pairs,
    row_distances,
)
from shapegoogle_core.model.settings import ModelSettings
from shapegoogle_core.model.shape_bags import ChannelWords, FloatBags
from shapegoogle_core.model.shape_model import ShapeModel
from shapegoogle_core.model.training.background_learning import FEWEST_SHAPES, KnownPairs, learn_background
from shapegoogle_core.model.training.steps import Progress, Run, run_here, silent
from shapegoogle_core.registration import (
    PreparedSample,
    SurfaceSample,
    align_all,
    fit_local_words,
)
from shapegoogle_core.words import (
    InverseDocumentFrequency,
    SimilaritySensitiveHashing,
    rotated_components,
)

__all__ = ["fit_metric"]

PAIRS = 10_000
"""Number of positive and of negative pairs that the codes are learnt from."""

COMPARED_PAIRS = 5_000
"""The same for the calibration of similarities, if surfaces are not aligned."""

# The same, at most, if they are: in all, and for each version, since pairs of few versions soon repeat.
_ALIGNED_PAIRS, _ALIGNED_PAIRS_PER_VERSION = 2_000, 5


def fit_metric(
    settings: ModelSettings,
    vocabularies: tuple[ChannelWords, ...],
    bags: FloatBags,
    labels: NDArray[np.int64],
    samples: Sequence[SurfaceSample] = (),
    *,
    seed: int = 0,
    trained_on: str = "",
    run: Run = run_here,
    progress: Progress = silent,
) -> ShapeModel:
    """Learn everything after the bags: weights, projection, codes and the calibration of similarities.

    Parameters
    ----------
    settings : ModelSettings
    vocabularies : tuple of ChannelWords
    bags : (n, B) array of float32
        Bags of all versions of all training shapes.
    labels : (n,) array of int
        Number of the shape that each is a version of.
    samples : sequence of SurfaceSample, optional
        Samples of all versions. Without them a spatial agreement gets no weight, and the model has no index
        of parts.
    seed : int, optional
    trained_on : str, optional
        A sentence that `shapegoogle info` shows.
    run : Run, optional
        Aligns surfaces; by default in this process.
    progress : Progress, optional

    Returns
    -------
    model : ShapeModel

    Raises
    ------
    ValueError
        If the numbers of samples and bags differ.
    ModelError
        If the shapes are too similar to each other to calibrate similarities.
    """
    if samples and len(samples) != len(bags):
        raise ValueError(f"there are {len(samples)} samples for {len(bags)} bags")
    random = np.random.default_rng(seed)
    weights = np.ones(bags.shape[1], np.float32)
    if settings.inverse_document_frequency:
        # Every word has some share of a soft bag: a word counts as present above its own mean share.
        occurrences = (bags > bags.mean(axis=0)).astype(np.float64)
        weights = InverseDocumentFrequency().fit(occurrences).weights_.astype(np.float32)
    bags = bags * weights
    mean, projection = learn_projection(bags, labels, settings.projected, settings.shrinkage)
    local_words = None
    if settings.local is not None and samples:
        learning = map(partial(fit_local_words, settings=settings.local, seed=seed), [samples])
        (local_words,) = progress(learning, "local words", 1)
    untrained = ShapeModel(
        settings=settings if local_words is not None else replace(settings, local=None),
        vocabularies=vocabularies,
        weights=weights,
        mean=mean,
        projection=projection.astype(np.float16),
        directions=np.zeros((settings.code_bits, projection.shape[1]), np.float32),
        thresholds=np.zeros(settings.code_bits, np.float32),
        similarity_half=1.0,
        similarity_slope=1.0,
        trained_on=trained_on,
        local_words=local_words,
    )
    directions, thresholds = _learn_code(settings, untrained.embed(bags).astype(np.float64), labels, seed)
    compared = untrained.comparable(bags)
    count = min(_ALIGNED_PAIRS, _ALIGNED_PAIRS_PER_VERSION * len(labels)) if samples else COMPARED_PAIRS
    first, second, similar = rival_pairs(settings.metric, compared, labels, random, count)
    distances = row_distances(settings.metric, compared[first], compared[second])
    agreements = _agreements(samples, first, second, run, progress) if samples else None
    alone = calibrate(distances, similar)
    joint = alone if agreements is None else calibrate(distances, similar, agreements)
    model = replace(
        untrained,
        directions=directions.astype(np.float32),
        thresholds=thresholds.astype(np.float32),
        similarity_half=alone.half,
        similarity_slope=alone.slope,
        agreement_gain=joint.gain,
        verified_half=joint.half,
        verified_slope=joint.slope,
    )
    _, one_each = np.unique(labels, return_index=True)
    if len(one_each) < FEWEST_SHAPES:
        return model
    verified = distances if agreements is None else distances * np.exp(-joint.gain * agreements)
    known = KnownPairs(compared[first], compared[second], distances, verified, similar)
    return model.with_parts(background=learn_background(model, compared[one_each], compared[one_each], known))


def _learn_code(
    settings: ModelSettings, vectors: FloatArray, labels: NDArray[np.int64], seed: int
) -> tuple[FloatArray, FloatArray]:
    """Learn directions and thresholds of the code."""
    if settings.code_directions == "rotated":
        directions = rotated_components(vectors, settings.code_bits, seed)
        return directions, -np.median(vectors @ directions.T, axis=0)
    hashing = SimilaritySensitiveHashing(
        settings.code_bits, projection=settings.code_directions, random_state=seed
    )
    first, second, similar = choose_pairs(labels, np.random.default_rng(seed), count=PAIRS)
    hashing.fit(vectors[first], vectors[second], similar)
    return hashing.directions_, hashing.thresholds_


def _agreements(
    samples: Sequence[SurfaceSample],
    first: NDArray[np.int64],
    second: NDArray[np.int64],
    run: Run,
    progress: Progress,
) -> FloatArray:
    """Return `Alignment.excess` of pairs of surfaces; a pair chosen several times is aligned once."""
    partners: defaultdict[int, list[int]] = defaultdict(list)
    for own, other in sorted(set(zip(first.tolist(), second.tolist(), strict=True))):
        partners[own].append(other)
    tasks = [(samples[own], [samples[other] for other in others]) for own, others in partners.items()]
    found = progress(run(_excesses, tasks), "alignments", len(tasks))
    known = {
        (own, other): excess
        for (own, others), excesses in zip(partners.items(), found, strict=True)
        for other, excess in zip(others, excesses, strict=True)
    }
    return np.array([known[pair] for pair in zip(first.tolist(), second.tolist(), strict=True)])


def _excesses(task: tuple[SurfaceSample, Sequence[SurfaceSample]]) -> list[float]:
    """Align a surface with several others at once, which is several times as fast as one by one."""
    own, others = task
    # On matrices of this size a second BLAS thread only doubles the processor time.
    with threadpool_limits(1, user_api="blas"):
        found = align_all(PreparedSample(own), others)
    return [0.0 if alignment is None else alignment.excess for alignment in found]

# SPDX-License-Identifier: MIT
"""Learning a model from shapes: vocabularies, the metric, the codes and what a similarity means.

Positive pairs are a shape in two versions: poses that came with it, and transformations made here
(noise, holes, parts cut off, …; see `shapegoogle_core.evaluation.transformations`). Negative pairs are
versions of two different shapes.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from shapegoogle_core.errors import MeshError, ModelError
from shapegoogle_core.evaluation.transformations import TRANSFORMATIONS, bend, transform
from shapegoogle_core.hashing import SimilaritySensitiveHashing
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ChannelWords, FloatBags, ShapeModel, prepare, shape_bags
from shapegoogle_core.settings import DESCRIPTORS, ModelSettings
from shapegoogle_core.spectrum import Spectrum, compute_spectrum
from shapegoogle_core.vocabulary import Vocabulary
from shapegoogle_core.weighting import InverseDocumentFrequency

__all__ = ["TrainingShape", "learn_projection", "train_model"]

logger = logging.getLogger(__name__)

Progress = Callable[[Iterable[object], str, int], Iterable[object]]


@dataclass(frozen=True, eq=False)
class TrainingShape:
    """A shape to learn from: `identity` names it, `meshes` are the same shape in one or several poses."""

    identity: str
    meshes: tuple[Mesh, ...]


@dataclass(frozen=True, eq=False)
class _Version:
    """One transformed version of a shape, made where it is needed: in a worker process."""

    label: int
    mesh: Mesh
    kind: str
    strength: int
    seed: int

    def make(self) -> Mesh:
        if self.kind == "null":
            return self.mesh
        if self.kind == "bend":
            return bend(self.mesh, self.seed, self.strength / 5)
        return transform(self.mesh, self.kind, self.strength, self.seed)


def train_model(
    shapes: Sequence[TrainingShape],
    settings: ModelSettings,
    *,
    versions: int = 10,
    jobs: int = 1,
    seed: int = 0,
    trained_on: str = "",
    progress: Progress | None = None,
) -> ShapeModel:
    """Learn a model.

    Parameters
    ----------
    shapes : sequence of TrainingShape
        At least 8 different ones; the more varied, the better it generalises.
    settings : ModelSettings
    versions : int
        How many transformed versions of each shape are made, beside its own meshes.
    jobs : int
        Worker processes.
    seed : int
        Of all random choices: the same shapes, settings and seed give the same model.
    trained_on : str
        A sentence that `shapegoogle info` shows.
    progress : callable, optional
        Wraps an iterable: `progress(iterable, description, total)`.

    Returns
    -------
    model : ShapeModel

    Raises
    ------
    ModelError
        If there are too few usable shapes.
    """
    if len(shapes) < 8:
        raise ModelError(f"a model needs at least 8 different shapes to learn from, not {len(shapes)}")
    random = np.random.default_rng(seed)
    plan = _plan_versions(shapes, versions, random)
    show = progress or (lambda iterable, description, total: iterable)
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn"), initializer=_one_thread) as pool:
        sample = [plan[i] for i in random.permutation(len(plan))[: max(400, len(plan) // 8)]]
        tasks = pool.map(_sample_descriptors, [settings] * len(sample), sample, chunksize=2)
        samples = [s for s in show(tasks, "descriptors", len(sample)) if isinstance(s, list)]
        if len(samples) < 8:
            raise ModelError(f"only {len(samples)} of {len(sample)} training shapes could be used")
        vocabularies = _learn_vocabularies(settings, samples, seed)
        tasks = pool.map(_version_bags, [settings] * len(plan), [vocabularies] * len(plan), plan, chunksize=2)
        results = list(show(tasks, "bags", len(plan)))
    usable = [index for index, bags in enumerate(results) if isinstance(bags, np.ndarray)]
    bags = np.array([results[index] for index in usable], dtype=np.float32)
    labels = np.array([plan[index].label for index in usable])
    return fit_metric(settings, vocabularies, bags, labels, seed=seed, trained_on=trained_on)


def _one_thread() -> None:
    threadpool_limits(1)


def _plan_versions(
    shapes: Sequence[TrainingShape], versions: int, random: np.random.Generator
) -> list[_Version]:
    kinds = [kind for kind in TRANSFORMATIONS if kind != "scale"]  # the search forgets the size anyway
    plan = []
    for label, shape in enumerate(shapes):
        plan += [_Version(label, mesh, "null", 0, 0) for mesh in shape.meshes]
        for _ in range(versions):
            mesh = shape.meshes[random.integers(len(shape.meshes))]
            kind = str(random.choice([*kinds, "bend"]))
            plan.append(_Version(label, mesh, kind, int(random.integers(1, 6)), int(random.integers(2**31))))
    return plan


def _version_spectrum(settings: ModelSettings, version: _Version) -> Spectrum | None:
    try:
        mesh = prepare(settings, version.make())
        return compute_spectrum(mesh, settings.eigenpairs, settings.laplacian)
    except MeshError as error:  # e.g. holes that leave nothing of a tiny shape
        logger.warning("left out of the training (%s %d): %s", version.kind, version.strength, error)
        return None


def _sample_descriptors(settings: ModelSettings, version: _Version) -> list[FloatArray] | None:
    spectrum = _version_spectrum(settings, version)
    if spectrum is None:
        return None
    random = np.random.default_rng(version.seed)
    vertices = random.permutation(len(spectrum.mass))[:750]
    return [
        DESCRIPTORS[channel.descriptor](spectrum, **channel.parameters)[vertices]
        for channel in settings.channels
    ]


def _version_bags(
    settings: ModelSettings, vocabularies: tuple[ChannelWords, ...], version: _Version
) -> FloatBags | None:
    spectrum = _version_spectrum(settings, version)
    return None if spectrum is None else shape_bags(settings, vocabularies, spectrum)


def _learn_vocabularies(
    settings: ModelSettings, samples: list[list[FloatArray]], seed: int
) -> tuple[ChannelWords, ...]:
    vocabularies = []
    for index, channel in enumerate(settings.channels):
        descriptors = np.concatenate([sample[index] for sample in samples])
        vocabulary = Vocabulary(channel.words, sigma_factor=channel.sigma_factor, random_state=seed)
        vocabulary.fit(descriptors)
        vocabularies.append(ChannelWords(vocabulary.centers_, vocabulary.sigma_))
    return tuple(vocabularies)


def fit_metric(
    settings: ModelSettings,
    vocabularies: tuple[ChannelWords, ...],
    bags: FloatBags,
    labels: NDArray[np.int64],
    *,
    seed: int = 0,
    trained_on: str = "",
) -> ShapeModel:
    """Learn what comes after the bags: weights, projection, codes and the calibration of similarities.

    Parameters
    ----------
    settings : ModelSettings
    vocabularies : tuple of ChannelWords
    bags : (n, B) array of float32
        Of all versions of all training shapes.
    labels : (n,) array of int
        Which shape each is a version of.
    seed : int
    trained_on : str
        A sentence that `shapegoogle info` shows.

    Returns
    -------
    model : ShapeModel
    """
    random = np.random.default_rng(seed)
    weights = np.ones(bags.shape[1], np.float32)
    if settings.inverse_document_frequency:
        # Soft bags contain every word a little; a word occurs where it has more than its mean share.
        threshold = float(bags.mean())
        weights = InverseDocumentFrequency(threshold).fit(bags).weights_.astype(np.float32)
    bags = bags * weights
    mean, projection = learn_projection(bags, labels, settings.projected, settings.shrinkage)
    first, second, similar = _training_pairs(labels, random, count=20_000)
    codes = SimilaritySensitiveHashing(settings.code_bits, random_state=seed)
    model = ShapeModel(
        settings=settings,
        vocabularies=vocabularies,
        weights=weights,
        mean=mean,
        projection=projection.astype(np.float16),
        directions=np.zeros((settings.code_bits, projection.shape[1]), np.float32),
        thresholds=np.zeros(settings.code_bits, np.float32),
        similarity_half=1.0,
        similarity_slope=1.0,
        trained_on=trained_on,
    )
    vectors = model.embed(bags)
    codes.fit(vectors[first], vectors[second], similar)
    distances = np.array(
        [model.distances(bags[a], bags[b : b + 1])[0] for a, b in zip(first, second, strict=True)]
    )
    half, slope = _calibrate(distances, similar)
    return ShapeModel(
        settings=settings,
        vocabularies=vocabularies,
        weights=weights,
        mean=mean,
        projection=model.projection,
        directions=codes.directions_.astype(np.float32),
        thresholds=codes.thresholds_.astype(np.float32),
        similarity_half=half,
        similarity_slope=slope,
        trained_on=trained_on,
    )


def learn_projection(
    bags: FloatBags, labels: NDArray[np.int64], dimensions: int, shrinkage: float
) -> tuple[FloatBags, FloatBags]:
    """Learn the metric: regularised linear discriminants of the training shapes.

    Principal components first; there, directions are scaled by the inverse root of the spread within
    shapes (their versions), shrunk towards a sphere, so that what transformations change counts less.

    Parameters
    ----------
    bags : (n, B) array
    labels : (n,) array of int
        Which shape each bag belongs to.
    dimensions : int
        p, at most; never more than the bags span.
    shrinkage : float
        γ in S = (1 - γ) S_within + γ tr(S_within)/p · I, from 0 to 1.

    Returns
    -------
    mean : (B,) array of float32
    projection : (B, p) array of float32
    """
    mean = bags.mean(axis=0)
    centered = (bags - mean).astype(np.float64)
    if len(centered) > bags.shape[1]:
        variances, components = scipy.linalg.eigh(centered.T @ centered / len(centered))
    else:  # the small side of the Gram matrix
        variances, left = scipy.linalg.eigh(centered @ centered.T / len(centered))
        components = centered.T @ (left / np.sqrt(np.maximum(variances, 1e-300) * len(centered)))
    order = np.argsort(variances)[::-1][:dimensions]
    order = order[variances[order] > 1e-9 * variances.max()]
    components = components[:, order]
    reduced = centered @ components
    _, group = np.unique(labels, return_inverse=True)
    counts = np.bincount(group)
    centers = np.stack([np.bincount(group, column) / counts for column in reduced.T], axis=1)
    residuals = reduced - centers[group]
    within = residuals.T @ residuals / len(residuals)
    sphere = np.trace(within) / len(within)
    shrunk = (1 - shrinkage) * within + shrinkage * sphere * np.eye(len(within))
    values, vectors = scipy.linalg.eigh(shrunk)
    projection = components @ (vectors / np.sqrt(values)) * np.sqrt(sphere)
    return mean.astype(np.float32), projection.astype(np.float32)


def _training_pairs(
    labels: NDArray[np.int64], random: np.random.Generator, count: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
    """As many positive as negative pairs of versions."""
    members = [np.flatnonzero(labels == label) for label in np.unique(labels)]
    members = [m for m in members if len(m) > 1]
    positive = [
        random.choice(members[i], 2, replace=False) for i in random.integers(len(members), size=count)
    ]
    negative = random.integers(len(labels), size=(4 * count, 2))
    negative = negative[labels[negative[:, 0]] != labels[negative[:, 1]]][:count]
    pairs = np.concatenate([np.array(positive), negative])
    return pairs[:, 0], pairs[:, 1], np.arange(len(pairs)) < len(positive)


def _calibrate(distances: FloatArray, similar: NDArray[np.bool_]) -> tuple[float, float]:
    """Logistic regression of `similar` on the logarithm of the distance: half point and slope."""
    from sklearn.linear_model import LogisticRegression

    usable = distances > 0
    logarithms = np.log(distances[usable])[:, None]
    regression = LogisticRegression(C=1e6, class_weight="balanced").fit(logarithms, similar[usable])
    slope = -float(regression.coef_[0, 0])
    if not slope > 0:
        raise ModelError("the training shapes cannot be told apart: give more varied ones")
    return float(np.exp(regression.intercept_[0] / slope)), slope

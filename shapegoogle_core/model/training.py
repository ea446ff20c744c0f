# SPDX-License-Identifier: MIT
"""Training of a model: vocabularies, the metric, the codes and the calibration of similarities.

Positive pairs are two versions of a shape: poses that came with it, or augmentations such as noise, holes and
missing parts (see `shapegoogle_core.model.augmentation`). Negative pairs are versions of two different
shapes.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol, TypeVar, cast

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from shapegoogle_core.api.arguments import check_count
from shapegoogle_core.errors import MeshError, ModelError
from shapegoogle_core.mesh import Mesh, MeshLike, as_mesh, is_mesh_like
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model.augmentation import TRANSFORMATIONS, bend, transform
from shapegoogle_core.model.background_learning import FEWEST_SHAPES, KnownPairs, learn_background
from shapegoogle_core.model.loading import SHIPPED, load_model
from shapegoogle_core.model.metric import (
    calibrate,
    choose_pairs,
    learn_projection,
    rival_pairs,
    row_distances,
)
from shapegoogle_core.model.settings import DESCRIPTORS, ModelSettings
from shapegoogle_core.model.shape_bags import ChannelWords, FloatBags, shape_bags
from shapegoogle_core.model.shape_model import ShapeModel
from shapegoogle_core.model.working_shape import WorkingShape, working_shape
from shapegoogle_core.processes.pool import CrashError, Pool, PoolTask
from shapegoogle_core.registration import (
    PreparedSample,
    SurfaceSample,
    align,
    fit_local_words,
    sample_surface,
)
from shapegoogle_core.words import (
    InverseDocumentFrequency,
    SimilaritySensitiveHashing,
    Vocabulary,
    rotated_components,
)

__all__ = ["TrainingShape", "train_model"]

PAIRS = 10_000
"""Number of positive and of negative pairs that the codes are learnt from."""

ALIGNED_PAIRS = 2_000
"""Number of positive and of negative pairs that the weight of a spatial agreement is learnt from."""

logger = logging.getLogger(__name__)

A = TypeVar("A")
T = TypeVar("T")


class Progress(Protocol):
    """Progress display of a loop, such as tqdm's."""

    def __call__(self, iterable: Iterable[T], description: str, total: int, /) -> Iterable[T]:
        """Wrap an iterable of a known length."""


def _silent(iterable: Iterable[T], _description: str, _total: int, /) -> Iterable[T]:
    return iterable


@dataclass(frozen=True, eq=False, init=False)
class TrainingShape:
    """Shape to learn from, in one or several poses.

    Parameters
    ----------
    identity : str
        Name of the shape. Training shapes of one identity are the same shape.
    meshes : MeshLike, or iterable of MeshLike
        The poses, at least one. Stored as a tuple of `Mesh`.

    Raises
    ------
    MeshError
        If a pose is not a mesh.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> import trimesh
    >>> sg.TrainingShape("box", [trimesh.creation.box((1, 2, 3))]).meshes
    (Mesh('box', 8 vertices, 12 faces),)
    """

    identity: str
    meshes: tuple[Mesh, ...]

    def __init__(self, identity: str, meshes: MeshLike | Iterable[MeshLike]) -> None:
        poses = cast("Iterable[MeshLike]", (meshes,) if is_mesh_like(meshes) else meshes)
        object.__setattr__(self, "identity", identity)
        object.__setattr__(self, "meshes", tuple(as_mesh(pose, identity) for pose in poses))


@dataclass(frozen=True, eq=False)
class _Version:
    """Augmented version of a shape, made where it is needed: in a worker process."""

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
    """Train a model.

    Vocabularies, metric, codes and calibrations are learnt from the shapes. The description of views is that
    of the shipped model of the same name, or of the default one: it needs no similar shapes.

    Parameters
    ----------
    shapes : sequence of TrainingShape
        At least 8 different ones. The more varied they are, the better the model generalises.
    settings : ModelSettings
        Such as the value "default" of `shapegoogle_core.model.PRESETS`.
    versions : int, optional
        Number of augmented versions of each shape, besides its own meshes.
    jobs : int, optional
        Number of worker processes; 0 trains in this process, as a short script or a notebook may want to.
    seed : int, optional
        Seed of all random choices: the same shapes, settings and seed give the same model.
    trained_on : str, optional
        A sentence that `shapegoogle info` shows.
    progress : callable, optional
        Wraps an iterable: ``progress(iterable, description, total)``.

    Returns
    -------
    model : ShapeModel

    Raises
    ------
    ModelError
        If there are too few usable shapes.
    ValueError
        If `versions` is less than 1, `jobs` is less than 0, or a shape is not a `TrainingShape` or has no
        mesh.

    Examples
    --------
    Worker processes import the program that started them, so it needs the usual guard:

    >>> import shapegoogle_core as sg
    >>> from shapegoogle_core.model import PRESETS
    >>> if __name__ == "__main__":  # doctest: +SKIP
    ...     shapes = [
    ...         sg.TrainingShape(str(path), (sg.read_mesh(path),)) for path in Path("meshes").glob("*.ply")
    ...     ]
    ...     sg.train_model(shapes, PRESETS["default"], jobs=4).save("mine.npz")
    """
    for shape in shapes:
        if not isinstance(shape, TrainingShape):
            raise ValueError(f"shapes must be TrainingShape(identity, meshes), not {type(shape).__name__}")
    _check_variety(len({shape.identity for shape in shapes}))
    check_count("jobs", jobs, 0)
    if versions < 1 or not all(shape.meshes for shape in shapes):
        raise ValueError("training needs at least one version and at least one mesh of every shape")
    random = np.random.default_rng(seed)
    plan = _plan_versions(shapes, versions, random)
    show = progress or _silent
    with _tasks_run(jobs) as run:
        chosen = random.permutation(len(plan))[: max(400, len(plan) // 8)]
        sampling = run(partial(_sample_descriptors, settings), [plan[i] for i in chosen])
        sampled = [sample for sample in show(sampling, "descriptors", len(chosen)) if sample is not None]
        if not sampled:
            raise ModelError("none of the training shapes could be described; see the warnings")
        vocabularies = _learn_vocabularies(settings, sampled, seed)
        describing = run(partial(_describe_version, settings, vocabularies), plan)
        described = list(show(describing, "bags", len(plan)))
    usable = [(version.label, *found) for version, found in zip(plan, described, strict=True) if found]
    labels = np.array([label for label, _, _ in usable], dtype=np.int64)
    _check_variety(len(np.unique(labels)))
    bags = np.array([bag for _, bag, _ in usable], dtype=np.float32)
    samples = [sample for _, _, sample in usable if sample is not None]
    model = fit_metric(settings, vocabularies, bags, labels, samples, seed=seed, trained_on=trained_on)
    # What is learnt about pictures needs no similar shapes, so nothing better would come of these.
    shipped = load_model(settings.name if settings.name in SHIPPED else None)
    return model.with_parts(views=shipped.views)


def _check_variety(different: int) -> None:
    if different < 8:
        raise ModelError(f"a model needs at least 8 different usable shapes to learn from, not {different}")


@contextmanager
def _tasks_run(jobs: int) -> Iterator[Callable[[Callable[[A], T], Sequence[A]], Iterator[T]]]:
    """Yield the function that maps versions to what is computed of them, in order."""
    if jobs == 0:
        yield map
        return
    with Pool(jobs, time_limit=None) as pool:
        yield lambda function, items: _results(pool.map(function, items))


def _results(tasks: Iterable[PoolTask[T]]) -> Iterator[T]:
    for task in tasks:
        try:
            yield task.result()
        except CrashError as error:
            raise ModelError(
                f"the training has ended, since a process that described a shape did ({error}); use fewer "
                "jobs if memory was short"
            ) from error


def _plan_versions(
    shapes: Sequence[TrainingShape], versions: int, random: np.random.Generator
) -> list[_Version]:
    label_of = {identity: label for label, identity in enumerate(sorted({s.identity for s in shapes}))}
    kinds = [kind for kind in TRANSFORMATIONS if kind != "scale"]  # the search forgets the size anyway
    plan = []
    for shape in shapes:
        label = label_of[shape.identity]
        plan += [_Version(label, mesh, "null", 0, 0) for mesh in shape.meshes]
        for _ in range(versions):
            mesh = shape.meshes[random.integers(len(shape.meshes))]
            kind = str(random.choice([*kinds, "bend"]))
            plan.append(_Version(label, mesh, kind, int(random.integers(1, 6)), int(random.integers(2**31))))
    return plan


def _version_shape(settings: ModelSettings, version: _Version) -> WorkingShape | None:
    try:
        return working_shape(settings, version.make())
    except MeshError as error:  # e.g. holes that leave nothing of a tiny shape
        logger.warning("left out of the training (%s %d): %s", version.kind, version.strength, error)
        return None


def _sample_descriptors(settings: ModelSettings, version: _Version) -> list[FloatArray] | None:
    shape = _version_shape(settings, version)
    if shape is None:
        return None
    random = np.random.default_rng(version.seed)
    vertices = random.permutation(len(shape.mesh.vertices))[:750]
    return [
        DESCRIPTORS[channel.descriptor](shape.mesh, shape.spectrum, **channel.parameters)[vertices]
        for channel in settings.channels
    ]


def _describe_version(
    settings: ModelSettings, vocabularies: tuple[ChannelWords, ...], version: _Version
) -> tuple[FloatBags, SurfaceSample | None] | None:
    shape = _version_shape(settings, version)
    if shape is None:
        return None
    sample = None
    if settings.sample is not None:
        sample = sample_surface(shape.mesh, shape.spectrum, settings.sample)
    return shape_bags(settings, vocabularies, shape), sample


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
    samples: Sequence[SurfaceSample] = (),
    *,
    seed: int = 0,
    trained_on: str = "",
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
        local_words = fit_local_words(samples, settings.local, seed)
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
    pairs = rival_pairs(settings.metric, compared, labels, random, ALIGNED_PAIRS if samples else 5_000)
    first, second, similar = pairs
    distances = row_distances(settings.metric, compared[first], compared[second])
    agreements = _agreements(samples, first, second) if samples else None
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
    samples: Sequence[SurfaceSample], first: NDArray[np.int64], second: NDArray[np.int64]
) -> FloatArray:
    """Return `Alignment.excess` of pairs of surfaces."""
    # On matrices of this size a second BLAS thread only doubles the processor time.
    with threadpool_limits(1, user_api="blas"):
        agreements = [
            align(PreparedSample(samples[i]), PreparedSample(samples[j])).excess
            for i, j in zip(first, second, strict=True)
        ]
    return np.array(agreements)

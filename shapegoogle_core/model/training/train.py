# SPDX-License-Identifier: MIT
"""Training of a model: vocabularies, the metric, the codes and the calibration of similarities.

Positive pairs are two versions of a shape: poses that came with it, or augmentations such as noise, holes and
missing parts (see `shapegoogle_core.model.augmentation`). Negative pairs are versions of two different
shapes.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import cast

import numpy as np

from shapegoogle_core.api.arguments import check_count
from shapegoogle_core.errors import MeshError, ModelError
from shapegoogle_core.mesh import Mesh, MeshLike, as_mesh, is_mesh_like
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model.augmentation import TRANSFORMATIONS, bend, transform
from shapegoogle_core.model.loading import SHIPPED, load_model
from shapegoogle_core.model.settings import DESCRIPTORS, ChannelSettings, ModelSettings
from shapegoogle_core.model.shape_bags import ChannelWords, FloatBags, shape_bags
from shapegoogle_core.model.shape_model import ShapeModel
from shapegoogle_core.model.training.fitting import fit_metric
from shapegoogle_core.model.training.steps import Progress, silent, tasks_run
from shapegoogle_core.model.working_shape import WorkingShape, working_shape
from shapegoogle_core.registration import SurfaceSample, sample_surface
from shapegoogle_core.words import Vocabulary

__all__ = ["TrainingShape", "train_model"]

logger = logging.getLogger(__name__)


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
    show = silent if progress is None else progress
    with tasks_run(jobs) as run:
        chosen = random.permutation(len(plan))[: max(400, len(plan) // 8)]
        sampling = run(partial(_sample_descriptors, settings), [plan[i] for i in chosen])
        sampled = [sample for sample in show(sampling, "descriptors", len(chosen)) if sample is not None]
        if not sampled:
            raise ModelError("none of the training shapes could be described; see the warnings")
        channels = list(zip(settings.channels, zip(*sampled, strict=True), strict=True))
        learning = run(partial(_learn_vocabulary, seed), channels)
        vocabularies = tuple(show(learning, "vocabularies", len(channels)))
        describing = run(partial(_describe_version, settings, vocabularies), plan)
        described = list(show(describing, "bags", len(plan)))
        usable = [(version.label, *found) for version, found in zip(plan, described, strict=True) if found]
        labels = np.array([label for label, _, _ in usable], dtype=np.int64)
        _check_variety(len(np.unique(labels)))
        bags = np.array([bag for _, bag, _ in usable], dtype=np.float32)
        samples = [sample for _, _, sample in usable if sample is not None]
        model = fit_metric(
            settings,
            vocabularies,
            bags,
            labels,
            samples,
            seed=seed,
            trained_on=trained_on,
            run=run,
            progress=show,
        )
    # What is learnt about pictures needs no similar shapes, so nothing better would come of these.
    shipped = load_model(settings.name if settings.name in SHIPPED else None)
    return model.with_parts(views=shipped.views)


def _check_variety(different: int) -> None:
    if different < 8:
        raise ModelError(f"a model needs at least 8 different usable shapes to learn from, not {different}")


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


def _learn_vocabulary(seed: int, learnt_from: tuple[ChannelSettings, tuple[FloatArray, ...]]) -> ChannelWords:
    channel, descriptors = learnt_from
    vocabulary = Vocabulary(channel.words, sigma_factor=channel.sigma_factor, random_state=seed)
    vocabulary.fit(np.concatenate(descriptors))
    return ChannelWords(vocabulary.centers_, vocabulary.sigma_)

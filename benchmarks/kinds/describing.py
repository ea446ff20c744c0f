# SPDX-License-Identifier: MIT
"""Signatures of labelled sets, kept on disk for each mesh and model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.kinds.sets import KindSet, KindShape
from benchmarks.parallel import map_in_processes
from benchmarks.protocol.cache import SIGNATURE_CODE, Arrays, BenchmarkCache, code_digest, digest
from shapegoogle_core.errors import MeshError
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.processes.progress import progress_bar
from shapegoogle_core.registration import MeshMeasures, SurfaceSample
from shapegoogle_core.views import ShapeViews

__all__ = ["DescribedSet", "describe_set"]

_KIND, _VIEWS = "signatures of kinds", "views of kinds"

_Keys = tuple[str, str]
"""Keys of the signature without views, and of the views."""


@dataclass(frozen=True, eq=False)
class DescribedSet:
    """A labelled set with its signatures.

    Attributes
    ----------
    name, use : str
        As in `KindSet`.
    names, labels : list of str
        Of the shapes that could be described.
    signatures : list of ShapeSignature
    failures : dict of str to str
        Reasons for the others, by name.
    """

    name: str
    use: str
    names: list[str]
    labels: list[str]
    signatures: list[ShapeSignature]
    failures: dict[str, str]


def describe_set(
    shapes: KindSet,
    model: ShapeModel,
    model_file: Path | str,
    cache: BenchmarkCache,
    *,
    jobs: int = 0,
    any_code: bool = False,
) -> DescribedSet:
    """Describe all shapes of a set, unless that was done before.

    Parameters
    ----------
    shapes : KindSet
    model : ShapeModel
    model_file : Path or str
        Its name or path, for worker processes.
    cache : BenchmarkCache
    jobs : int, optional
        Worker processes; 0 describes in this process.
    any_code : bool, optional
        Take signatures that were kept with this option before, even if the code has changed since.

    Returns
    -------
    described : DescribedSet
    """
    code = "" if any_code else code_digest((*SIGNATURE_CODE, "shapegoogle_core/views"))
    views = "" if model.views is None else model.views.identifier
    keys = [
        (digest(shape.key, model.identifier, code), digest(shape.key, views, code)) for shape in shapes.shapes
    ]
    missing = [
        (shape, key)
        for shape, key in zip(shapes.shapes, keys, strict=True)
        if _load(cache, model, key) is None
    ]
    if missing and jobs > 1:
        work = partial(_describe_in_worker, cache.folder, model_file)
        outcomes: Sequence[str] = map_in_processes(work, missing, jobs, shapes.name)
    else:
        outcomes = [
            _describe(cache, model, *item) for item in progress_bar(missing, shapes.name, len(missing))
        ]
    failures = {shape.name: reason for (shape, _), reason in zip(missing, outcomes, strict=True) if reason}
    found = [
        (shape, signature)
        for shape, key in zip(shapes.shapes, keys, strict=True)
        if (signature := _load(cache, model, key)) is not None
    ]
    return DescribedSet(
        shapes.name,
        shapes.use,
        [shape.name for shape, _ in found],
        [shape.label for shape, _ in found],
        [signature for _, signature in found],
        failures,
    )


def _load(cache: BenchmarkCache, model: ShapeModel, keys: _Keys) -> ShapeSignature | None:
    """Read a signature with its views; None if one of the two is missing."""
    arrays = cache.load(_KIND, keys[0])
    if arrays is None:
        return None
    signature = _from_arrays(arrays)
    if model.views is None:
        return signature
    seen = cache.load(_VIEWS, keys[1])
    if seen is None:
        return None
    views = ShapeViews(seen["views"], model.views.identifier)
    return replace(signature, views=views, view_code=model.views.code(views))


def _describe(cache: BenchmarkCache, model: ShapeModel, shape: KindShape, keys: _Keys) -> str:
    """Describe a shape and keep its signature; return the reason if that is impossible."""
    try:
        mesh = shape.mesh()
        # Apart, because another model of views leaves the bags as they are.
        cache.remembered(_KIND, keys[0], lambda: _to_arrays(replace(model, views=None).describe(mesh)))
        views = model.views
        if views is not None:
            cache.remembered(_VIEWS, keys[1], lambda: {"views": views.describe(mesh).descriptors})
    except MeshError as error:
        return str(error)
    return ""


def _to_arrays(signature: ShapeSignature) -> Arrays:
    """Convert to arrays, which later versions of the code can read too."""
    arrays: Arrays = {
        "bags": signature.bags,
        "code": signature.code,
        "numbers": np.array([signature.vertex_count, signature.face_count]),
        "lengths": np.array([signature.area, *signature.extents]),
    }
    if signature.sample is not None:
        arrays["sample"] = np.frombuffer(signature.sample.to_bytes(), np.uint8)
    if signature.local_code is not None:
        arrays["local_code"] = signature.local_code
    if signature.measures is not None:
        arrays["measures"] = np.frombuffer(signature.measures.to_bytes(), np.uint8)
    return arrays


def _from_arrays(arrays: Arrays) -> ShapeSignature:
    area, *extents = arrays["lengths"].tolist()
    vertices, faces = arrays["numbers"].tolist()
    return ShapeSignature(
        bags=arrays["bags"],
        code=arrays["code"],
        area=area,
        vertex_count=vertices,
        face_count=faces,
        sample=SurfaceSample.from_bytes(arrays["sample"].tobytes()) if "sample" in arrays else None,
        local_code=arrays.get("local_code"),
        extents=(extents[0], extents[1], extents[2]),
        measures=MeshMeasures.from_bytes(arrays["measures"].tobytes()) if "measures" in arrays else None,
    )


def _describe_in_worker(folder: Path, model_file: Path | str, item: tuple[KindShape, _Keys]) -> str:
    from shapegoogle_core.model import load_model

    return _describe(BenchmarkCache(folder), load_model(model_file), *item)

# SPDX-License-Identifier: MIT
"""Copies, same and similar shapes are grouped, each around its first member."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from trimesh.creation import icosphere

from shapegoogle_core.library.duplicates.groups import DuplicateGroup
from shapegoogle_core.library.duplicates.settings import MIN_SIMILARITY
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel, ShapeSignature
from shapegoogle_core.registration import measure_mesh

SignatureMaker = Callable[..., ShapeSignature]


def numbered(
    signature: ShapeSignature, vertices: int = 100, faces: int = 200, area: float = 1.0
) -> ShapeSignature:
    """A signature with the measures of a bumpy sphere that depends on the counts and the bags."""
    ball = icosphere(2)
    bumps = 1 + 0.1 * np.sin(5 * ball.vertices[:, :1] + vertices + float(signature.bags[:9].sum()))
    measures = measure_mesh(Mesh(np.sqrt(area) * bumps * ball.vertices, ball.faces))
    assert measures is not None
    measures = replace(measures, vertex_count=vertices, face_count=faces)
    return ShapeSignature(signature.bags, signature.code, area, vertices, faces, measures=measures)


def bent(model: ShapeModel, signature: ShapeSignature, amount: float) -> ShapeSignature:
    """A signature near another one."""
    noise = np.random.default_rng(0).standard_normal(model.bag_size).astype(np.float32)
    bags = signature.bags + amount * noise
    return numbered(ShapeSignature(bags, model.codes(bags[None])[0], 1.0, 0, 0))


@pytest.fixture
def library(path: Path, model: ShapeModel) -> Iterator[Library]:
    with Library.open(path, model) as opened:
        yield opened


def names(group: DuplicateGroup) -> list[str]:
    return [member.name for member in group.members]


def test_no_groups_in_an_empty_library_or_among_strangers(
    library: Library, make_signature: SignatureMaker
) -> None:
    assert library.duplicates() == []
    library.add_signature(make_signature(1), "one")
    assert library.duplicates() == []
    for seed in range(2, 6):
        library.add_signature(make_signature(seed), str(seed))
    assert library.duplicates(0.9999) == []


def test_the_same_measures_are_the_same_mesh_and_others_are_not_compared(
    library: Library, make_signature: SignatureMaker
) -> None:
    first = make_signature(1)
    library.add_signature(numbered(first), "first")
    library.add_signature(numbered(first, area=4.0), "twice the size")
    library.add_signature(numbered(first, vertices=101), "another vertex count")
    library.add_signature(make_signature(2), "stranger")
    similar, same = library.duplicates(0.9999)
    assert (same.kind, names(same)) == ("scaled", ["first", "twice the size"])
    assert [member.scale for member in same.members] == pytest.approx([1.0, 2.0])
    assert (same.saved_faces, same.saved_bytes, same.similarity) == (200, 0, 1.0)
    # The second of the same shapes is not listed again.
    assert (similar.kind, names(similar)) == ("not compared", ["first", "another vertex count"])
    assert similar.title == "not compared (equal size)"


def test_similar_shapes_are_found_by_their_similarity(
    library: Library, model: ShapeModel, make_signature: SignatureMaker
) -> None:
    first = make_signature(3)
    library.add_signature(numbered(first), "first")
    near, far = bent(model, first, 0.02), bent(model, first, 0.2)
    for name, signature in (("far", far), ("near", near)):
        library.add_signature(signature, name)
    similarities = model.similarity(model.distances(first.bags, np.stack([near.bags, far.bags])))
    group = library.duplicates(float(similarities.mean()))[0]
    assert (group.kind, names(group)) == ("not compared", ["first", "near"])
    assert group.similarity == pytest.approx(similarities[0], abs=1e-3)
    assert names(library.duplicates(float(similarities[1]) - 0.01)[0]) == ["first", "near", "far"]


def test_a_chain_does_not_join_a_whole_library(
    library: Library, model: ShapeModel, make_signature: SignatureMaker
) -> None:
    """Neighbours on a path are near each other, its ends are not."""
    start, end = make_signature(4), make_signature(5)
    for step in np.linspace(0, 1, 40):
        bags = ((1 - step) * start.bags + step * end.bags).astype(np.float32)
        library.add_signature(
            numbered(ShapeSignature(bags, model.codes(bags[None])[0], 1, 0, 0)), f"{step:.2f}"
        )
    groups = library.duplicates(MIN_SIMILARITY)
    assert len(groups) > 1
    for group in groups:
        first = library.signature(group.members[0].shape_id)
        bags = np.stack([library.signature(member.shape_id).bags for member in group.members])
        assert model.similarity(model.distances(first.bags, bags)).min() >= MIN_SIMILARITY - 1e-3


def test_copied_files_come_as_files_and_their_shapes_only_once(
    library: Library, make_signature: SignatureMaker
) -> None:
    bolt, nut = (numbered(make_signature(seed), faces=seed * 100) for seed in (1, 2))

    def add(path: str, content: str, *shapes: NewShape[ShapeSignature]) -> None:
        library.replace_source(path, size=1000, mtime_ns=0, sha256=content, shapes=shapes)

    add("a/kit.blend", "k", NewShape(bolt, "bolt", "bolt"), NewShape(nut, "nut", "nut"))
    add("b/kit copy.blend", "k", NewShape(bolt, "bolt", "bolt"), NewShape(nut, "nut", "nut"))
    add("c/empty.obj", "e")
    add("d/empty.obj", "e")
    add("e/nut.obj", "n", NewShape(nut, "nut.obj"))
    copies, same = library.duplicates(1.0)
    assert (copies.kind, names(copies)) == ("copies", ["kit.blend", "kit copy.blend"])
    assert (copies.saved_faces, copies.saved_bytes) == (300, 1000)
    assert [member.source for member in same.members] == ["a/kit.blend", "e/nut.obj"]
    record = copies.to_json()
    assert record["saving"] == {"faces": 300, "bytes": 1000}
    assert {"name", "source", "object_name", "shape_id"} <= set(copies.members[1].to_json())
    assert record["members"] == [member.to_json() for member in copies.members]


def test_the_largest_saving_comes_first(library: Library, make_signature: SignatureMaker) -> None:
    for seed, faces in ((1, 10), (2, 5000), (3, 300)):
        for _ in range(2):
            library.add_signature(numbered(make_signature(seed), faces=faces), str(seed))
    assert [group.saved_faces for group in library.duplicates(1.0)] == [5000, 300, 10]


@pytest.mark.parametrize("similarity", [0, -1, 1.01, float("nan")])
def test_a_similarity_out_of_range_is_refused(library: Library, similarity: float) -> None:
    with pytest.raises(ValueError, match="min_similarity must be a number above 0 and up to 1"):
        library.duplicates(similarity)


def test_other_arguments_out_of_range_are_refused(library: Library) -> None:
    with pytest.raises(ValueError, match="min_similarity must be a number above 0 and up to 1, not 'a'"):
        library.duplicates("a")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="explained must be a whole number of at least 0, not -1"):
        library.duplicates(explained=-1)


@pytest.mark.parametrize("metric", ["cosine", "l1"])
def test_both_metrics(
    path: Path, make_model: Callable[..., ShapeModel], make_signature: SignatureMaker, metric: str
) -> None:
    model = make_model(metric=metric)
    with Library.open(path, model) as library:
        for name in ("first", "second"):
            library.add_signature(numbered(make_signature(1, model)), name)
        assert [group.kind for group in library.duplicates()] == ["identical"]

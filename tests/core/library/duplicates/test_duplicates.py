# SPDX-License-Identifier: MIT
"""Copies, same and similar shapes are grouped, each around its first member."""

from __future__ import annotations

import numpy as np
import pytest

from shapegoogle_core.library import Library, NewShape
from shapegoogle_core.library.duplicates.find import MIN_SIMILARITY, distance_at
from shapegoogle_core.library.duplicates.leader_clustering import Banding, choose_banding, group_stars
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import row_distances
from shapegoogle_core.model.shape_model import ShapeSignature
from shapegoogle_core.service import requests as tasks
from shapegoogle_core.service.requests import describe_meshes, group_similar, library_duplicates


def numbered(signature, vertices=100, faces=200, area=1.0):
    return ShapeSignature(signature.bags, signature.code, area, vertices, faces)


def bent(model, signature, amount, seed=0, **counts):
    """A signature near another one."""
    noise = np.random.default_rng(seed).standard_normal(model.bag_size).astype(np.float32)
    bags = signature.bags + amount * noise
    return numbered(ShapeSignature(bags, model.codes(bags[None])[0], 1.0, 0, 0), **counts)


@pytest.fixture
def library(path, model):
    with Library.open(path, model) as opened:
        yield opened


def names(group):
    return [member.name for member in group.members]


def test_no_groups_in_an_empty_library_or_among_strangers(library, make_signature):
    assert library.duplicates() == []
    library.add_signature(make_signature(1), "one")
    assert library.duplicates() == []
    for seed in range(2, 6):
        library.add_signature(make_signature(seed), str(seed))
    assert library.duplicates(0.9999) == []


def test_the_same_bag_and_counts_are_the_same_shape(library, make_signature):
    first = make_signature(1)
    library.add_signature(numbered(first), "first")
    library.add_signature(numbered(first, area=4.0), "twice the size")
    library.add_signature(numbered(first, vertices=101), "another vertex count")
    library.add_signature(make_signature(2), "stranger")
    same, similar = library.duplicates(0.9999)
    assert (same.kind, names(same)) == ("same", ["first", "twice the size"])
    assert [member.scale for member in same.members] == [1.0, 2.0]
    assert (same.saved_faces, same.saved_bytes, same.similarity) == (200, 0, 1.0)
    # The second of the same shapes is not listed again.
    assert (similar.kind, names(similar)) == ("similar", ["first", "another vertex count"])


def test_similar_shapes_are_told_by_their_similarity(library, model, make_signature):
    first = make_signature(3)
    library.add_signature(numbered(first), "first")
    near, far = bent(model, first, 0.02), bent(model, first, 0.2)
    for name, signature in (("far", far), ("near", near)):
        library.add_signature(signature, name)
    similarities = model.similarity(model.distances(first.bags, np.stack([near.bags, far.bags])))
    group = library.duplicates(float(similarities.mean()))[0]
    assert (group.kind, names(group)) == ("similar", ["first", "near"])
    assert group.similarity == pytest.approx(similarities[0], abs=1e-3)
    assert names(library.duplicates(float(similarities[1]) - 0.01)[0]) == ["first", "near", "far"]


def test_a_chain_does_not_glue_a_library_together(library, model, make_signature):
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


def test_copied_files_come_as_files_and_their_shapes_only_once(library, make_signature):
    bolt, nut = (numbered(make_signature(seed), faces=seed * 100) for seed in (1, 2))

    def add(path, content, *shapes):
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
    assert {"name", "source", "object_name", "shape_id"} <= set(record["members"][1])


def test_the_largest_saving_comes_first(library, make_signature):
    for seed, faces in ((1, 10), (2, 5000), (3, 300)):
        for _ in range(2):
            library.add_signature(numbered(make_signature(seed), faces=faces), str(seed))
    assert [group.saved_faces for group in library.duplicates(1.0)] == [5000, 300, 10]


@pytest.mark.parametrize("similarity", [0, -1, 1.01, float("nan")])
def test_a_similarity_out_of_range_is_refused(library, similarity):
    with pytest.raises(ValueError, match="at most 1"):
        library.duplicates(similarity)


@pytest.mark.parametrize("metric", ["cosine", "l1"])
def test_both_metrics(path, make_model, make_signature, metric):
    model = make_model(metric=metric)
    with Library.open(path, model) as library:
        for name in ("first", "second"):
            library.add_signature(numbered(make_signature(1, model)), name)
        assert [group.kind for group in library.duplicates()] == ["same"]


def test_distance_at_is_the_inverse_of_similarity(model):
    similarities = np.array([0.01, 0.5, 0.95, 1.0])
    distances = np.array([distance_at(model, s) for s in similarities])
    np.testing.assert_allclose(model.similarity(distances), similarities)


def test_keys_find_what_comparing_all_finds():
    """Planted pairs at all angles up to the limit, among strangers."""
    random = np.random.default_rng(0)
    count, limit = 3000, 0.04
    vectors = random.standard_normal((count, 60)).astype(np.float32)
    vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
    angles = random.uniform(0, np.arccos(1 - limit), count // 2)[:, None]
    turned = random.standard_normal((count // 2, 60))
    turned -= (turned * vectors[: count // 2]).sum(axis=1, keepdims=True) * vectors[: count // 2]
    turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    vectors[count // 2 :] = np.cos(angles) * vectors[: count // 2] + np.sin(angles) * turned
    codes = np.packbits(vectors @ random.standard_normal((60, 256)) > 0, axis=1)

    def distances(position, others):
        return row_distances("cosine", vectors[position][None], vectors[others])

    banding = choose_banding(count, np.arccos(1 - limit) / np.pi, 256)
    stars = group_stars(codes, distances, limit, banding)
    found = np.mean(stars.leader[count // 2 :] == np.arange(count // 2))
    assert found > 0.985
    assert stars.compared < count * count / 20


def test_recall_of_keys_is_that_of_chance():
    assert Banding(key_bits=2, keys=2).recall(0.5) == pytest.approx(1 - (1 - 0.25) ** 2)


def test_signatures_without_a_library_are_grouped_alike(model, make_signature):
    first, stranger = make_signature(3), make_signature(8)
    near = bent(model, first, 0.02)
    assert group_similar(model, []) == []
    ((leader, member),) = group_similar(model, [stranger, first, near], 0.9)
    assert (leader, member[0]) == ((1, 1.0), 2)
    assert member[1] == pytest.approx(
        model.similarity(model.distances(first.bags, near.bags[None]))[0], abs=1e-3
    )


def test_a_mesh_that_cannot_be_described_costs_only_itself(model, meshes):
    good, bad = describe_meshes(model, [meshes[0], Mesh(np.zeros((4, 3)), name="a speck")])
    assert isinstance(good, ShapeSignature)
    assert "a speck" in bad


def test_a_library_by_its_path(path, model, make_signature, monkeypatch):
    with Library.open(path, model) as library:
        for name in "ab":
            library.add_signature(numbered(make_signature(1)), name)
    opened = []
    monkeypatch.setattr(
        tasks.Library, "open", lambda *a, _open=Library.open, **k: opened.append(a) or _open(*a, **k)
    )
    assert [names(group) for group in library_duplicates(path)] == [["a", "b"]]
    assert [names(group) for group in library_duplicates(path)] == [["a", "b"]]
    assert len(opened) == 1


def test_the_model_by_its_place(path, model, meshes, tmp_path):
    Library.open(path, model).close()
    model.save(tmp_path / "model.npz")
    (expected,) = describe_meshes(model, meshes[:1])
    for place in (path, str(tmp_path / "model.npz")):
        (signature,) = describe_meshes(place, meshes[:1])
        np.testing.assert_array_equal(signature.bags, expected.bags)

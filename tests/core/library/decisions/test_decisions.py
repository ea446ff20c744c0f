# SPDX-License-Identifier: MIT
"""Decisions in a library: what they change, that they last, and that they can be taken back."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel, ShapeSignature

SignatureMaker = Callable[..., ShapeSignature]


@pytest.fixture
def library(
    place: str, model: ShapeModel, make_signature: SignatureMaker, tmp_path: Path
) -> Iterator[Library]:
    """Shapes 1 to 3 in files of a root, of which the first two are copies; 4 without a source."""
    (tmp_path / "files").mkdir()
    with Library.open(place, model) as opened:
        opened.add_root(tmp_path / "files", "files")
        for name, seed in (("a.obj", 1), ("b.obj", 1), ("c.obj", 2)):
            index(opened, tmp_path / "files" / name, make_signature(seed), sha256=f"hash of {name}")
        opened.add_signature(make_signature(1), "free")
        yield opened


def index(library: Library, path: Path, signature: ShapeSignature, *, sha256: str) -> int:
    shape = NewShape(signature, path.name)
    (number,) = library.replace_source(path, size=1, mtime_ns=1, sha256=sha256, shapes=[shape])
    return number


def found(library: Library, signature: ShapeSignature) -> list[str]:
    return [match.name for match in library.query(signature, top=10, explain=0)]


def members(library: Library) -> list[list[str]]:
    return [[member.name for member in group.members] for group in library.duplicates(0.9)]


def test_a_library_without_decisions_has_none(library: Library) -> None:
    assert library.decisions() == []
    with pytest.raises(LibraryError, match="has no decision 1; list them"):
        library.undo(1)


def test_what_is_not_a_match_is_hidden_from_that_query_only(
    library: Library, make_signature: SignatureMaker
) -> None:
    asked = make_signature(3)
    everything = found(library, asked)
    made = library.decide("not a match", asked, 2, author="ana")
    assert found(library, asked) == [name for name in everything if name != "b.obj"]
    assert found(library, make_signature(4)) == found(library, make_signature(4))
    assert "b.obj" in found(library, make_signature(4))
    assert len(library.query(asked, top=3, explain=0)) == 3
    assert library.undo(made.number) == made
    assert found(library, asked) == everything


def test_families_do_not_count_what_is_not_a_match(library: Library, make_signature: SignatureMaker) -> None:
    library.decide("not a match", 1, 2)
    best = library.query(make_signature(1), families=True, explain=0)[0]
    assert best.versions == len(best.version_ids)
    assert 2 not in {best.shape_id, *best.version_ids}


def test_the_next_of_a_family_stands_for_it_when_the_best_is_not_a_match(
    library: Library, make_signature: SignatureMaker
) -> None:
    asked = make_signature(1)
    copies = library.query(asked, families=True, explain=0)[0]
    family = {copies.shape_id, *copies.version_ids}
    assert len(family) == 3
    library.decide("not a match", asked, copies.shape_id)
    best, *others = library.query(asked, families=True, explain=0)
    assert {best.shape_id, *best.version_ids} == family - {copies.shape_id}
    assert (best.versions, len(best.version_ids)) == (1, 1)
    assert not family & {match.shape_id for match in others}
    # When none of them is one, the next family comes first.
    for shape_id in family - {copies.shape_id}:
        library.decide("not a match", asked, shape_id)
    assert [match.name for match in library.query(asked, families=True, explain=0)] == ["c.obj"]


def test_both_shapes_that_are_kept_are_no_duplicates(library: Library) -> None:
    assert members(library) == [["a.obj", "b.obj", "free"]]
    kept = library.decide("keep both", 1, 2)
    assert members(library) == [["a.obj", "free"]]
    library.decide("keep both", 4, 1)
    assert members(library) == []
    library.undo(kept.number)
    assert members(library) == [["a.obj", "b.obj"]]


def test_the_last_master_comes_first(library: Library) -> None:
    library.decide("master", 4)
    library.decide("master", 2)
    (group,) = library.duplicates(0.9)
    assert [member.name for member in group.members] == ["b.obj", "free", "a.obj"]
    assert [member.similarity for member in group.members] == [1.0, 1.0, 1.0]


def test_decisions_survive_indexing_again_and_moving(
    library: Library, make_signature: SignatureMaker, tmp_path: Path, place: str
) -> None:
    folder = tmp_path / "files"
    library.decide("not a match", 1, 3, author="ana")
    library.decide("tag", 2, tag="wood")
    # The same file again, then one with the content of another under a new name.
    index(library, folder / "a.obj", make_signature(1), sha256="hash of a.obj")
    index(library, folder / "b.obj", make_signature(5), sha256="changed")
    library.remove(folder / "c.obj")
    moved = index(library, folder / "moved.obj", make_signature(2), sha256="hash of c.obj")
    assert moved not in [match.shape_id for match in library.query(make_signature(1), explain=0)]
    wooden = library.query(make_signature(1), explain=0, where=Filter(tag="wood"))
    assert [match.name for match in wooden] == ["b.obj"]
    library.close()
    with Library.open(place, read_only=True) as again:
        assert [decision.author for decision in again.decisions()] == ["ana", ""]
        assert moved not in [match.shape_id for match in again.query(make_signature(1), explain=0)]


def test_decisions_follow_a_file_that_is_given_another_name(library: Library) -> None:
    library.add_signature(library.signature(1), "chair", source="scene", object_name="chair")
    library.decide("master", 5)
    library.rename_source("scene", "scene of ana")
    assert library.decisions()[0].shape.path == "scene of ana"
    assert library.duplicates(0.9)[0].members[0].name == "chair"


def test_tags_are_given_taken_and_put_back(library: Library) -> None:
    given = library.decide("tag", 3, tag=" steel ", author="ben")
    assert library.shape(3).tags == ("steel",)
    taken = library.decide("no tag", 3, tag="steel")
    assert library.shape(3).tags == ()
    library.undo(taken.number)
    assert library.shape(3).tags == ("steel",)
    library.undo(given.number)
    assert library.shape(3).tags == ()
    assert library.decisions() == []


def test_the_last_decision_that_is_left_says_which_tag_a_shape_has(library: Library) -> None:
    first = library.decide("tag", 3, tag="steel")
    taken = library.decide("no tag", 3, tag="steel")
    last = library.decide("tag", 3, tag="steel")
    library.decide("tag", 3, tag="old")
    library.undo(first.number)
    assert library.shape(3).tags == ("old", "steel")
    library.undo(last.number)
    assert library.shape(3).tags == ("old",)
    library.undo(taken.number)
    assert library.shape(3).tags == ("old", "steel")


def test_all_shapes_of_decisions_are_found_at_once(library: Library, make_signature: SignatureMaker) -> None:
    store = library._store
    keys = list(store.shape_keys([1, 2, 3, 4]).values())
    asked = [replace(keys[0], path="gone.obj"), replace(keys[1], name="other"), *keys, keys[0]]
    asked += [replace(keys[0], path="gone.obj", file_hash="other"), replace(keys[0], root="unknown")]
    # By the content of their files where these are gone, each once.
    assert store.shapes_of(asked) == [1, 2, 1, 2, 3, 4, 1, None, 1]
    assert store.shapes_of(300 * keys) == 300 * [1, 2, 3, 4]
    # Two files of one content: nobody knows which is meant.
    library.replace_source(
        "copy.obj", size=1, mtime_ns=1, sha256=keys[0].file_hash, shapes=[NewShape(make_signature(1), "copy")]
    )
    assert store.shapes_of(asked[:1]) == [None]


@pytest.mark.parametrize(
    ("arguments", "options", "sentence"),
    [
        (("no match", 1), {}, "there is no decision 'no match'"),
        (("master", 1, 2), {}, "is about one shape"),
        (("keep both", 1), {}, "is about two shapes"),
        (("keep both", 1, 1), {}, "give another one than shape 1"),
        (("tag", 1), {}, "must not be empty"),
        (("master", 1), {"tag": "x"}, "a tag belongs to"),
        (("no tag", 1), {"tag": "x"}, "does not have the tag 'x' already"),
    ],
)
def test_arguments_that_do_not_fit(
    library: Library, arguments: tuple[object, ...], options: dict[str, str], sentence: str
) -> None:
    with pytest.raises(ValueError, match=sentence):
        library.decide(*arguments, **options)  # type: ignore[arg-type]


def test_an_unknown_shape_is_named(library: Library) -> None:
    with pytest.raises(LibraryError, match="has no shape 99"):
        library.decide("master", 99)
    with pytest.raises(LibraryError, match="has no shape 99"):
        library.preview(99)


def test_the_shape_of_a_query_is_known_by_its_mesh(place: str, model: ShapeModel, meshes: list[Mesh]) -> None:
    with Library.open(place, model) as library:
        for number, mesh in enumerate(meshes[:3]):
            library.add(mesh, name=str(number))
        library.decide("not a match", 1, 2)
        # The mesh itself, as an artist selects it, not its stored signature.
        assert {match.shape_id for match in library.query(meshes[0], explain=0)} == {1, 3}
        assert {match.shape_id for match in library.query(meshes[2], explain=0)} == {1, 2, 3}

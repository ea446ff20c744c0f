# SPDX-License-Identifier: MIT
"""What a library refuses, and that nothing of it goes in."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shapegoogle_core.errors import LibraryError, MeshError
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel, ShapeSignature


def test_a_bad_mesh_costs_nothing(place: str, model: ShapeModel, meshes: list[Mesh]) -> None:
    with Library.open(place, model) as library:
        library.add(meshes[0], name="good")
        points = Mesh(np.zeros((4, 3)), [[0, 1, 2], [0, 2, 3]], name="all in one place")
        with pytest.raises(MeshError, match="all in one place"):
            library.add(points)
        assert [shape.name for shape in library.shapes()] == ["good"]


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e6])
def test_bags_that_are_not_finite_are_refused(
    place: str, model: ShapeModel, make_signature: Callable[..., ShapeSignature], value: float
) -> None:
    signature = make_signature(1)
    bags = signature.bags.copy()
    bags[2] = value
    with (
        Library.open(place, model) as library,
        pytest.raises(LibraryError, match="'broken' has a bag with NaN, infinite or huge"),
    ):
        library.add_signature(type(signature)(bags, signature.code, 1.0, 3, 1), "broken")


def test_a_signature_of_another_model_is_refused(
    place: str,
    model: ShapeModel,
    make_model: Callable[..., ShapeModel],
    make_signature: Callable[..., ShapeSignature],
) -> None:
    long_codes = make_model(code_bits=80)
    with Library.open(place, model) as library:
        signature = make_signature(1, of=long_codes)
        with pytest.raises(
            LibraryError, match=r"'horse' was described with another model.* 80 bits instead of .*72"
        ):
            library.add_signature(signature, "horse")
        with pytest.raises(LibraryError, match="another model"):
            library.replace_source(
                "a", size=1, mtime_ns=1, sha256=None, shapes=[NewShape(signature, "horse")]
            )
        with pytest.raises(LibraryError, match="another model"):
            library.query(signature, explain=0)
        assert len(library) == 0
        assert library.sources() == {}


def test_one_of_many_fails_and_none_goes_in(
    place: str, model: ShapeModel, make_signature: Callable[..., ShapeSignature]
) -> None:
    with Library.open(place, model) as library:
        library.replace_source(
            "a", size=1, mtime_ns=1, sha256="ab", shapes=[NewShape(make_signature(0), "old")]
        )
        shapes = [
            NewShape(make_signature(1), "new"),
            # A picture that no database can take: the error comes in the middle of the transaction.
            NewShape(make_signature(2), "newer", thumbnail=b"PNG".hex),  # type: ignore[arg-type]
        ]
        with pytest.raises(LibraryError, match="cannot store this value"):
            library.replace_source("a", size=2, mtime_ns=2, sha256="cd", shapes=shapes)
        assert [shape.name for shape in library.shapes()] == ["old"]
        assert library.sources()["a"].sha256 == "ab"
        library.add_signature(make_signature(3), "and on it goes")
        assert len(library) == 2


def test_unknown_shapes_are_named(path: Path, model: ShapeModel) -> None:
    with Library.open(path, model) as library:
        for ask in (library.signature, library.thumbnail):
            with pytest.raises(LibraryError, match=r"shapes\.sglib' has no shape 7"):
                ask(7)


def test_one_tag_is_not_taken_apart(place: str, model: ShapeModel, meshes: list[Mesh]) -> None:
    with Library.open(place, model) as library:
        library.add(meshes[0], tags="wood")
        (shape,) = library.shapes()
    assert shape.tags == ("wood",)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"name": 5}, "name must be a text, not 5"),
        ({"source": 5}, "a path must be a str or a pathlib.Path, not 5"),
        ({"object_name": None}, "object_name must be a text, not None"),
        ({"thumbnail": "x"}, "thumbnail must be the bytes of a PNG file, not 'x'"),
        ({"tags": ["wood", 5]}, "tags must be a text, or several, not 5"),
    ],
)
def test_arguments_of_wrong_types_are_named(
    place: str, model: ShapeModel, meshes: list[Mesh], arguments: dict[str, Any], message: str
) -> None:
    with Library.open(place, model) as library:
        with pytest.raises(ValueError, match=message):
            library.add(meshes[0], **arguments)
        with pytest.raises(ValueError, match=message):
            library.add_signature(model.describe(meshes[0]), **{"name": "a", **arguments})
        assert len(library) == 0


def test_one_folder_is_not_taken_apart(path: Path, model: ShapeModel) -> None:
    with Library.open(path, model) as library:
        assert library.missing(str(path.parent)) == library.remove_missing(path.parent) == []
        with pytest.raises(LibraryError, match=r"'.*absent' does not exist"):
            library.missing("absent")
        with pytest.raises(ValueError, match="a path must be a str"):
            library.missing(None)  # type: ignore[arg-type]

# SPDX-License-Identifier: MIT
"""What shapes are in their files: stored, found by filters, and unknown in libraries that lack it."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

import shapegoogle_core as sg
from shapegoogle_core.library.origin import Origin
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.model.signature import ShapeSignature
from tests.core.tiny_model import SignatureMaker


def fill(library: sg.Library, make_signature: SignatureMaker) -> None:
    def shape(name: str, object_name: str, origin: Origin, *tags: str, seed: int) -> NewShape[ShapeSignature]:
        return NewShape(make_signature(seed), name, object_name, tags=tags, origin=origin)

    shapes = [
        shape("Lamp", "Lamp", Origin("collection", "Props/Lamps"), "light", seed=1),
        shape("Möbel", "Chair", Origin("object", "Props/Möbel"), seed=2),
        shape("Horse @ 10", "Horse", Origin(frame=10), seed=3),
        shape("Plain", "Plain", Origin(), seed=4),
        shape("file.obj", "", Origin(), seed=5),
        shape("Sign", "Sign", Origin("text", "Propeller"), seed=6),
    ]
    library.replace_source("a.blend", size=1, mtime_ns=1, sha256="ab", shapes=shapes)


def names(library: sg.Library, make_signature: SignatureMaker, **conditions: object) -> set[str]:
    where = sg.Filter(**conditions)  # type: ignore[arg-type]
    return {match.name for match in library.query(make_signature(1), explain=0, where=where)}


def test_origins_are_stored_and_found(
    place: str, model: sg.ShapeModel, make_signature: SignatureMaker
) -> None:
    with sg.Library.open(place, model) as library:
        fill(library, make_signature)
        origins = {shape.name: shape.origin for shape in library.shapes()}
        assert origins["Lamp"] == Origin("collection", "Props/Lamps")
        assert origins["Horse @ 10"] == Origin("object", "", 10)
        assert (origins["Plain"].shape_type, origins["file.obj"].shape_type) == ("object", "file")
        assert names(library, make_signature, shape_type="collection") == {"Lamp"}
        assert names(library, make_signature, shape_type="object") == {"Möbel", "Horse @ 10", "Plain"}
        assert names(library, make_signature, shape_type="file") == {"file.obj"}
        assert names(library, make_signature, catalog="props") == {"Lamp", "Möbel"}
        assert names(library, make_signature, catalog="Props/Lamps/") == {"Lamp"}
        assert names(library, make_signature, text="LIGHT") == {"Lamp"}
        assert names(library, make_signature, text="prop") == {"Lamp", "Möbel", "Sign"}
        (match,) = library.query(make_signature(1), top=1, explain=0)
        record = match.to_json()
        assert (record["shape_type"], record["tags"], record["catalog"]) == (
            "collection",
            ["light"],
            "Props/Lamps",
        )
        library.remove("a.blend")
        assert names(library, make_signature, shape_type="object") == set()


def test_libraries_without_origins_are_read(
    tmp_path: Path, model: sg.ShapeModel, make_signature: SignatureMaker
) -> None:
    path = tmp_path / "shapes.sglib"
    with sg.Library.open(path, model) as library:
        fill(library, make_signature)
    with closing(sqlite3.connect(path)) as file:
        file.execute("DROP TABLE origins")
        file.commit()
    with sg.Library.open(path, read_only=True) as library:
        assert {shape.origin.shape_type for shape in library.shapes()} == {"object", "file"}
        assert names(library, make_signature, shape_type="file") == {"file.obj"}
        assert names(library, make_signature, shape_type="collection") == set()
        assert names(library, make_signature, catalog="Props") == set()
        assert names(library, make_signature, text="light") == {"Lamp"}
    with sg.Library.open(path) as library:
        fill(library, make_signature)
        assert names(library, make_signature, shape_type="collection") == {"Lamp"}


def test_types_that_do_not_exist_are_refused() -> None:
    with pytest.raises(ValueError, match="no type of shape 'lamp'; choose one of file, object"):
        sg.Filter(shape_type="lamp")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="catalog must be a text"):
        sg.Filter(catalog=" ")

# SPDX-License-Identifier: MIT
"""Files of models: read back as they were, and refused if they are damaged, newer or not models."""

from __future__ import annotations

import io
import json
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from shapegoogle_core.errors import ModelError
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel, load_model


@pytest.fixture(scope="module")
def model() -> ShapeModel:
    return load_model()


def test_saved_model_describes_alike(tmp_path: Path, bumpy: Mesh, model: ShapeModel) -> None:
    model.save(tmp_path / "mine.npz")
    loaded = load_model(tmp_path / "mine.npz")
    np.testing.assert_array_equal(loaded.describe(bumpy).bags, model.describe(bumpy).bags)
    np.testing.assert_array_equal(loaded.describe(bumpy).code, model.describe(bumpy).code)


def changed_archive(model: ShapeModel, **changes: ArrayLike | None) -> bytes:
    with np.load(io.BytesIO(model.to_bytes())) as archive:
        entries = {name: archive[name] for name in archive.files}
    for name, value in changes.items():
        if value is None:
            del entries[name]
        else:
            entries[name] = np.asarray(value)
    buffer = io.BytesIO()
    np.savez(buffer, **entries)
    return buffer.getvalue()


def test_any_truncation_is_a_model_error(model: ShapeModel) -> None:
    data = model.to_bytes()
    for length in [0, 1, 10, 100, len(data) // 2, len(data) - 100, len(data) - 1]:
        with pytest.raises(ModelError, match="not a Shape Google model"):
            ShapeModel.from_bytes(data[:length])


@pytest.fixture(scope="module")
def model_bytes(model: ShapeModel) -> bytes:
    return model.to_bytes()


@settings(max_examples=60, deadline=None)
@given(position=st.floats(0, 1, exclude_max=True), value=st.integers(1, 255))
def test_flipped_bytes_never_give_another_error(position: float, value: int, model_bytes: bytes) -> None:
    data = bytearray(model_bytes)
    data[int(position * len(data))] ^= value
    with suppress(ModelError):  # a byte that means nothing changes nothing
        ShapeModel.from_bytes(bytes(data))


def test_contradictions_in_the_file_are_refused(model: ShapeModel) -> None:
    cases: list[tuple[dict[str, ArrayLike | None], str]] = [
        ({"mean": model.mean[:-1]}, "mean"),
        ({"thresholds": np.full_like(model.thresholds, np.nan)}, "thresholds"),
        ({"directions": None}, "not a Shape Google model"),
        ({"header": np.array("[]")}, "not a Shape Google model"),
        ({"header": np.array("{")}, "not a Shape Google model"),
        ({"sigmas": np.full(len(model.vocabularies), np.inf)}, "vocabulary"),
        ({"sigmas": -np.ones(len(model.vocabularies))}, "vocabulary"),
        ({"centers_0": np.ones((2, 2))}, "vocabulary"),
    ]
    for changes, message in cases:
        with pytest.raises(ModelError, match=message):
            ShapeModel.from_bytes(changed_archive(model, **changes))


@pytest.mark.parametrize("name", ["similarity_half", "similarity_slope"])
@pytest.mark.parametrize("value", [0.0, -2.0, float("nan")])
def test_damaged_calibration_is_refused(name: str, value: float, model: ShapeModel) -> None:
    with np.load(io.BytesIO(model.to_bytes())) as archive:
        header = json.loads(str(archive["header"]))
    header[name] = value
    with pytest.raises(ModelError, match="calibration"):
        ShapeModel.from_bytes(changed_archive(model, header=np.array(json.dumps(header))))


def test_newer_format_says_update(model: ShapeModel) -> None:
    with np.load(io.BytesIO(model.to_bytes())) as archive:
        header = json.loads(str(archive["header"]))
    header["format"] = 99
    with pytest.raises(ModelError, match="update Shape Google"):
        ShapeModel.from_bytes(changed_archive(model, header=np.array(json.dumps(header))))


def test_pickles_are_never_loaded(model: ShapeModel) -> None:
    data = changed_archive(model, mean=np.array([{"a": 1}], dtype=object))
    with pytest.raises(ModelError, match="not a Shape Google model"):
        ShapeModel.from_bytes(data)


def test_missing_model_names_what_there_is(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="default, paper"):
        load_model(tmp_path / "none.npz")
    with pytest.raises(ModelError, match="cannot read the model"):
        load_model(tmp_path)
    with pytest.raises(ModelError, match="cannot write the model"):
        load_model().save(tmp_path / "no" / "folder.npz")


def test_former_codes_of_local_words_still_count_in_the_identifier(model: ShapeModel) -> None:
    """Files that do not state the identifier had codes of local words, which nothing reads now."""
    with np.load(io.BytesIO(model.to_bytes())) as archive:
        entries = {name: archive[name] for name in archive.files}
    header = json.loads(str(entries["header"]))
    assert header.pop("identifier") == model.identifier
    header["settings"]["local"]["bits"] = 8
    words = len(entries["local_weights"])
    former: dict[str, ArrayLike | None] = {
        "local_mean": np.zeros(words, np.float32),
        "local_directions": np.ones((8, words), np.int8),
        "header": np.array(json.dumps(header)),
    }
    loaded = ShapeModel.from_bytes(changed_archive(model, **former))
    other = {**former, "local_directions": -np.ones((8, words), np.int8)}
    assert loaded.identifier != ShapeModel.from_bytes(changed_archive(model, **other)).identifier
    assert ShapeModel.from_bytes(loaded.to_bytes()).identifier == loaded.identifier
    assert replace(loaded, trained_on="other").identifier == replace(model, trained_on="other").identifier


def test_the_error_does_not_quote_numpy(tmp_path: Path) -> None:
    (tmp_path / "h.py").write_text("import this")
    with pytest.raises(ModelError, match="is not a Shape Google model, or it is damaged; train or copy it"):
        load_model(tmp_path / "h.py")

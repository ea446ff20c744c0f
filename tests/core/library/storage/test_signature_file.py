# SPDX-License-Identifier: MIT
"""Signatures as bytes: the same after reading them, and nothing but signatures is accepted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

import shapegoogle_core as sg
from shapegoogle_core.library.storage.signature_file import signature_from_bytes, signature_to_bytes
from shapegoogle_core.model import ShapeModel, ShapeSignature


@pytest.fixture(scope="module")
def default() -> ShapeModel:
    return sg.load_model()


@pytest.fixture(scope="module")
def signature(default: ShapeModel) -> ShapeSignature:
    return default.describe(trimesh.creation.torus(2, 0.5), keep_surface=True)


def test_an_exact_copy_answers_as_the_original(default: ShapeModel, signature: ShapeSignature) -> None:
    again = signature_from_bytes(signature_to_bytes(signature, exact=True), default)
    for name in ("bags", "code", "local_code", "view_code"):
        np.testing.assert_array_equal(getattr(again, name), getattr(signature, name))
    assert again.sample is not None
    assert signature.sample is not None
    assert again.surface is not None
    assert signature.surface is not None
    np.testing.assert_array_equal(again.sample.points, signature.sample.points)
    np.testing.assert_array_equal(again.surface.vertices, signature.surface.vertices)
    assert again.measures is not None
    assert signature.measures is not None
    assert again.measures.hash == signature.measures.hash


def test_a_short_copy_is_small(default: ShapeModel, signature: ShapeSignature) -> None:
    content = signature_to_bytes(signature)
    assert len(content) < 30_000
    again = signature_from_bytes(content, default)
    np.testing.assert_array_equal(again.bags, signature.bags)
    assert again.surface is None


def test_signatures_of_other_models_are_refused(model: ShapeModel, signature: ShapeSignature) -> None:
    with pytest.raises(sg.LibraryError, match="was described with another model"):
        signature_from_bytes(signature_to_bytes(signature), model)


@pytest.mark.parametrize("field", ["bags", "area"])
def test_numbers_that_are_none_are_refused(
    default: ShapeModel, signature: ShapeSignature, field: str
) -> None:
    value = np.full_like(signature.bags, np.nan) if field == "bags" else float("nan")
    with pytest.raises(ValueError, match="not a signature"):
        signature_from_bytes(signature_to_bytes(replace(signature, **{field: value})), default)  # type: ignore[arg-type]


@given(cut=st.integers(0, 25_000), changed=st.integers(0, 25_000), byte=st.integers(0, 255))
def test_damaged_content_is_refused_or_read(
    default: ShapeModel, signature: ShapeSignature, cut: int, changed: int, byte: int
) -> None:
    content = bytearray(signature_to_bytes(signature))
    content[changed % len(content)] = byte
    for damaged in (bytes(content), bytes(content[:cut])):
        try:
            read = signature_from_bytes(damaged, default)
        except (ValueError, sg.LibraryError):
            continue
        assert np.isfinite(read.bags).all()

# SPDX-License-Identifier: MIT
"""What the benchmark keeps on disk: entries whole or not at all, keys that say what they stand for."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.errors import BenchmarkError
from benchmarks.protocol.spectra_cache import (
    PREPARATION_CODE,
    SEARCH_CODE,
    SIGNATURE_CODE,
    BenchmarkCache,
    cached_shape,
    code_digest,
    content_digest,
    digest,
    preparation_of,
)
from shapegoogle_core.descriptors import heat_kernel_signature
from shapegoogle_core.model import PRESETS
from shapegoogle_core.model.working_shape import working_shape
from shapegoogle_core.words import soft_words, spatially_sensitive_bag


def test_entries_come_back(cache: BenchmarkCache) -> None:
    arrays = {"values": np.arange(6.0).reshape(2, 3), "names": np.array(["a", "bc"])}
    assert cache.load("things", "00ff") is None
    cache.store("things", "00ff", arrays)
    found = cache.load("things", "00ff")
    assert found is not None
    assert set(found) == {"values", "names"}
    np.testing.assert_array_equal(found["values"], arrays["values"])
    np.testing.assert_array_equal(found["names"], arrays["names"])
    assert [path.name for path in cache.folder.rglob("*") if path.is_file()] == ["00ff.npz"]


@pytest.mark.parametrize("damage", ["cut short", "empty", "other", "pickle"])
def test_damaged_entries_are_made_again(cache: BenchmarkCache, damage: str) -> None:
    cache.store("things", "00ff", {"values": np.arange(1000.0)})
    path = cache.path("things", "00ff")
    if damage == "pickle":
        with path.open("wb") as file:
            np.savez(file, values=np.array([object()], dtype=object))
    else:
        whole = path.read_bytes()
        path.write_bytes({"cut short": whole[:-40], "empty": b"", "other": b"<html>"}[damage])
    assert cache.load("things", "00ff") is None
    made = cache.remembered("things", "00ff", lambda: {"values": np.ones(3)})
    np.testing.assert_array_equal(made["values"], np.ones(3))
    again = cache.remembered("things", "00ff", lambda: pytest.fail("it is there"))
    np.testing.assert_array_equal(again["values"], np.ones(3))


def test_a_folder_that_cannot_be(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("no folder")
    with pytest.raises(BenchmarkError, match="cannot make the cache"):
        BenchmarkCache(tmp_path / "file" / "cache")


def test_a_digest_tells_all_apart() -> None:
    parts = [
        [],
        ["a"],
        ["b"],
        ["a", "b"],
        [["a", "b"]],
        [1],
        [1.5],
        [None],
        [b"a"],
        [np.arange(4)],
        [np.arange(4.0)],
        [np.arange(4).reshape(2, 2)],
        [{"a": 1}],
    ]
    assert len({digest(*part) for part in parts}) == len(parts)
    assert digest({"a": 1, "b": 2}) == digest({"b": 2, "a": 1})
    assert digest("a") == digest("a")


def test_content_decides_not_the_name(tmp_path: Path) -> None:
    for name, text in {"a": "one", "b": "one", "c": "two"}.items():
        (tmp_path / name).write_text(text)
    assert content_digest(tmp_path / "a") == content_digest(tmp_path / "b")
    assert content_digest(tmp_path / "a") != content_digest(tmp_path / "c")
    assert content_digest(tmp_path / "gone") == ""


def test_code_of_all_stages_is_found() -> None:
    stages = [PREPARATION_CODE, SIGNATURE_CODE, SEARCH_CODE, ("nothing.py",)]
    assert len({code_digest(stage) for stage in stages}) == 4


def test_a_shape_is_the_same_from_the_cache(cache: BenchmarkCache, bumpy) -> None:
    settings = replace(PRESETS["paper"], eigenpairs=40)
    first = cached_shape(cache, settings, "key", lambda: bumpy)
    again = cached_shape(cache, settings, "key", lambda: pytest.fail("it is there"))
    for name in ("eigenvalues", "eigenvectors", "mass"):
        np.testing.assert_array_equal(getattr(first.spectrum, name), getattr(again.spectrum, name))
    assert first.spectrum.eigenvectors.dtype == np.float64
    np.testing.assert_array_equal(first.mesh.vertices, again.mesh.vertices)
    np.testing.assert_array_equal(first.mesh.faces, again.mesh.faces)
    np.testing.assert_allclose(again.placement.apply(bumpy.vertices), again.mesh.vertices, atol=1e-9)


def test_single_precision_moves_no_bag(cache: BenchmarkCache, bumpy) -> None:
    settings = replace(PRESETS["paper"], eigenpairs=100)
    (channel,) = settings.channels

    def pairs(spectrum):
        values = heat_kernel_signature(spectrum, channel.parameters["times"], normalize=True)
        return spatially_sensitive_bag(soft_words(values, centers, 0.01), spectrum, channel.pair_time)

    exact = working_shape(settings, bumpy).spectrum
    centers = heat_kernel_signature(exact, channel.parameters["times"], normalize=True)[::40]
    kept = cached_shape(cache, settings, "key", lambda: bumpy).spectrum
    assert np.abs(pairs(kept) - pairs(exact)).sum() < 1e-5


def test_only_the_preparation_decides_on_a_spectrum() -> None:
    default = PRESETS["default"]
    assert preparation_of(default) == preparation_of(replace(default, code_bits=64, name="other"))
    for change in ({"preprocessing": None}, {"area": 2.0}, {"laplacian": "cotangent"}, {"eigenpairs": 50}):
        assert preparation_of(default) != preparation_of(replace(default, **change))

# SPDX-License-Identifier: MIT
"""Results on disk: complete or missing, found by keys of everything they depend on."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.errors import BenchmarkError
from benchmarks.protocol.cache import (
    PREPARATION_CODE,
    SEARCH_CODE,
    SIGNATURE_CODE,
    Arrays,
    BenchmarkCache,
    cached_shape,
    code_digest,
    content_digest,
    digest,
    preparation_of,
)
from shapegoogle_core.descriptors import heat_kernel_signature
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import PRESETS
from shapegoogle_core.model.working_shape import working_shape
from shapegoogle_core.spectral import Spectrum
from shapegoogle_core.words import soft_words, spatially_sensitive_bag


def no_result() -> Arrays:
    pytest.fail("the result is on disk")


def no_mesh() -> Mesh:
    pytest.fail("the result is on disk")


def test_results_come_back(cache: BenchmarkCache) -> None:
    arrays = {"values": np.arange(6.0).reshape(2, 3), "names": np.array(["a", "bc"])}
    assert cache.load("things", "00ff") is None
    assert cache.remembered("things", "00ff", lambda: arrays) is arrays
    for found in (cache.load("things", "00ff"), cache.remembered("things", "00ff", no_result)):
        assert found is not None
        assert set(found) == {"values", "names"}
        np.testing.assert_array_equal(found["values"], arrays["values"])
        np.testing.assert_array_equal(found["names"], arrays["names"])
    assert cache.load("things", "00fe") is None
    assert cache.load("others", "00ff") is None


def test_another_process_reads_the_results(cache: BenchmarkCache) -> None:
    cache.remembered("things", "00ff", lambda: {"values": np.ones(3)})
    copy = pickle.loads(pickle.dumps(cache))
    np.testing.assert_array_equal(copy.remembered("things", "00ff", no_result)["values"], np.ones(3))


@pytest.mark.parametrize("damage", ["cut short", "empty", "other"])
def test_damaged_results_are_computed_again(cache: BenchmarkCache, damage: str) -> None:
    cache.remembered("things", "00ff", lambda: {"values": np.arange(1000.0)})
    (path,) = cache.folder.rglob("output.pkl")
    whole = path.read_bytes()
    path.write_bytes({"cut short": whole[:-40], "empty": b"", "other": b"<html>"}[damage])
    assert cache.load("things", "00ff") is None
    made = cache.remembered("things", "00ff", lambda: {"values": np.ones(3)})
    np.testing.assert_array_equal(made["values"], np.ones(3))
    again = cache.remembered("things", "00ff", no_result)
    np.testing.assert_array_equal(again["values"], np.ones(3))


@pytest.mark.filterwarnings("ignore:Unable to cache to disk")
def test_a_result_that_cannot_be_written(cache: BenchmarkCache, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("joblib.numpy_pickle.dump", fail)
    with pytest.raises(BenchmarkError, match=r"cannot write into the cache .* --cache"):
        cache.remembered("things", "00ff", lambda: {"values": np.ones(3)})


def test_a_folder_that_cannot_be(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("no folder")
    with pytest.raises(BenchmarkError, match="cannot make the cache"):
        BenchmarkCache(tmp_path / "file" / "cache")


def test_a_digest_tells_all_apart() -> None:
    parts: list[list[object]] = [
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
    stages = [PREPARATION_CODE, SIGNATURE_CODE, SEARCH_CODE]
    assert len({code_digest(stage) for stage in stages}) == 3
    # A renamed file would otherwise no longer count.
    with pytest.raises(ValueError, match=r"'nothing\.py' is not in the repository"):
        code_digest(("nothing.py",))


def test_a_shape_is_the_same_from_the_cache(cache: BenchmarkCache, bumpy: Mesh) -> None:
    settings = replace(PRESETS["paper"], eigenpairs=40)
    first = cached_shape(cache, settings, "key", lambda: bumpy)
    again = cached_shape(cache, settings, "key", no_mesh)
    for name in ("eigenvalues", "eigenvectors", "mass"):
        np.testing.assert_array_equal(getattr(first.spectrum, name), getattr(again.spectrum, name))
    assert first.spectrum.eigenvectors.dtype == np.float64
    np.testing.assert_array_equal(first.mesh.vertices, again.mesh.vertices)
    np.testing.assert_array_equal(first.mesh.faces, again.mesh.faces)
    np.testing.assert_allclose(again.placement.apply(bumpy.vertices), again.mesh.vertices, atol=1e-9)


def test_single_precision_moves_no_bag(cache: BenchmarkCache, bumpy: Mesh) -> None:
    settings = replace(PRESETS["paper"], eigenpairs=100)
    (channel,) = settings.channels

    def pairs(spectrum: Spectrum) -> FloatArray:
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

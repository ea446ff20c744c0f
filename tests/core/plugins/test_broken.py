# SPDX-License-Identifier: MIT
"""Plug-ins that do not fit: one sentence that names the package, and nobody else is disturbed."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import shapegoogle_core as sg
from shapegoogle_core.descriptors import DESCRIPTORS
from shapegoogle_core.keypoints import DETECTORS
from shapegoogle_core.library.search.settings import CandidateSettings, RerankSettings
from shapegoogle_core.plugins import installed_plugins

Install = Callable[..., None]


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Install:
    """Write a package with one plug-in as pip would have unpacked it."""

    def write(package: str, group: str, name: str, code: str, target: str = "made") -> None:
        site, module = tmp_path / package, package.replace("-", "_")
        metadata = site / f"{module}-1.0.dist-info"
        metadata.mkdir(parents=True)
        (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.0\n", "utf-8")
        (metadata / "entry_points.txt").write_text(
            f"[shapegoogle.{group}]\n{name} = {module}:{target}\n", "utf-8"
        )
        (site / f"{module}.py").write_text(code, "utf-8")
        monkeypatch.syspath_prepend(str(site))
        sys.modules.pop(module, None)
        for registry in (DESCRIPTORS, DETECTORS):
            registry.plugins()

    return write


def problems() -> list[str]:
    return [plugin.problem for plugin in installed_plugins() if plugin.problem]


DESCRIPTOR = "def made(mesh, spectrum):\n    "


@pytest.mark.parametrize(
    ("group", "code", "reason"),
    [
        (
            "descriptors",
            "import none_such_module",
            "cannot be loaded, since there is no module 'none_such_module'",
        ),
        ("descriptors", "1 / 0", "cannot be loaded, since its code fails when it is imported"),
        ("descriptors", "raise SystemExit", "cannot be loaded, since its code fails when it is imported"),
        ("descriptors", "other = 1", "cannot be loaded, since there is no 'broken_shapes:made'"),
        ("descriptors", "made = 1", "must be a function of (mesh, spectrum, and parameters with names)"),
        ("descriptors", "def made(mesh): ...", "must be a function of (mesh, spectrum, and"),
        (
            "keypoint_detectors",
            "def made(mesh, spectrum, **all): ...",
            "must be a function of (mesh, spectrum, and",
        ),
        ("mesh_formats", "def made(path, folder): ...", "must be a function of (file)"),
        ("candidate_stages", "class made: ...", "must be a function of (store, model, settings)"),
        ("rerankers", "def made(*, settings): ...", "must be a function of (store, model, settings)"),
    ],
)
def test_the_list_says_what_is_wrong(install: Install, group: str, code: str, reason: str) -> None:
    install("broken-shapes", group, "mine", code)
    (problem,) = problems()
    assert reason in problem
    assert "of the package 'broken-shapes 1.0'" in problem
    assert sg.load_model().settings.channels[0].size > 1  # others work


def test_a_name_of_our_own_stays_ours(install: Install) -> None:
    own = DESCRIPTORS["hks"]
    install("loud-shapes", "descriptors", "hks", "1 / 0")
    assert DESCRIPTORS["hks"] is own
    (problem,) = problems()
    assert (
        "the package 'loud-shapes' has a descriptor 'hks', the name of one of Shape Google's own" in problem
    )
    assert list(DESCRIPTORS).count("hks") == 1


def test_a_name_of_two_packages_is_nobodys(install: Install) -> None:
    install("first-shapes", "descriptors", "curls", DESCRIPTOR + "return mesh.vertices")
    install("second-shapes", "descriptors", "curls", DESCRIPTOR + "return mesh.vertices")
    with pytest.raises(
        sg.PluginError, match="'curls' is in more than one package: first-shapes, second-shapes; keep"
    ):
        sg.ChannelSettings("curls", {})


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        (
            "return mesh.vertices[1:]",
            "must return (n, d) numbers, d for each of the 4 vertices of 'a tetrahedron'",
        ),
        ("return mesh.vertices + float('nan')", "must return finite numbers, also for 'a tetrahedron'"),
        (
            "return {}[mesh]",
            "'a tetrahedron': the descriptor 'curls' of the package 'curly-shapes 1.0' fails",
        ),
    ],
)
def test_results_of_a_descriptor_are_checked(install: Install, body: str, reason: str) -> None:
    install("curly-shapes", "descriptors", "curls", DESCRIPTOR + body)
    with pytest.raises(sg.ModelError) as caught:
        sg.ChannelSettings("curls", {})
    assert reason in str(caught.value)


def test_results_of_a_detector_are_checked(install: Install, bumpy: sg.Mesh) -> None:
    install("pointed-shapes", "keypoint_detectors", "tips", DESCRIPTOR + "return mesh.area")
    with pytest.raises(
        sg.PluginError, match=r"'pointed-shapes 1.0' must return a finite number for each of the"
    ):
        sg.detect_keypoints(bumpy, sg.compute_spectrum(bumpy, k=5), "tips")


def test_a_reader_that_returns_something_else_is_named(install: Install, tmp_path: Path) -> None:
    install("odd-format", "mesh_formats", "odd", "def made(file):\n    return file.data")
    (tmp_path / "a.odd").write_bytes(b"x")
    assert problems() == []
    with pytest.raises(
        sg.MeshError, match=r"'a.odd' cannot be read: the mesh format '.odd' of the package 'odd-for"
    ):
        sg.read_mesh(tmp_path / "a.odd")


STAGE = """
class made:
    def __init__(self, store, model, settings): ...
    def {method}(self, query, other, among=None):
        return {result}
"""


@pytest.mark.parametrize(
    ("group", "method", "result", "reason"),
    [
        ("candidate_stages", "find", "['a']", "must find a list of numbers of shapes"),
        ("candidate_stages", "find", "query.none_such", "fails"),
        ("candidate_stages", "search", "[]", "must make an object with a method 'find'"),
        ("rerankers", "distances", "[-1]", "must give each match a finite distance of at least 0"),
        ("rerankers", "distances", "None", "must give each match a finite distance of at least 0"),
    ],
)
def test_results_of_stages_are_checked(
    install: Install, tmp_path: Path, bumpy: sg.Mesh, group: str, method: str, result: str, reason: str
) -> None:
    install("staged-shapes", group, "mine", STAGE.format(method=method, result=result))
    assert problems() == []
    search = (
        sg.SearchSettings(rerank=RerankSettings(reranker="mine"))
        if group == "rerankers"
        else sg.SearchSettings(candidates=CandidateSettings(stages=("mine",)))
    )

    def use() -> None:
        with sg.Library.open(tmp_path / "a.sglib", "paper", search=search) as library:
            library.add(bumpy, name="bumpy")
            library.query(bumpy)

    with pytest.raises(sg.ShapeGoogleError) as caught:
        use()
    assert "of the package 'staged-shapes 1.0'" in str(caught.value)
    assert reason in str(caught.value)


def test_a_candidate_that_is_gone_or_filtered_out_is_no_match(
    install: Install, tmp_path: Path, bumpy: sg.Mesh
) -> None:
    install(
        "staged-shapes", "candidate_stages", "all", STAGE.format(method="find", result="[1, 2, 3, 99, 1]")
    )
    search = sg.SearchSettings(candidates=CandidateSettings(stages=("all",)))
    assert problems() == []
    with sg.Library.open(tmp_path / "a.sglib", "paper", search=search) as library:
        for number in range(3):
            library.add(sg.Mesh(bumpy.vertices * [1, 1, 1 + number], bumpy.faces), name=f"shape {number}")
        assert sorted(match.name for match in library.query(bumpy)) == ["shape 0", "shape 1", "shape 2"]
        assert [match.name for match in library.query(bumpy, where=sg.Filter(name="2"))] == ["shape 2"]
        assert np.isfinite([match.distance for match in library.query(bumpy)]).all()

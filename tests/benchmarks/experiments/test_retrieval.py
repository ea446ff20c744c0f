# SPDX-License-Identifier: MIT
"""`python -m benchmarks retrieval`: from folders to a report."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from benchmarks import command
from shapegoogle_core.model import ShapeModel

Capture = pytest.CaptureFixture[str]


def main(arguments: list[str]) -> int:
    return command.main(["retrieval", *arguments])


@pytest.fixture
def arguments(make_mesh: Callable[..., Path], tiny_model: ShapeModel, tmp_path: Path) -> list[str]:
    """Two null shapes, an unrelated one and four queries, of which one cannot be read."""
    tiny_model.save(tmp_path / "tiny.npz")
    for seed in (1, 2):
        make_mesh(tmp_path / "nulls" / f"null{seed}.off", seed)
        make_mesh(tmp_path / "queries" / f"null{seed}.isometry.1.off", seed)
    make_mesh(tmp_path / "queries" / "null1.isometry.2.off", 3)
    make_mesh(tmp_path / "negatives" / "other.off", 4)
    for place in ("round/a", "round/b", "long/a"):
        make_mesh(tmp_path / "labelled" / f"{place}.off", ord(place[-1]))
    folders = [f"--{name}={tmp_path / name}" for name in ("nulls", "negatives", "queries", "cache", "output")]
    return [*folders, "--no-generate", "--model", str(tmp_path / "tiny.npz"), "--jobs", "1"]


def test_a_report_is_written(arguments: list[str], tmp_path: Path, capsys: Capture) -> None:
    pytest.importorskip("matplotlib")
    pytest.importorskip("jinja2")
    (tmp_path / "queries" / "null2.isometry.2.off").write_text("OFF\n")
    labelled = ["--labelled", str(tmp_path / "labelled")]
    assert main([*arguments, *labelled]) == 1
    printed = capsys.readouterr()
    assert "isometry" in printed.out
    assert f"report: {tmp_path / 'output' / 'index.html'}" in printed.out
    assert "failed: null2.isometry.2: tiny: signatures: 'null2.isometry.2.off'" in printed.err
    result = json.loads((tmp_path / "output" / "benchmark.json").read_text(encoding="utf-8"))
    names = ["tiny · full bags", "tiny · 64-bit codes", "tiny · 64-bit codes, asymmetric", "tiny · search"]
    assert [variant["name"] for variant in result["variants"]] == names
    assert result["counts"] == {"database": 3, "nulls": 2, "negatives": 1, "queries": 4}
    assert [category["variant"] for category in result["categories"]] == names
    page = (tmp_path / "output" / "index.html").read_text(encoding="utf-8")
    assert "tiny · search" in page
    # Once more without the broken one: nothing is computed again, and the report compares.
    (tmp_path / "queries" / "null2.isometry.2.off").unlink()
    earlier = tmp_path / "output" / "benchmark.json"
    assert main([*arguments, f"--output={tmp_path / 'second'}", "--compare", str(earlier)]) == 0
    assert "signatures …" not in capsys.readouterr().err
    assert (tmp_path / "second" / "index.html").exists()


def test_what_can_be_known_before_measuring(arguments: list[str], tmp_path: Path, capsys: Capture) -> None:
    wrong = {
        "cannot be read": ["--compare", str(tmp_path / "nothing.json")],
        "no variant is called 'spin images'": ["--variants", "spin images"],
        "cannot read the model 'unheard-of'": ["--model", "unheard-of"],
        "cannot make the folder": ["--output", str(tmp_path / "nulls" / "null1.off" / "report")],
        "does not exist": ["--negatives", str(tmp_path / "nowhere")],
    }
    for message, options in wrong.items():
        assert main([*arguments, *options]) == 2
        printed = capsys.readouterr()
        assert message in printed.err
        assert "signatures" not in printed.err
    (tmp_path / "queries" / "stray.off").write_text("OFF\n")
    assert main(arguments) == 2
    assert "'stray.off' is not named <null>.<transformation>.<strength>.off" in capsys.readouterr().err


def test_queries_need_null_shapes(tmp_path: Path, capsys: Capture) -> None:
    pytest.importorskip("jinja2")
    assert main(["--data", str(tmp_path), "--queries", str(tmp_path)]) == 2
    assert "--queries needs --nulls" in capsys.readouterr().err
    assert main(["--data", str(tmp_path)]) == 2
    assert "has no labels.csv" in capsys.readouterr().err

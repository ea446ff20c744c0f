# SPDX-License-Identifier: MIT
"""`shapegoogle train`: a model from a folder."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from shapegoogle_core.cli import main
from shapegoogle_core.mesh import read_mesh
from shapegoogle_core.model import PRESETS, ShapeModel, load_model
from shapegoogle_core.model.settings import DESCRIPTORS

Capture = pytest.CaptureFixture[str]


@pytest.fixture
def small_preset(model: ShapeModel, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setitem(PRESETS, "small", model.settings)
    return "small"


@pytest.mark.filterwarnings("ignore:Number of distinct clusters")
def test_a_model_is_learnt(
    small_preset: str, make_mesh: Callable[..., Path], tmp_path: Path, capsys: Capture
) -> None:
    folder, output = tmp_path / "shapes", tmp_path / "mine.npz"
    for seed in range(9):
        # Two poses each, as far as this test is concerned: the same twice.
        make_mesh(folder / f"shape{seed}" / "one.off", seed)
        make_mesh(folder / f"shape{seed}" / "two.off", seed)
    (folder / "broken.off").write_text("OFF\n")
    arguments = [str(folder), "--output", str(output), "--preset", small_preset, "--versions", "2"]
    assert main(["train", *arguments, "--poses", "--jobs", "1"]) == 1
    printed = capsys.readouterr()
    model = load_model(output)
    assert model.settings == replace(PRESETS[small_preset], name="mine")
    assert printed.out.startswith(f"{output}: model {model.identifier}, ")
    assert printed.out.endswith("from 9 shapes\n")
    assert f"1 input failed:\n  {folder / 'broken.off'}: 'broken.off'" in printed.err
    assert "9 shapes" in model.trained_on


def test_too_few_shapes(small_preset: str, folder: Path, tmp_path: Path, capsys: Capture) -> None:
    arguments = ["train", str(folder), "--preset", small_preset, "--output", str(tmp_path / "mine.npz")]
    assert main(arguments) == 2
    assert "at least 8 different usable shapes" in capsys.readouterr().err
    assert not (tmp_path / "mine.npz").exists()


def test_what_can_be_known_before_training(folder: Path, tmp_path: Path, capsys: Capture) -> None:
    arguments = ["train", str(folder), "--output", str(tmp_path / "mine.npz"), "--preset", "unheard-of"]
    assert main(arguments) == 2
    assert "no preset 'unheard-of'" in capsys.readouterr().err
    for output in (tmp_path, tmp_path / "no" / "folder.npz"):
        assert main(["train", str(folder), "--preset", "paper", "--output", str(output)]) == 2
        printed = capsys.readouterr()
        assert str(output) in printed.err
        # Before anything was read.
        assert "reading" not in printed.err


@pytest.mark.filterwarnings("ignore:Number of distinct clusters")
def test_descriptors_are_chosen_by_name(
    small_preset: str, make_mesh: Callable[..., Path], tmp_path: Path
) -> None:
    folder, output = tmp_path / "shapes", tmp_path / "mine.npz"
    for seed in range(8):
        make_mesh(folder / f"shape{seed}.off", seed)
    names = ["spin-images", "gps"]
    chosen = [word for name in names for word in ("--descriptor", name)]
    arguments = [str(folder), "--output", str(output), "--preset", small_preset, "--versions", "1", *chosen]
    assert main(["train", *arguments, "--jobs", "1"]) == 0
    model = load_model(output)
    assert [channel.descriptor for channel in model.settings.channels] == names
    assert model.describe(read_mesh(folder / "shape0.off")).bags.shape == (model.settings.bag_size,)


def test_an_unknown_descriptor_is_told(folder: Path, tmp_path: Path, capsys: Capture) -> None:
    output = str(tmp_path / "mine.npz")
    assert main(["train", str(folder), "--output", output, "--descriptor", "colour"]) == 2
    assert "descriptor must be one of hks, " in capsys.readouterr().err


def test_descriptors_have_their_names_in_the_help(capsys: Capture) -> None:
    with pytest.raises(SystemExit):
        main(["train", "--help"])
    words = capsys.readouterr().out.replace(",", " ").split()
    # The wave kernel signature has no parameters that suit every operator and area.
    assert set(DESCRIPTORS) - set(words) == {"wks"}

# SPDX-License-Identifier: MIT
"""The parts of the extension's build that need no network; `tests/extension` looks at what it builds."""

from __future__ import annotations

import os
import tomllib
import zipfile
from pathlib import Path

import build_extension
import pytest
from lib import wheels

import shapegoogle_core as sg


def test_the_manifest_gets_its_wheels_and_platform() -> None:
    text = (build_extension.ADDON / build_extension.MANIFEST).read_text(encoding="utf-8")
    source = tomllib.loads(text)
    names = ["a-1-py3-none-any.whl", "b-2-cp311-cp311-win_amd64.whl"]
    built = tomllib.loads(build_extension.complete_manifest(text, "1.2.3", "windows-x64", names))
    assert built.pop("version") == "1.2.3"
    assert built.pop("platforms") == ["windows-x64"]
    assert built.pop("wheels") == [f"./wheels/{name}" for name in names]
    assert built == source, "everything else is as in the repository"


def test_a_zip_depends_only_on_what_is_in_it(tmp_path: Path) -> None:
    contents = {"b.py": b"b = 1\n" * 50, "a.whl": os.urandom(100)}
    results = []
    for number, names in enumerate((list(contents), sorted(contents))):
        packed = tmp_path / f"packed-{number}.zip"
        with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as file:
            for name in names:
                info = zipfile.ZipInfo(name, (2020 + number, 5, 5, 5, 5, 5))
                info.external_attr = (0o600 + number) << 16
                file.writestr(info, contents[name], zipfile.ZIP_STORED if "whl" in name else None)
        path = tmp_path / f"{number}.zip"
        build_extension.make_reproducible(packed, path)
        results.append(path.read_bytes())
        with zipfile.ZipFile(path) as file:
            assert {name: file.read(name) for name in file.namelist()} == contents
            assert file.getinfo("a.whl").compress_type == zipfile.ZIP_STORED
    assert results[0] == results[1]


def test_the_hash_of_a_folder_sees_names_and_contents(tmp_path: Path) -> None:
    (tmp_path / "inner").mkdir()
    (tmp_path / "inner" / "file").write_text("1")
    first = build_extension.digest(tmp_path)
    (tmp_path / "inner" / "file").write_text("2")
    second = build_extension.digest(tmp_path)
    (tmp_path / "inner" / "file").rename(tmp_path / "file")
    assert len({first, second, build_extension.digest(tmp_path)}) == 3


def test_platforms_and_pythons_are_chosen_on_the_command_line(capsys: pytest.CaptureFixture[str]) -> None:
    def chosen(*arguments: str) -> list[tuple[str, str]]:
        return build_extension.parse_arguments(arguments)[0]

    here = wheels.this_platform()
    assert chosen() == [(here, "3.11"), (here, "3.13")]
    assert chosen("--python", "3.13") == [(here, "3.13")]
    assert chosen("--platform", "macos-arm64", "--python", "3.11") == [("macos-arm64", "3.11")]
    assert [platform for platform, _ in chosen("--all")][::2] == ["linux-x64", "windows-x64", "macos-arm64"]
    assert build_extension.parse_arguments(["--all", "--repository"])[1]
    for wrong in (["--platform", "amiga"], ["--python", "2.7"]):
        with pytest.raises(SystemExit):
            chosen(*wrong)
        assert f"invalid choice: '{wrong[1]}'" in capsys.readouterr().err


def test_a_zip_is_named_after_its_platform_and_python() -> None:
    path = build_extension.zip_path("linux-x64", "3.11")
    assert path.parent.name == "dist"
    assert path.name == f"shape_google-{sg.__version__}-linux_x64-cp311.zip"
    assert (
        tomllib.loads((build_extension.ADDON / build_extension.MANIFEST).read_text("utf-8"))["id"]
        == "shape_google"
    )

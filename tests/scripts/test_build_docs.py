# SPDX-License-Identifier: MIT
"""The documentation site: the check of its links, the order of examples, and pages written from the code."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import build_docs
import pytest
from lib import bootstrap

import shapegoogle_core as sg

DOCS = bootstrap.ROOT / "docs"


def test_links_that_lead_nowhere_are_found(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "index.html").write_text(
        '<h1 id="top">x</h1><a href="#top">1</a><a href="#gone">2</a><a href="a/b.html#there">3</a>'
        '<a href="a/b.html#not">4</a><a href="https://elsewhere.example/x">5</a><img src="missing%20one.png">'
    )
    (tmp_path / "a" / "b.html").write_text(
        '<p id="there"><a href="../index.html">up</a><a href="../c/">7</a></p>'
    )
    assert build_docs.broken_links(tmp_path) == [
        "a/b.html: ../c/",
        "index.html: #gone",
        "index.html: a/b.html#not",
        "index.html: missing%20one.png",
    ]


def test_a_fault_in_the_pages_ends_the_build_with_exit_code_1(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("sphinx")
    docs = tmp_path / "docs"
    docs.mkdir()
    (docs / "conf.py").write_text("")
    (docs / "index.rst").write_text("Title\n=====\n\n:doc:`nowhere`\n")
    monkeypatch.setattr(bootstrap, "enter", lambda extras: None)
    monkeypatch.setattr(bootstrap, "ROOT", tmp_path)
    monkeypatch.setattr(build_docs, "DOCS", docs)
    monkeypatch.setattr(build_docs, "BUILD", docs / "_build")
    monkeypatch.setattr(build_docs, "PAGES", docs / "_build" / "html")
    monkeypatch.setattr(build_docs, "GENERATED", ())
    assert build_docs.main([]) == 1
    assert "The documentation has faults" in capsys.readouterr().err
    (docs / "index.rst").write_text("Title\n=====\n\nText.\n")
    assert build_docs.main([]) == 0
    assert capsys.readouterr().out.startswith("docs/_build/html/index.html: ")


def test_every_example_has_its_place_in_the_gallery(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(DOCS / "_extensions"))
    order = importlib.import_module("gallery_order")
    assert {path.stem for path in (DOCS / "examples").glob("*.py")} == set(order.ORDER)
    by_place = order.ExampleOrder("")
    assert by_place("five_lines.py") < by_place("training.py") < by_place("new.py")
    sys.modules.pop("gallery_order")


def test_the_reference_has_every_public_name_and_command(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("sphinx")
    pytest.importorskip("fastapi")
    monkeypatch.syspath_prepend(str(DOCS / "_extensions"))
    reference = importlib.import_module("generated_reference")
    pages = "".join(text for _, text in reference.api_pages())
    for name in sg.__all__:
        kind = "class" if isinstance(getattr(sg, name), type) else "function"
        assert f".. auto{kind}:: {name}\n" in pages
    commands = reference.commands_page()
    assert ".. program:: shapegoogle query\n" in commands
    assert ".. option:: --top N\n" in commands
    assert "number of matches (10)" in commands
    addresses = importlib.import_module("http_reference").addresses_page()
    assert "POST /api/queries\n" in addresses
    assert "Takes ``application/json``: `QueryRequest`_." in addresses
    assert "``rank`` : ``both``, ``shape``, ``kind``, default ``both``" in addresses
    assert "````" not in addresses, "an empty text is no code"
    for name in ("generated_reference", "http_reference"):
        sys.modules.pop(name)

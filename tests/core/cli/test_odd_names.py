# SPDX-License-Identifier: MIT
"""Names of files and objects that break lines, hide text or act upon a terminal."""

from __future__ import annotations

import json
import os
import shutil
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from shapegoogle_core.api.text import display_width, one_line, shortened, visible
from shapegoogle_core.cli import main
from shapegoogle_core.cli.text import table
from shapegoogle_core.library.library import Library

ODD = [
    "two\nlines.off",
    "tab\tand\rreturn.off",
    "red\x1b[31m\x1b]0;title\x07.off",
    "right\u202eto left\u2066.off",
    "line\u2028and\u2029paragraph\x85.off",
    "}{'\"\\n.off",
    "馬 и cafe\u0301 👩\u200d🚀.off",
    "l" * 240 + ".off",
]
if sys.platform == "linux":
    ODD.append(os.fsdecode(b"bytes\xff\xfe.off"))
HARMFUL = "\r\t\x1b\x07\u202e\u2066\u2028\u2029\x85\udcff"


def run(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    capsys.readouterr()
    code = main([str(argument) for argument in arguments])
    printed = capsys.readouterr()
    for text in (printed.out, printed.err):
        assert not set(text) & set(HARMFUL)
        text.encode()
    return code, printed.out, printed.err


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such names")
def test_every_command(
    indexed: Library, library_file: Path, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    odd = tmp_path / "odd"
    odd.mkdir()
    for name in ODD:
        shutil.copy(folder / "apple.off", odd / name)
    broken = odd / "bro\nken.off"
    broken.write_text("OFF\n")
    library = ("--library", library_file)

    code, out, err = run(capsys, "index", odd, *library, "--jobs", "1", "--retry")
    assert code == 1
    assert len(out.splitlines()) == 1
    assert [line for line in err.splitlines() if "bro\\nken.off" in line] == [
        line for line in err.splitlines() if line.startswith(("skipped ", "  /"))
    ]
    code, out, _ = run(capsys, "index", odd, *library, "--jobs", "1", "--json")
    assert json.loads(out)["failed"][0]["source"] == str(broken)

    code, out, _ = run(capsys, "query", odd / ODD[0], *library, "--evidence", "0", "--top", "50")
    assert code == 0
    title, head, *rows = out.partition("\n\n")[0].splitlines()
    assert title == f"{odd}/two\\nlines.off: the best {len(ODD) + 3} of {len(ODD) + 3} shapes"
    assert len(rows) == len(ODD) + 3
    # The columns begin at the same place on a terminal.
    starts = {display_width(row[: row.rindex(str(folder.parent))]) for row in rows}
    assert starts == {head.index("source")}
    _, out, _ = run(capsys, "query", odd / ODD[0], *library, "--evidence", "0", "--top", "50", "--json")
    record = json.loads(out)
    assert record["query"] == str(odd / ODD[0])
    assert {match["source"] for match in record["matches"]} > {str(odd / name) for name in ODD}

    _, out, _ = run(capsys, "duplicates", *library, "--evidence", "0")
    assert len(out.partition("\n\n")[0].splitlines()) == 1 + len(ODD) + 1
    _, out, _ = run(capsys, "duplicates", *library, "--evidence", "0", "--json")
    first = json.loads(out.splitlines()[0])
    assert {member["source"] for member in first["members"]} > {str(odd / name) for name in ODD}

    _, out, _ = run(capsys, "info", *library)
    assert out.splitlines()[-1].startswith(f"  {odd}/bro\\nken.off: ")
    _, out, _ = run(capsys, "info", *library, "--json")
    assert list(json.loads(out)["failures"]) == [str(broken)]

    assert run(capsys, "query", "no\nmesh.obj", *library)[0] == 1
    assert run(capsys, "info", "--library", tmp_path / "no\nlibrary", "-v")[0] == 2
    with pytest.raises(SystemExit):
        run(capsys, "query", "mesh.obj", *library, "--si\x1bze", "1")


def test_arguments_in_errors_of_the_command_line(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["info", "--library", "x", "an\x1b[31m\nother"])
    assert "an\\x1b[31m\\nother" in capsys.readouterr().err


def test_tables() -> None:
    rows = [("name", "count", "source"), ("馬\n", "1", "a\tb"), ("e\u0301" * 3, "12", "c" * 100)]
    assert table(rows, "<><") == [
        "name  count  source",
        "馬\\n      1  a\\tb",
        f"{rows[2][0]}      12  {rows[2][2]}",
    ]
    (line,) = table([("x" * 100, "y")], "<<")
    assert display_width(line) == 63
    assert "…" in line


def test_lines_of_a_text_stay() -> None:
    assert visible("one\ntwo\x1b\n") == "one\ntwo\\x1b\n"


@given(st.text(), st.integers(4, 30))
def test_any_text(text: str, columns: int) -> None:
    shown = one_line(text)
    assert len(shown.splitlines()) <= 1
    assert not set(shown) & set(HARMFUL)
    shown.encode()
    assert one_line(shown) == shown
    assert display_width(shortened(shown, columns)) <= columns

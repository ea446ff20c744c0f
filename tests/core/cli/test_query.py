# SPDX-License-Identifier: MIT
"""`shapegoogle query`: a table or JSON, filters, several examples."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from shapegoogle_core.library.library import Library
from tests.core.cli.running import Command, StartShapegoogle


def test_query_as_json(
    run: Command, indexed: Library, library_file: Path, folder: Path, tmp_path: Path
) -> None:
    queries = [folder / "pear.obj", tmp_path / "gone.obj", folder / "more" / "plum.stl"]
    code, stdout, stderr = run("query", *queries, "--library", library_file, "--json")
    assert code == 1
    records = [json.loads(line) for line in stdout.splitlines()]
    assert [record["query"] for record in records] == list(map(str, queries))
    for record in (records[0], records[2]):
        assert set(record) == {"query", "matches"}
        best = record["matches"][0]
        named = {"name", "source", "object_name"}
        assert set(best) == {
            *named,
            "similarity",
            "likeness",
            "distance",
            "evidence",
            "placements",
            "shape_type",
        }
        assert (best["source"], best["similarity"], best["distance"]) == (record["query"], 1.0, 0.0)
        assert best["name"] == Path(record["query"]).name
        distances = [match["distance"] for match in record["matches"]]
        # Fewer shapes than the ten asked for: all of them, best first.
        assert distances == sorted(distances)
        assert len(distances) == 3
    assert records[1]["matches"] == []
    assert records[1]["error"].startswith(f"'{queries[1]}' does not exist")
    assert stderr.startswith("1 input failed:\n  ")
    assert str(queries[1]) in stderr


def test_query_as_a_table(run: Command, indexed: Library, library_file: Path, folder: Path) -> None:
    query = folder / "pear.obj"
    code, stdout, stderr = run("query", query, "--library", library_file, "--top", "2", "--exact")
    assert (code, stderr) == (0, "")
    title, head, first, second, blank, *legend = stdout.splitlines()
    assert title == f"{query}: the best 2 of 3 shapes"
    assert head.split() == ["similarity", "likeness", "distance", "evidence", "name", "source"]
    assert first.split() == ["1", "1.000", "0.0000", "pear.obj", str(query)]
    assert second.split()[0] == "2"
    # Columns stand under their heads, and no path is cut off.
    assert first.index("pear.obj") == head.index("name")
    assert first.index(str(query)) == second.index(str(folder)) == head.index("source")
    assert blank == ""
    assert [line.split(":")[0] for line in legend] == ["similarity", "likeness", "distance", "evidence"]


def test_versions_of_a_match_are_listed_after_it(
    run: Command, indexed: Library, library_file: Path, folder: Path
) -> None:
    query = folder / "pear.obj"
    (pear,) = [shape for shape in indexed.shapes() if shape.name == "pear.obj"]
    indexed.add_signature(indexed.signature(pear.shape_id), "copy of the pear")
    code, stdout, _ = run("query", query, "--library", library_file, "--versions")
    assert code == 0
    # The bags of the tiny model make one family of all.
    title, _, first, version, *_ = stdout.splitlines()
    assert "the best 1 of 4 shapes" in title
    assert " and 3 versions" in first
    assert version.split()[:2] == ["1.1", "1.000"]
    assert ("copy of the pear" in first) != ("copy of the pear" in version)
    _, stdout, _ = run("query", query, "--library", library_file, "--versions", "--json")
    (match,) = json.loads(stdout)["matches"]
    names = [match["name"], *(version["name"] for version in match["version_matches"])]
    assert sorted(names[:2]) == ["copy of the pear", "pear.obj"]
    assert sorted(names[2:]) == ["apple.off", "plum.stl"]


@pytest.mark.parametrize(
    ("filters", "expected"),
    [
        (["--name", "PLUM"], ["plum.stl"]),
        (["--folder", "{folder}/more"], ["plum.stl"]),
        (["--faces", "1:"], ["apple.off", "pear.obj", "plum.stl"]),
        (["--file-type", "STL"], ["plum.stl"]),
        (["--faces", ":1"], []),
        (["--size", "1e6:"], []),
        (["--tag", "wood"], []),
        (["--min-similarity", "1"], ["pear.obj"]),
    ],
)
def test_query_with_filters(
    run: Command, indexed: Library, library_file: Path, folder: Path, filters: list[str], expected: list[str]
) -> None:
    options = [option.format(folder=folder) for option in filters]
    code, stdout, stderr = run("query", folder / "pear.obj", "--library", library_file, "--json", *options)
    assert (code, stderr) == (0, "")
    matches = json.loads(stdout)["matches"]
    assert sorted(match["name"] for match in matches) == sorted(expected)
    if not expected:
        _, stdout, _ = run("query", folder / "pear.obj", "--library", library_file, *options)
        assert "pear.obj: none of 3 shapes meets the filters" in stdout


def test_a_kind_cannot_be_found_without_samples(
    run: Command, indexed: Library, library_file: Path, folder: Path
) -> None:
    code, _, stderr = run("query", folder / "pear.obj", "--library", library_file, "--kind", "moved")
    assert code != 0
    assert "keeps no samples of surfaces to find the kind 'moved' with" in stderr


def test_meshes_together_are_one_query(
    run: Command, indexed: Library, library_file: Path, folder: Path
) -> None:
    meshes = [folder / "pear.obj", folder / "apple.off"]
    unlike = folder / "more" / "plum.stl"
    code, stdout, stderr = run(
        "query", *meshes, "--together", "--unlike", unlike, "--library", library_file, "--json"
    )
    assert (code, stderr) == (0, "")
    record = json.loads(stdout)
    assert list(record) == ["query", "unlike", "matches"]
    assert (record["query"], record["unlike"]) == (list(map(str, meshes)), [str(unlike)])
    assert [match["name"] for match in record["matches"]] == ["apple.off", "pear.obj", "plum.stl"]
    assert record["matches"][-1]["distance"] == 2
    code, stdout, _ = run("query", *meshes, "--together", "--library", library_file, "--json")
    record = json.loads(stdout)
    assert (record["unlike"], len(record["matches"])) == ([], 3)
    _, stdout, _ = run("query", *meshes, "--together", "--unlike", unlike, "--library", library_file)
    title = stdout.splitlines()[0]
    assert title == f"{meshes[0]} and {meshes[1]}, not like {unlike}: the best 3 of 3 shapes"
    assert stdout.splitlines()[-1].startswith("evidence:")


def test_what_is_not_looked_for_goes_with_every_query(
    run: Command, indexed: Library, library_file: Path, folder: Path
) -> None:
    meshes = [folder / "pear.obj", folder / "apple.off"]
    unlike = folder / "more" / "plum.stl"
    _, stdout, _ = run("query", *meshes, "--library", library_file, "--json", "--unlike", unlike)
    records = [json.loads(line) for line in stdout.splitlines()]
    assert [record["query"] for record in records] == list(map(str, meshes))
    for record in records:
        assert list(record) == ["query", "unlike", "matches"]
        assert record["matches"][0]["source"] == record["query"]
        assert record["matches"][-1]["source"] == str(unlike)


def test_examples_that_cannot_be_read(
    run: Command, indexed: Library, library_file: Path, folder: Path
) -> None:
    """Without one of its examples it would be another question; each is named."""
    pear, gone, broken = folder / "pear.obj", folder / "gone.obj", folder / "broken.off"
    broken.write_text("OFF\n")
    options = ("--library", library_file, "--json")
    code, stdout, stderr = run("query", pear, gone, "--together", "--unlike", broken, *options)
    record = json.loads(stdout)
    assert (code, record["matches"]) == (1, [])
    assert record["query"] == [str(pear), str(gone)]
    assert "gone.obj' does not exist" in record["error"]
    assert "'broken.off'" in record["error"]
    assert stderr.startswith("2 inputs failed:\n")
    code, stdout, stderr = run("query", pear, pear, "--unlike", gone, *options)
    records = [json.loads(line) for line in stdout.splitlines()]
    assert (code, len(records)) == (1, 2)
    assert all("gone.obj' does not exist" in record["error"] for record in records)
    assert stderr.startswith("1 input failed:\n")
    code, stdout, _ = run("query", pear, "--unlike", gone, "--library", library_file)
    assert (code, stdout) == (1, "")


def test_query_of_an_empty_library(run: Command, library: Library, library_file: Path, folder: Path) -> None:
    code, stdout, _ = run("query", folder / "pear.obj", "--library", library_file, "--json")
    assert (code, json.loads(stdout)["matches"]) == (0, [])
    code, stdout, _ = run("query", folder / "pear.obj", "--library", library_file)
    assert code == 0
    assert "the library is empty" in stdout


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such pipes")
def test_a_reader_that_stops_reading(
    start_shapegoogle: StartShapegoogle, indexed: Library, library_file: Path, folder: Path
) -> None:
    """`shapegoogle query … | head -1`."""
    process = start_shapegoogle("query", *[folder / "pear.obj"] * 200, "--library", library_file, "--json")
    assert process.stdout is not None
    assert process.stderr is not None
    assert json.loads(process.stdout.readline())["query"] == str(folder / "pear.obj")
    process.stdout.close()
    assert process.stderr.read() == ""
    assert process.wait() == 141

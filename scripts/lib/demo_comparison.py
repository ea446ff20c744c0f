# SPDX-License-Identifier: MIT
"""The same queries to a file, a database and a service, and whether the answers are the same."""

from __future__ import annotations

import json
import urllib.error
import urllib.request
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lib.demo_creatures import FOLDER, INDIVIDUAL, KINDS, POSES_EACH, write_mesh

__all__ = [
    "Answer",
    "Answers",
    "answers_of_library",
    "answers_of_service",
    "first_difference",
    "query_files",
]

TOP = 10
DECIMALS = 6  # of similarity and likeness in the answers of the service
SCALE = 1.7
_SECONDS = 120


@dataclass(frozen=True)
class Answer:
    """A match, as every part has to return it."""

    name: str
    distance: float
    similarity: float
    likeness: float | None
    evidence: str | None

    @property
    def text(self) -> str:
        """The match as a message shows it."""
        return f"{self.name} ({self.evidence}, distance {self.distance:g}, similarity {self.similarity:g})"


Answers = dict[str, list[Answer]]


def query_files() -> list[Path]:
    """Write a query for each kind of creature: in a pose that the library lacks, and larger."""
    from benchmarks.creatures import make_creature
    from shapegoogle_core import Mesh

    paths = []
    for kind in KINDS:
        creature = make_creature(kind, INDIVIDUAL)
        pose = creature.pose_names[POSES_EACH]
        mesh = creature.pose(pose)
        path = FOLDER / "queries" / f"{kind}-{pose}.ply".replace(" ", "_")
        write_mesh(path, Mesh(SCALE * mesh.vertices, mesh.faces, path.name))
        paths.append(path)
    return paths


def answers_of_library(place: str | Path, queries: Sequence[Path]) -> Answers:
    """Ask a library, a file or a database, in this process."""
    from shapegoogle_core import Library, read_mesh

    with Library.open(place, read_only=True) as library:
        return {
            path.name: [
                Answer(
                    match.name,
                    match.distance,
                    round(match.similarity, DECIMALS),
                    None if match.likeness is None else round(match.likeness, DECIMALS),
                    None if match.evidence is None else match.evidence.kind,
                )
                for match in library.query(read_mesh(path), top=TOP, explain=TOP)
            ]
            for path in queries
        }


def answers_of_service(address: str, queries: Sequence[Path]) -> Answers:
    """Ask a service as its page does: upload the file, and search with it."""
    answers = {}
    for path in queries:
        upload = _post(f"{address}api/uploads", *_form(path))
        example = {"upload": upload["upload"], "index": 0}
        query = json.dumps({"like": [example], "limit": TOP, "evidence": TOP}).encode()
        page = _post(f"{address}api/queries", query, "application/json")
        answers[path.name] = [
            Answer(
                match["name"],
                match["distance"],
                match["similarity"],
                match["likeness"],
                None if match["evidence"] is None else match["evidence"]["kind"],
            )
            for match in page["matches"]
        ]
    return answers


def first_difference(expected: Answers, found: Answers) -> str | None:
    """Describe the first difference of two sets of answers, None if there is none.

    Parameters
    ----------
    expected, found : dict of str to list of Answer
        By query.

    Returns
    -------
    difference : str or None
    """
    for query, matches in expected.items():
        others = found[query]
        if len(matches) != len(others):
            return f"{len(others)} instead of {len(matches)} matches of {query}"
        for rank, (match, other) in enumerate(zip(matches, others, strict=True), start=1):
            if match != other:
                return f"match {rank} of {query} is {other.text} instead of {match.text}"
    return None


def _form(path: Path) -> tuple[bytes, str]:
    """Make a form with a file, as browsers send it."""
    boundary = "shapegoogle-demo-4f1c1d0b"
    head = (
        f'--{boundary}\r\nContent-Disposition: form-data; name="file"; filename="{path.name}"\r\n'
        "Content-Type: application/octet-stream\r\n\r\n"
    )
    return (
        head.encode() + path.read_bytes() + f"\r\n--{boundary}--\r\n".encode(),
        f"multipart/form-data; boundary={boundary}",
    )


def _post(address: str, content: bytes, content_type: str) -> Any:
    from shapegoogle_core import ShapeGoogleError

    request = urllib.request.Request(address, content, {"Content-Type": content_type})
    try:
        with urllib.request.urlopen(request, timeout=_SECONDS) as answer:
            return json.load(answer)
    except urllib.error.HTTPError as error:
        raise ShapeGoogleError(f"the service refuses {address}: {error.read().decode()}") from error
    except OSError as error:
        raise ShapeGoogleError(f"the service does not answer at {address}") from error

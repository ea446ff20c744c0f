# SPDX-License-Identifier: MIT
"""How often evidence and duplicates are right on flat-sided parts: ``python -m benchmarks evidence --parts``.

Prints the confusion matrix of all pairs of `benchmarks.flat_parts`, and the false claims of the search for
duplicates in a library of all parts and their versions.
"""

from __future__ import annotations

import tempfile
import time
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.flat_parts import FAMILIES, make_part_pairs, make_parts, versions
from benchmarks.parallel import map_in_processes
from shapegoogle_core import Library, ShapeSignature, load_model
from shapegoogle_core.library.evidence import KINDS
from shapegoogle_core.library.search.evidence.kinds import Compared, Explainer
from shapegoogle_core.registration import SurfaceSample

__all__ = ["SAME_SURFACE", "print_parts"]

SAME_SURFACE = ("identical", "moved", "scaled", "mirrored", "re-meshed")
"""Kinds that say that two surfaces are the same."""

# Kinds of groups of duplicates that say the same.
_CLAIMS = (*SAME_SURFACE, "copies")


class _Outcome(NamedTuple):
    """Evidence of a pair: the truth, the kind that was reported, similarity, and processor seconds."""

    kind: str
    detail: str
    said: str
    similarity: float
    seconds: float


def print_parts(jobs: int) -> None:
    """Measure evidence and duplicates on flat-sided parts, and print the tables.

    Parameters
    ----------
    jobs : int
        Number of worker processes.
    """
    families = list(FAMILIES)
    outcomes = [
        outcome for found in map_in_processes(_explain, families, jobs, "families") for outcome in found
    ]
    _print_confusion(outcomes)
    shapes = [shape for found in map_in_processes(_describe, families, jobs, "families") for shape in found]
    _print_duplicates(shapes)


def _explain(family: str) -> list[_Outcome]:
    model = replace(load_model(), views=None)  # no evidence rests on pictures
    outcomes = []
    signatures: dict[int, ShapeSignature] = {}
    pairs = make_part_pairs(family)
    for pair in pairs:
        for mesh in (pair.query, pair.candidate):
            if id(mesh) not in signatures:
                signatures[id(mesh)] = model.describe(mesh, keep_surface=True)
        query, found = signatures[id(pair.query)], signatures[id(pair.candidate)]
        assert query.sample is not None
        assert found.sample is not None
        distances = model.distances(query.bags, found.bags[None])
        distance, similarity = float(distances[0]), float(model.similarity(distances)[0])
        stored = Compared(SurfaceSample.from_bytes(found.sample.to_bytes()), found, found.measures)
        started = time.process_time()
        said = Explainer(Compared(query.sample, query, query.measures), query.surface).explain(
            stored, distance
        )
        seconds = time.process_time() - started
        outcomes.append(_Outcome(pair.kind, pair.detail, said.kind, similarity, seconds))
    return outcomes


def _print_confusion(outcomes: Sequence[_Outcome]) -> None:
    counts = Counter((outcome.kind, outcome.said) for outcome in outcomes)
    print(f"{len(outcomes)} pairs; rows: the truth, columns: the evidence\n")
    print("| | " + " | ".join(KINDS) + " |")
    print("|---|" + "---|" * len(KINDS))
    for kind in (*SAME_SURFACE, "different"):
        print(f"| {kind} | " + " | ".join(str(counts[kind, column] or "") for column in KINDS) + " |")
    claims = [outcome for outcome in outcomes if outcome.said in SAME_SURFACE]
    false = [outcome for outcome in claims if outcome.kind == "different"]
    same = [outcome for outcome in outcomes if outcome.kind != "different"]
    right = sum(outcome.kind == outcome.said for outcome in same)
    print(f"\nsame surfaces with the right kind: {100 * right / len(same):.1f} %")
    precision = 100 * (1 - len(false) / max(1, len(claims)))
    print(f"precision of the kinds of same surfaces: {precision:.1f} % of {len(claims)}")
    different = [outcome for outcome in outcomes if outcome.kind == "different"]
    posed = sum(outcome.said == "re-posed" for outcome in different)
    print(f"different parts called re-posed: {posed} of {len(different)}")
    for outcome in false:
        print(f"  {outcome.detail}: {outcome.said}")
    details: defaultdict[tuple[str, str], list[str]] = defaultdict(list)
    for outcome in same:
        details[outcome.kind, outcome.detail].append(outcome.said)
    for (kind, detail), said in details.items():
        others = Counter(one for one in said if one != kind)
        print(f"  {kind}: {detail}: {len(said) - others.total()} of {len(said)} {dict(others) or ''}")
    bags = np.array([outcome.similarity for outcome in same])
    print(f"similarity of same surfaces by bags: median {np.median(bags):.4f}, least {bags.min():.4f}")
    seconds = np.quantile([outcome.seconds for outcome in outcomes], [0.5, 0.95])
    print(f"processor seconds for a pair: median {seconds[0]:.3f}, 95 % below {seconds[1]:.3f}")


def _describe(family: str) -> list[tuple[str, ShapeSignature]]:
    """Describe the parts of a family and their versions; the names say which part each of them is."""
    model = replace(load_model(), views=None)
    random = np.random.default_rng([1, *family.encode()])
    described = []
    for part in make_parts([family]):
        name = f"{part.family}: {part.name}"
        described.append((name, model.describe(part.mesh)))
        for version in versions(part, random):
            described.append((f"{name}|{version.kind}|{version.detail}", model.describe(version.mesh)))
    return described


def _print_duplicates(shapes: Sequence[tuple[str, ShapeSignature]]) -> None:
    with tempfile.TemporaryDirectory() as folder, Library.open(Path(folder) / "parts.sglib") as library:
        for name, signature in shapes:
            library.add_signature(signature, name)
        started = time.process_time()
        groups = library.duplicates()
        seconds = time.process_time() - started
    kinds: Counter[str] = Counter()
    false: Counter[str] = Counter()
    examples: list[str] = []
    for group in groups:
        first = group.members[0].name.partition("|")[0]
        for member in group.members[1:]:
            kinds[group.kind] += 1
            if member.name.partition("|")[0] != first:
                false[group.kind] += 1
                if group.kind in _CLAIMS:
                    examples.append(f"{first} / {member.name}: {group.kind}")
    parts = len({name.partition("|")[0] for name, _ in shapes})
    print(f"\nduplicates among {len(shapes)} shapes of {parts} parts; {seconds:.1f} s of processor time\n")
    print("| kind | members | of another part |\n|---|---|---|")
    for kind, count in sorted(kinds.items()):
        print(f"| {kind} | {count} | {false[kind]} |")
    claimed = sum(kinds[kind] for kind in _CLAIMS)
    wrong = sum(false[kind] for kind in _CLAIMS)
    print(f"\nfalse claims: {wrong} of {claimed} ({100 * wrong / max(1, claimed):.1f} %); ", end="")
    print(f"copies to be found: {len(shapes) - parts}")
    for example in examples[:40]:
        print(f"  {example}")

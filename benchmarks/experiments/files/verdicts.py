# SPDX-License-Identifier: MIT
"""Comparing what several readers made of a file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from benchmarks.experiments.files.facts import Facts, differences
from benchmarks.experiments.files.reading import PRODUCT, Reading

__all__ = ["VERDICTS", "Verdict", "judge"]

VERDICTS = (
    "agrees",
    "agrees with some",
    "differs",
    "only the product reads",
    "only others read",
    "nobody reads",
    "fails",
)
"""All verdicts: the product agrees with all others that read the file, or with some of them, or with none;
"fails" if it raised anything but its own error, took too long or crashed."""


@dataclass(frozen=True)
class Verdict:
    """The verdict on a file, or on an object of a .blend file.

    Attributes
    ----------
    path : Path
    part : str
        Name of the object; empty for a whole file.
    verdict : str
        One of `VERDICTS`.
    readers : tuple of str
        Readers that know the format.
    read : tuple of str
        Those that read it.
    differences : dict of str to dict
        Of the readers that differ from the product: the figures, see `differences`.
    message : str
        The product's, if it did not read it.
    """

    path: Path
    part: str
    verdict: str
    readers: tuple[str, ...]
    read: tuple[str, ...]
    differences: dict[str, dict[str, float]] = field(default_factory=dict)
    message: str = ""


def judge(readings: Sequence[Reading]) -> list[Verdict]:
    """Compare all readings of one file.

    Parameters
    ----------
    readings : sequence of Reading
        One of each reader that knows the format, the product's first.

    Returns
    -------
    verdicts : list of Verdict
        One; for a .blend file, one for each object that a reader found.
    """
    readers = tuple(reading.reader for reading in readings)
    product = readings[0]
    assert product.reader == PRODUCT
    names = sorted({name for reading in readings for name, _ in reading.parts}) or [""]
    verdicts = []
    for name in names:
        found = {reading.reader: _part(reading, name) for reading in readings}
        facts = {reader: part for reader, part in found.items() if part is not None}
        others = {reader: part for reader, part in facts.items() if reader != PRODUCT}
        differ: dict[str, dict[str, float]] = {}
        if PRODUCT in facts:
            compared = {reader: differences(facts[PRODUCT], part) for reader, part in others.items()}
            differ = {reader: figures for reader, figures in compared.items() if figures}
        verdict = _verdict(product.status, PRODUCT in facts, len(others), len(differ))
        verdicts.append(Verdict(product.path, name, verdict, readers, tuple(facts), differ, product.message))
    return verdicts


def _part(reading: Reading, name: str) -> Facts | None:
    return next((facts for part, facts in reading.parts if part == name), None)


def _verdict(status: str, read: bool, others: int, differing: int) -> str:
    if status in ("failed", "time", "crash"):
        return "fails"
    if not read:
        return "only others read" if others else "nobody reads"
    if not others:
        return "only the product reads"
    if not differing:
        return "agrees"
    return "agrees with some" if differing < others else "differs"

# SPDX-License-Identifier: MIT
"""Writing a comparison down: two tables for programs, and a page for people."""

from __future__ import annotations

import csv
import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path

from benchmarks.experiments.files.reading import Reading
from benchmarks.experiments.files.verdicts import VERDICTS, Verdict

__all__ = ["reason", "summary", "write_readings", "write_verdicts"]

# Number of files that the page names for each kind.
EXAMPLES = 3


def write_readings(path: Path, readings: Iterable[Reading], folder: Path) -> None:
    """Write what every reader made of every file as a table of comma-separated values.

    Parameters
    ----------
    path : Path
        File that is written.
    readings : iterable of Reading
    folder : Path
        That the files' paths are relative to.
    """
    corners = [f"{end}_{axis}" for end in ("lower", "upper") for axis in "xyz"]
    head = ["file", "reader", "status", "seconds", "part", "vertices", "faces", "area", *corners, "message"]
    with path.open("w", newline="", encoding="utf-8", errors="backslashreplace") as file:
        table = csv.writer(file)
        table.writerow(head)
        for reading in readings:
            name = _shown(reading.path, folder)
            start = [name, reading.reader, reading.status, f"{reading.seconds:.3f}"]
            for part, facts in reading.parts:
                figures = [facts.vertices, facts.faces, repr(facts.area), *facts.lower, *facts.upper]
                table.writerow([*start, part, *figures, reading.message])
            if not reading.parts:
                table.writerow([*start, "", *[""] * (len(head) - 6), reading.message])


def write_verdicts(path: Path, verdicts: Iterable[Verdict], folder: Path) -> None:
    """Write the verdicts as a table of comma-separated values.

    Parameters
    ----------
    path : Path
        File that is written.
    verdicts : iterable of Verdict
    folder : Path
        That the files' paths are relative to.
    """
    with path.open("w", newline="", encoding="utf-8", errors="backslashreplace") as file:
        table = csv.writer(file)
        table.writerow(["file", "part", "verdict", "readers", "read", "differences", "message"])
        for verdict in verdicts:
            words = [_shown(verdict.path, folder), verdict.part, verdict.verdict]
            lists = [" ".join(verdict.readers), " ".join(verdict.read), _shown_differences(verdict)]
            table.writerow([*words, *lists, verdict.message])


def summary(verdicts: Sequence[Verdict], folder: Path) -> str:
    """Write the page for people.

    Parameters
    ----------
    verdicts : sequence of Verdict
    folder : Path
        That the files' paths are relative to.

    Returns
    -------
    markdown : str
        Numbers for each format, the product's reasons with examples, and all differences.
    """
    lines = ["# Model files: the product beside other readers", ""]
    formats = sorted({verdict.path.suffix.lower() for verdict in verdicts})
    lines += ["| format | files | all read | " + " | ".join(VERDICTS) + " |", "|---|" + "---|" * 9]
    for suffix in formats:
        chosen = [verdict for verdict in verdicts if verdict.path.suffix.lower() == suffix]
        files = len({verdict.path for verdict in chosen})
        everyone = sum(verdict.readers == verdict.read for verdict in chosen)
        counts = Counter(verdict.verdict for verdict in chosen)
        figures = [files, everyone, *(counts[verdict] or "" for verdict in VERDICTS)]
        lines.append(f"| {suffix[1:]} | " + " | ".join(map(str, figures)) + " |")
    lines += ["", "A .blend file counts once for each of its objects.", ""]
    for kind in ("fails", "only others read", "nobody reads"):
        lines += _reasons(kind, [verdict for verdict in verdicts if verdict.verdict == kind], folder)
    for kind in ("differs", "agrees with some"):
        lines += _listed(kind, [verdict for verdict in verdicts if verdict.verdict == kind], folder)
    return "\n".join(lines)


def reason(message: str) -> str:
    """Reduce a message to its kind: what is quoted, and numbers, differ from file to file.

    Parameters
    ----------
    message : str

    Returns
    -------
    kind : str

    Examples
    --------
    >>> from benchmarks.experiments.files.report import reason
    >>> reason("'a.obj' ends after 3 of the 1,200 lines that it announces")
    '… ends after N of the N lines that it announces'
    """
    quoted = re.sub(r"""'[^']*'|"[^"]*\"""", "…", message)
    return re.sub(r"\d[\d,.]*\d|\d", "N", quoted)


def _reasons(kind: str, verdicts: Sequence[Verdict], folder: Path) -> list[str]:
    if not verdicts:
        return []
    groups: defaultdict[str, list[Verdict]] = defaultdict(list)
    for verdict in verdicts:
        said = reason(verdict.message) or "no such part"
        groups[f"{verdict.path.suffix.lower()[1:]}: {said}"].append(verdict)
    lines = [f"## {kind.capitalize()}", ""]
    for group, members in sorted(groups.items(), key=lambda item: (-len(item[1]), item[0])):
        shown = [f"`{_shown(each.path, folder)}`{f' {each.part}' if each.part else ''}" for each in members]
        lines.append(f"- {len(members)} {group} ({', '.join(shown[:EXAMPLES])})")
    return [*lines, ""]


def _listed(kind: str, verdicts: Sequence[Verdict], folder: Path) -> list[str]:
    if not verdicts:
        return []
    lines = [f"## {kind.capitalize()}", "", "| file | object | relative differences |", "|---|---|---|"]
    lines += [
        f"| {_shown(each.path, folder)} | {each.part} | {_shown_differences(each)} |" for each in verdicts
    ]
    return [*lines, ""]


def _shown(path: Path, folder: Path) -> str:
    return (path.relative_to(folder) if path.is_relative_to(folder) else path).as_posix()


def _shown_differences(verdict: Verdict) -> str:
    return "; ".join(
        f"{reader}: " + ", ".join(f"{figure} {value:.2g}" for figure, value in figures.items())
        for reader, figures in verdict.differences.items()
    )

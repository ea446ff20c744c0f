# SPDX-License-Identifier: MIT
"""Classification files (.cla) of the Princeton Shape Benchmark, which SHREC'11 and others use, too."""

from __future__ import annotations

from pathlib import Path

from benchmarks.errors import BenchmarkError

__all__ = ["read_classification"]


def read_classification(path: Path) -> dict[str, str]:
    """Read which class each model belongs to.

    The format: ``PSB 1``, the numbers of classes and models, then for each class its name, that of its parent
    (0: none), its number of models, and their identifiers. Any white space separates these.

    Parameters
    ----------
    path : Path

    Returns
    -------
    classes : dict of str to str
        Class by identifier of the model, in the order of the file. Parents without models of their own are
        left out.

    Raises
    ------
    BenchmarkError
        If the file cannot be read, has another format, or contradicts itself.
    """
    try:
        words = path.read_text(encoding="utf-8", errors="replace").split()
    except OSError as error:
        raise BenchmarkError(f"cannot read '{path}': {error.strerror}") from error
    if len(words) < 4 or words[0] != "PSB":
        raise BenchmarkError(f"'{path.name}' does not begin with \"PSB 1\", as classification files do")
    if words[1] != "1":
        raise BenchmarkError(f"'{path.name}' has version {words[1]} of its format; only version 1 is known")
    class_count, model_count = (_count(path, word) for word in words[2:4])
    names: set[str] = set()
    classes: dict[str, str] = {}
    place = 4
    while place < len(words):
        if place + 3 > len(words):
            raise BenchmarkError(f"'{path.name}' ends within the line of the class {words[place]!r}")
        name, parent, members = words[place], words[place + 1], _count(path, words[place + 2])
        if name in names:
            raise BenchmarkError(f"'{path.name}' has the class {name!r} twice")
        if parent != "0" and parent not in names:
            raise BenchmarkError(
                f"'{path.name}': the class {name!r} belongs to {parent!r}, which is not defined before it"
            )
        names.add(name)
        models = words[place + 3 : place + 3 + members]
        if len(models) < members:
            raise BenchmarkError(
                f"'{path.name}' ends after {len(models)} of the {members} models of the class {name!r}"
            )
        for model in models:
            if model in classes:
                raise BenchmarkError(
                    f"'{path.name}' has the model {model!r} in the classes {classes[model]!r} and {name!r}"
                )
            classes[model] = name
        place += 3 + members
    if (len(names), len(classes)) != (class_count, model_count):
        raise BenchmarkError(
            f"'{path.name}' announces {class_count} classes and {model_count} models, but has {len(names)} "
            f"and {len(classes)}; is it complete?"
        )
    return classes


def _count(path: Path, word: str) -> int:
    if not word.isdecimal():
        raise BenchmarkError(f"'{path.name}' has {word!r} where a number of classes or models belongs")
    return int(word)

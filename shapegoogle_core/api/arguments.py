# SPDX-License-Identifier: MIT
"""Checks of arguments that many functions share; each error names the argument and its limits."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from numbers import Integral, Real
from pathlib import Path
from reprlib import repr as short
from typing import Any

__all__ = ["as_path", "as_paths", "as_tuple", "check_count", "check_number", "check_type", "path_text"]


def check_count(name: str, value: object, least: int = 1) -> None:
    """Raise ValueError unless an argument is a whole number, and large enough.

    Parameters
    ----------
    name : str
        Name of the argument.
    value : object
    least : int, optional

    Raises
    ------
    ValueError
        If the value is not a whole number, or less than `least`.
    """
    if isinstance(value, bool) or not (isinstance(value, Integral) and int(value) >= least):
        raise ValueError(f"{name} must be a whole number of at least {least}, not {value!r}")


def check_number(
    name: str, value: object, least: float = 0.0, most: float = math.inf, *, positive: bool = False
) -> None:
    """Raise ValueError unless an argument is a finite number between two limits.

    Parameters
    ----------
    name : str
        Name of the argument.
    value : object
    least, most : float, optional
    positive : bool, optional
        Whether 0 is refused too.

    Raises
    ------
    ValueError
        If the value is not a number, not finite, or out of range.
    """
    right = isinstance(value, Real) and math.isfinite(value) and least <= float(value) <= most
    if not right or (positive and not value):
        if positive:
            wanted = "a positive number" if most == math.inf else f"a number above 0 and up to {most:g}"
        else:
            wanted = f"a number ≥ {least:g}" if most == math.inf else f"a number from {least:g} to {most:g}"
        raise ValueError(f"{name} must be {wanted}, not {value!r}")


def check_type(name: str, value: object, types: type | tuple[type, ...], expected: str) -> None:
    """Raise ValueError unless an argument is of one of some types.

    Parameters
    ----------
    name : str
        Name of the argument.
    value : object
    types : type or tuple of type
    expected : str
        Their description in the error, such as "a text".

    Raises
    ------
    ValueError
        If it is of another type.
    """
    if not isinstance(value, types):
        raise ValueError(f"{name} must be {expected}, not {short(value)}")


def as_tuple(name: str, values: object, types: type | tuple[type, ...], expected: str) -> tuple[Any, ...]:
    """Make a tuple of one value or several, so that a single text is not taken apart into its letters.

    Parameters
    ----------
    name : str
        Name of the argument.
    values : object
        One value of the accepted types, or an iterable of them.
    types : type or tuple of type
    expected : str
        Their description in the error.

    Returns
    -------
    values : tuple

    Raises
    ------
    ValueError
        If one of them is of another type.
    """
    several = isinstance(values, Iterable) and not isinstance(values, types)
    made = tuple(values) if several else (values,)  # type: ignore[arg-type]
    for value in made:
        check_type(name, value, types, expected)
    return made


def path_text(path: str | os.PathLike[str]) -> str:
    """Convert a path to text, as it is.

    Parameters
    ----------
    path : str or path

    Returns
    -------
    text : str

    Raises
    ------
    ValueError
        If it is neither.
    """
    check_type("a path", path, (str, os.PathLike), "a str or a pathlib.Path")
    return os.fspath(path)


def as_path(path: str | os.PathLike[str]) -> Path:
    """Convert to a path; "~" stands for the user's own folder.

    Parameters
    ----------
    path : str or path

    Returns
    -------
    path : Path

    Raises
    ------
    ValueError
        If it is neither.
    """
    return Path(os.path.expanduser(path_text(path)))  # noqa: PTH111 - `Path.expanduser` fails without a home folder


def as_paths(paths: str | os.PathLike[str] | Iterable[str | os.PathLike[str]]) -> list[Path]:
    """Convert one path or several to a list.

    Parameters
    ----------
    paths : str, path, or iterable of them

    Returns
    -------
    paths : list of Path

    Raises
    ------
    ValueError
        If one is neither a str nor a path.
    """
    if isinstance(paths, str | os.PathLike) or not isinstance(paths, Iterable):
        return [as_path(paths)]
    return [as_path(path) for path in paths]

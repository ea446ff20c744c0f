# SPDX-License-Identifier: MIT
"""Values in the JSON of a service, checked one by one: a service may be another program, or a hostile one."""

from __future__ import annotations

import base64
import math
import struct
from collections.abc import Sequence
from typing import Any, TypeVar

__all__ = ["one_of", "picture", "real", "text"]

Choice = TypeVar("Choice", bound=str)

_PNG = b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR"
# Pictures of shapes are smaller; one with more points could fill the memory of whoever shows it.
_MOST_PIXELS = 1_024


def text(value: Any) -> str:
    """Return a text that can be shown and written; raise TypeError or ValueError for others."""
    if not isinstance(value, str):
        raise TypeError
    value.encode()  # half a pair of surrogates is no text
    if "\0" in value:
        raise ValueError
    return value


def real(value: Any) -> float:
    """Return a finite number; raise TypeError or ValueError for anything else."""
    if isinstance(value, str) or not math.isfinite(value):
        raise ValueError
    return float(value)


def one_of(choices: Sequence[Choice], value: Any) -> Choice:
    """Return the choice that a value is; raise ValueError if it is none."""
    return choices[choices.index(value)]


def picture(value: Any) -> bytes:
    """Return a small picture in the format PNG, sent in base64; raise TypeError or ValueError for others."""
    content = base64.b64decode(value, validate=True)
    if not content.startswith(_PNG) or len(content) < len(_PNG) + 8:
        raise ValueError
    if max(struct.unpack_from(">II", content, len(_PNG))) > _MOST_PIXELS:
        raise ValueError
    return content

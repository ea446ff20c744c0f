# SPDX-License-Identifier: MIT
"""Objects of a glTF's JSON: values of the expected type, or an error that says where another one is."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from shapegoogle_core.mesh.io.file import DamagedError
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["JsonObject", "parse_json"]

_MOST = 1 << 53  # above any size of a file


def parse_json(text: bytes) -> JsonObject:
    """Parse the JSON of a glTF; `DamagedError` if it is not an object."""
    try:
        values = json.loads(text.rstrip(b"\0"))
    except (ValueError, RecursionError) as error:
        place = ""
        if isinstance(error, json.JSONDecodeError):
            place = f" at line {error.lineno}, column {error.colno}"
        raise DamagedError(f"has no valid JSON{place}") from error
    if not isinstance(values, dict):
        raise DamagedError("has JSON that is not an object")
    return JsonObject(values, "")


@dataclass(frozen=True)
class JsonObject:
    """An object of the JSON.

    Parameters
    ----------
    values : dict
    place : str
        Its place in the file, such as "meshes[0].primitives[1]"; empty for the whole.
    """

    values: dict[str, Any]
    place: str

    def has(self, key: str) -> bool:
        """Whether there is such a key; some programs write null for what is not there."""
        return self.values.get(key) is not None

    def whole(self, key: str, default: int | None = None) -> int:
        """Return a whole number ≥ 0."""
        value = _as_whole(self.values[key] if self.has(key) else default)
        if value is None:
            raise self._unexpected(key, "a whole number ≥ 0")
        return value

    def text(self, key: str, default: str | None = None) -> str:
        """Return a text."""
        value = self.values[key] if self.has(key) else default
        if not isinstance(value, str):
            raise self._unexpected(key, "a text")
        return value

    def texts(self, key: str) -> list[str]:
        """Return a list of texts, empty without the key."""
        values = self._list(key)
        if not all(isinstance(value, str) for value in values):
            raise self._unexpected(key, "a list of texts")
        return values

    def wholes(self, key: str) -> list[int]:
        """Return a list of whole numbers ≥ 0, empty without the key."""
        values = [whole for value in self._list(key) if (whole := _as_whole(value)) is not None]
        if len(values) < len(self._list(key)):
            raise self._unexpected(key, "a list of whole numbers ≥ 0")
        return values

    def numbers(self, key: str, count: int | None = None) -> FloatArray:
        """Return a list of finite numbers, of a length if one is given."""
        values = self._list(key)
        wrong = count is not None and len(values) != count
        for value in values:
            usable = isinstance(value, (int, float)) and not isinstance(value, bool)
            wrong = wrong or not usable or not math.isfinite(value) or abs(value) > 1e300
        if wrong:
            raise self._unexpected(key, "numbers" if count is None else f"{count} numbers")
        return np.array(values, np.float64)

    def object(self, key: str) -> JsonObject:
        """Return an object, empty without the key."""
        value = self.values[key] if self.has(key) else {}
        if not isinstance(value, dict):
            raise self._unexpected(key, "an object")
        return JsonObject(value, self._place(key))

    def objects(self, key: str) -> list[JsonObject]:
        """Return a list of objects, empty without the key."""
        values, place = self._list(key), self._place(key)
        if not all(isinstance(value, dict) for value in values):
            raise self._unexpected(key, "a list of objects")
        return [JsonObject(value, f"{place}[{index}]") for index, value in enumerate(values)]

    def _list(self, key: str) -> list[Any]:
        value = self.values[key] if self.has(key) else []
        if not isinstance(value, list):
            raise self._unexpected(key, "a list")
        return value

    def _place(self, key: str) -> str:
        return f"{self.place}.{key}" if self.place else key

    def _unexpected(self, key: str, expected: str) -> DamagedError:
        if not self.has(key):
            return DamagedError(f"has no {key!r} in {self.place or 'its JSON'}; it should be {expected}")
        found = json.dumps(self.values[key])[:40]
        return DamagedError(f"has {found} as {self._place(key)} instead of {expected}")


def _as_whole(value: object) -> int | None:
    """Return a whole number ≥ 0; some programs write 3.0."""
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    return value if isinstance(value, int) and not isinstance(value, bool) and 0 <= value < _MOST else None

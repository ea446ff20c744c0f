# SPDX-License-Identifier: MIT
"""The order of the examples in the gallery: from the first steps to research."""

from __future__ import annotations

ORDER = (
    "five_lines",
    "painted_signatures",
    "parts",
    "evidence",
    "duplicates",
    "correspondence",
    "training",
    "small_benchmark",
    "library_map",
)


class ExampleOrder:
    """Sorts examples by `ORDER`; sphinx-gallery calls it with the file names.

    Parameters
    ----------
    folder : str
    """

    def __init__(self, folder: str) -> None:
        self.folder = folder

    def __call__(self, name: str) -> int:
        """Return the place of an example; new ones come last."""
        stem = name.removesuffix(".py")
        return ORDER.index(stem) if stem in ORDER else len(ORDER)

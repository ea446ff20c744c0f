# SPDX-License-Identifier: MIT
"""Errors that every kind of storage reports alike."""

from __future__ import annotations

from shapegoogle_core.errors import LibraryError

__all__ = ["damaged"]


def damaged(library: str, detail: str) -> LibraryError:
    """Make the error for a library whose content contradicts itself.

    Parameters
    ----------
    library : str
        Name of the library, see `Store.name`.
    detail : str
        The contradiction.

    Returns
    -------
    error : LibraryError
    """
    return LibraryError(
        f"'{library}' is damaged or was cut short ({detail}); restore it from a backup, or delete it and "
        "index your folders again"
    )

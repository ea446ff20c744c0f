# SPDX-License-Identifier: MIT
"""What SQLite writes in another way than other databases."""

from __future__ import annotations

from shapegoogle_core.library.storage.filter_conditions import Dialect
from shapegoogle_core.library.storage.sqlite.database import encoded

__all__ = ["DIALECT", "fold_case"]

DIALECT = Dialect(
    value="?",
    text="CAST(? AS TEXT)",
    encoded=encoded,
    like="{} LIKE CAST(? AS TEXT) ESCAPE '\\'",  # ignores case, but only of ASCII letters
    exactly_like="{} LIKE CAST(? AS TEXT) ESCAPE '\\'",
    folded=lambda column: f"CAST(fold_case(CAST({column} AS BLOB)) AS TEXT)",
    greatest="max",
)


def fold_case(name: bytes) -> bytes:
    """Remove the differences between upper and lower case from a name in UTF-8, surrogates included.

    Parameters
    ----------
    name : bytes

    Returns
    -------
    folded : bytes
    """
    return encoded(name.decode("utf-8", "surrogatepass").casefold())

# SPDX-License-Identifier: MIT
"""What PostgreSQL writes in another way than other databases."""

from __future__ import annotations

from shapegoogle_core.library.storage.filter_conditions import (
    CATALOG,
    NAME,
    OBJECT_NAME,
    PATH,
    TAG,
    Dialect,
)

__all__ = ["DIALECT"]

_FOLDED = {
    NAME: "coalesce(folded, lower(name))",
    OBJECT_NAME: "coalesce(folded, lower(object_name))",
    TAG: "lower(tag)",
    CATALOG: "lower(catalog)",
    PATH: (
        "(coalesce(coalesce(roots.folded, lower(roots.path)) || '/', '')"
        " || coalesce(sources.folded, lower(sources.path)))"
    ),
}
# The columns have the collation "C", in which only ASCII letters have two cases.
DIALECT = Dialect(
    value="%s",
    text="%s",
    encoded=lambda text: text,
    like="{} ILIKE %s",
    exactly_like="{} LIKE %s",
    folded=_FOLDED.__getitem__,
    greatest="greatest",
)

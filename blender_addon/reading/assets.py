# SPDX-License-Identifier: GPL-3.0-or-later
"""Assets of a .blend file: their tags and catalogs.

It imports nothing but Python's own modules, since `reader` runs in a Blender without this add-on.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

__all__ = ["CATALOG_FILE", "catalog_of", "catalogs_for", "tags_of"]

CATALOG_FILE = "blender_assets.cats.txt"
"""File in the top folder of an asset library that names its catalogs."""


def catalogs_for(path: Path) -> dict[str, str]:
    """Read the catalogs of the asset library that a file lies in.

    Parameters
    ----------
    path : Path

    Returns
    -------
    catalogs : dict of str to str
        Paths such as "Props/Chairs", by the identifiers that assets refer to.
    """
    for folder in path.parents:
        listed = folder / CATALOG_FILE
        if listed.is_file():
            lines = listed.read_text(encoding="utf-8", errors="replace").splitlines()
            return dict(_catalog(line) for line in lines if line.count(":") >= 2 and line[0] != "#")
    return {}


def _catalog(line: str) -> tuple[str, str]:
    identifier, catalog, _ = line.split(":", 2)
    return identifier.strip().lower(), catalog.strip().strip("/")


def tags_of(item: Any) -> list[str]:
    """Return the tags of an asset.

    Parameters
    ----------
    item : bpy.types.ID

    Returns
    -------
    tags : list of str
        None for what is not marked as an asset.
    """
    return [] if item.asset_data is None else [tag.name for tag in item.asset_data.tags]


def catalog_of(item: Any, catalogs: Mapping[str, str]) -> str:
    """Return the catalog of an asset.

    Parameters
    ----------
    item : bpy.types.ID
    catalogs : mapping of str to str
        From `catalogs_for`.

    Returns
    -------
    catalog : str
        Its path; the short name that the asset keeps of it if the file of catalogs is missing; empty for no
        asset and no catalog.
    """
    if item.asset_data is None:
        return ""
    named = item.asset_data.catalog_simple_name
    return catalogs.get(item.asset_data.catalog_id.lower(), str(named))

# SPDX-License-Identifier: MIT
"""The table: every variant of the search that the benchmark knows, and choosing some of them."""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path

from shapegoogle_core.errors import BenchmarkError
from shapegoogle_core.evaluation.matching import VariantGroup
from shapegoogle_core.evaluation.model_variants import model_group
from shapegoogle_core.model import load_model

__all__ = ["choose_variants"]


def choose_variants(
    wanted: str, models: Sequence[str] = (), *, train: str | Path | None = None, seed: int = 0
) -> list[VariantGroup]:
    """Choose rows of the table.

    Parameters
    ----------
    wanted : str
        "models": the rows of the models; "all": these after everything else; else names of rows, in which
        * and ? stand for anything, whatever their case.
    models : sequence of str
        Files or names of shipped models.
    train : str or Path, optional
        Folder of meshes to learn from besides the procedural creatures.
    seed : int
        Of what is learnt.

    Returns
    -------
    groups : list of VariantGroup

    Raises
    ------
    BenchmarkError
        If no row has such a name.
    ModelError
        If a model cannot be loaded.
    """
    groups: list[VariantGroup] = []
    loaded = [load_model(name) for name in models]
    names = [model.name for model in loaded]
    for model in loaded:
        # Two files may hold models of one name.
        unlike = model.name if names.count(model.name) == 1 else f"{model.name} {model.identifier[:6]}"
        groups.append(model_group(model, unlike))
    if wanted in ("models", "all"):
        return groups
    chosen = {
        variant.name
        for group in groups
        for variant in group.variants
        if fnmatchcase(variant.name.lower(), wanted.lower())
    }
    if not chosen:
        known = [variant.name for group in groups for variant in group.variants]
        raise BenchmarkError(
            f"no variant is called {wanted!r}; choose all, models or some of: {'; '.join(known)}"
        )
    return [group for group in (group.only(chosen) for group in groups) if group.variants]

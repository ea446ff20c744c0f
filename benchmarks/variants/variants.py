# SPDX-License-Identifier: MIT
"""The table of all variants of the search, and the choice of some of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path

from benchmarks.errors import BenchmarkError
from benchmarks.protocol.learning import INDIVIDUALS
from benchmarks.protocol.matching import Variant, VariantGroup
from benchmarks.variants.bag_variants import BAG_NAMES, Descriptor, Preparation, bag_group
from benchmarks.variants.baseline_variants import mesh_groups, spectrum_groups
from benchmarks.variants.model_variants import model_group
from shapegoogle_core.keypoints import DETECTORS
from shapegoogle_core.model import PRESETS, load_model
from shapegoogle_core.model.settings import COUNTING_BAGS

__all__ = ["BITS", "WORDS", "choose_variants", "paper_variants"]

WORDS = (4, 8, 16, 32, 48, 64, 128)
"""Sizes of vocabularies."""

MAIN_WORDS = 48
"""The paper's choice."""

_PAPER_DESCRIPTORS = ("HKS", "SI-HKS")

BITS = (16, 32, 64, 128, 256, 512)
"""Lengths of codes."""

_ENERGIES = 100


def _preparations() -> tuple[Preparation, Preparation]:
    """Make the preparations: of the paper, and with the default model's preprocessing at the paper's area."""
    paper = PRESETS["paper"]
    preprocessed = replace(PRESETS["default"], area=paper.area)
    return Preparation("paper", paper), Preparation("preprocessed", preprocessed)


def _descriptors(preparation: Preparation) -> tuple[Descriptor, ...]:
    (channel,) = PRESETS["paper"].channels
    time = channel.pair_time
    # Energies of Aubry et al. 2011: 7 steps wide, and 2 widths inside the range of the logarithms of the
    # eigenvalues, which on a surface of area A are about 4πk / A (Weyl's law).
    settings = preparation.settings
    low = math.log(4 * math.pi / settings.area)
    high = math.log(4 * math.pi * settings.eigenpairs / settings.area)
    sigma = 7 * (high - low) / 127
    return (
        Descriptor("HKS", channel.descriptor, dict(channel.parameters), time),
        # As in Bronstein, Kokkinos 2010, in the same unit of time.
        Descriptor(
            "SI-HKS",
            "si-hks",
            {"alpha": 2.0, "tau_start": 1.0, "tau_end": 25.0, "tau_step": 1 / 16, "frequencies": 6},
            time,
        ),
        Descriptor(
            "WKS",
            "wks",
            {"low": low + 2 * sigma, "high": high - 2 * sigma, "count": _ENERGIES, "sigma": sigma},
            time,
            # The least logarithm in the wave kernel signature, as on parts that the spectrum leaves out.
            without_waves=_ENERGIES * (-10.0,),
        ),
    )


def _other_descriptors() -> tuple[Descriptor, ...]:
    """Make the other descriptors, with their usual parameters."""
    (channel,) = (channel for channel in PRESETS["default"].channels if channel.descriptor == "log-hks")
    times = [time * PRESETS["paper"].area for time in channel.parameters["times"]]
    parameters = {"log-hks": {"times": times}}
    names = {
        "log-hks": "log HKS",
        "gps": "GPS",
        "volumetric-hks": "volumetric HKS",
        "geodesic-histogram": "geodesic histogram",
        "spin-images": "spin image",
        "shape-context": "shape context",
        "mesh-hog": "mesh HOG",
    }
    return tuple(Descriptor(name, kind, parameters.get(kind, {}), 1.0) for kind, name in names.items())


def paper_variants(
    train: str | Path | None = None, seed: int = 0, individuals: int = INDIVIDUALS
) -> list[VariantGroup]:
    """List the paper's variants and the baselines.

    Parameters
    ----------
    train : str or Path, optional
        Folder of meshes to learn from besides the procedural creatures.
    seed : int
        Of what is learnt.
    individuals : int
        Of each kind of creature to learn from.

    Returns
    -------
    groups : list of VariantGroup
        Baselines first; then HKS and SI-HKS with all bags, vocabularies and codes on the paper's preparation;
        then 48 words of each, and of all other descriptors, on preprocessed meshes; HKS also at keypoints.
    """
    paper, preprocessed = _preparations()
    groups: list[VariantGroup] = [*mesh_groups(seed)]
    groups += [*spectrum_groups(paper, seed), *spectrum_groups(preprocessed, seed)]
    for preparation in (paper, preprocessed):
        for descriptor in _descriptors(preparation):
            complete = preparation is paper and descriptor.name in _PAPER_DESCRIPTORS
            variants = _bag_rows(preparation, descriptor, WORDS if complete else (MAIN_WORDS,))
            if complete:
                variants += _code_rows(preparation, descriptor)
            if preparation is preprocessed and descriptor.name == "HKS":
                variants += _detector_rows(preparation, descriptor)
            groups.append(
                bag_group(preparation, descriptor, variants, train=train, seed=seed, individuals=individuals)
            )
    for descriptor in _other_descriptors():
        variants = _bag_rows(preprocessed, descriptor, (MAIN_WORDS,))
        variants = tuple(variant for variant in variants if variant.headline)
        groups.append(
            bag_group(preprocessed, descriptor, variants, train=train, seed=seed, individuals=individuals)
        )
    return groups


def _bag_rows(preparation: Preparation, descriptor: Descriptor, sizes: Sequence[int]) -> tuple[Variant, ...]:
    rows = []
    place = "" if preparation.name == "paper" else f" · {preparation.name}"
    for bag, name in BAG_NAMES.items():
        by_area = bag in ("area", "pairs")
        for weighting in ("",) if by_area else ("", ", tf-idf"):
            for words in (MAIN_WORDS,) if by_area else sizes:
                parameters: dict[str, str | int | float] = {
                    "descriptor": descriptor.name,
                    "bag": name + weighting,
                    "words": words,
                    "preparation": preparation.name,
                }
                main = words == MAIN_WORDS and not weighting
                # For categories: the paper's bags, and all descriptors in one bag on preprocessed meshes.
                main &= not by_area if not place else bag == "area"
                title = f"{descriptor.name} · {name}{weighting} · {words} words{place}"
                family = "bags" if descriptor.name in _PAPER_DESCRIPTORS else "baseline"
                rows.append(Variant(title, family, parameters, headline=main))
    return tuple(rows)


def _code_rows(preparation: Preparation, descriptor: Descriptor) -> tuple[Variant, ...]:
    return tuple(
        Variant(
            f"{descriptor.name} · {bits}-bit codes · {projection}",
            "codes",
            {
                "descriptor": descriptor.name,
                "bag": BAG_NAMES["plain-pairs"],
                "words": MAIN_WORDS,
                "bits": bits,
                "projection": projection,
                "preparation": preparation.name,
            },
        )
        for projection in ("eigenvectors", "random")
        for bits in BITS
    )


def _detector_rows(preparation: Preparation, descriptor: Descriptor) -> tuple[Variant, ...]:
    return tuple(
        Variant(
            f"{descriptor.name} · {BAG_NAMES[bag]} at {detector} · {MAIN_WORDS} words · {preparation.name}",
            "bags",
            {
                "descriptor": descriptor.name,
                "bag": BAG_NAMES[bag],
                "detector": detector,
                "words": MAIN_WORDS,
                "preparation": preparation.name,
            },
        )
        for detector in DETECTORS
        for bag in COUNTING_BAGS
    )


def choose_variants(
    wanted: str, models: Sequence[str] = (), *, train: str | Path | None = None, seed: int = 0
) -> list[VariantGroup]:
    """Choose rows of the table.

    Parameters
    ----------
    wanted : str
        "models": the rows of the models; "all": all rows, those of the models last; otherwise names of rows,
        in which * and ? match any text, whatever its case.
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
    groups = [] if wanted == "models" else paper_variants(train, seed)
    loaded = [load_model(name) for name in models]
    names = [model.name for model in loaded]
    for model in loaded:
        # Two files may contain models of the same name.
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

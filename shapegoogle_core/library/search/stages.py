# SPDX-License-Identifier: MIT
"""Stages of a search that plug-ins may add: candidates, and a re-ranker of the matches."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shapegoogle_core.api.registry import Plugin, Registry, check_takes
from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.match import DISTANCE_DECIMALS, Match, ranked
from shapegoogle_core.library.search.candidates import NearestCodes
from shapegoogle_core.library.search.query import Query
from shapegoogle_core.library.search.settings import CandidateSettings, SearchSettings
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.model import ShapeModel

__all__ = [
    "CANDIDATE_STAGES",
    "OWN_STAGE",
    "RERANKERS",
    "CandidateStage",
    "MatchReranker",
    "check_stages",
    "chosen",
    "reorder",
]

T = TypeVar("T")

ShapeIds = NDArray[np.int64]

OWN_STAGE = "codes"
"""Name of the stage that takes the shapes with the nearest codes, `NearestCodes`."""


class CandidateStage(Protocol):
    """First stage of a search: the shapes that are compared with the query by their full bags."""

    def find(self, query: Query, top: int, among: ShapeIds | None = None) -> Sequence[int]:
        """Find candidates.

        Parameters
        ----------
        query : Query
        top : int
            Number of matches requested.
        among : (m,) array of int64, optional
            Ids of the shapes to choose from; all shapes by default.

        Returns
        -------
        shape_ids : sequence of int
            Some may be of shapes that are gone.
        """


class MatchReranker(Protocol):
    """Last stage of a search: new distances, which the matches are sorted by."""

    def distances(self, query: Query, matches: Sequence[Match]) -> ArrayLike:
        """Compute what the matches are sorted by.

        Parameters
        ----------
        query : Query
        matches : sequence of Match
            Best first. More than were requested, so that some can move forwards.

        Returns
        -------
        distances : (n,) array
            ≥ 0, one for each match.
        """


CandidateFactory = Callable[[Store, ShapeModel, CandidateSettings], CandidateStage]
RerankerFactory = Callable[[Store, ShapeModel, SearchSettings], MatchReranker]


class _PluginStage:
    """Candidates of a plug-in; only those that are asked for."""

    def __init__(self, stage: CandidateStage, plugin: Plugin) -> None:
        self._stage, self._plugin = stage, plugin

    def find(self, query: Query, top: int, among: ShapeIds | None = None) -> list[int]:
        with self._plugin.blamed(LibraryError):
            found = np.asarray(self._stage.find(query, top, among))
        if found.size == 0:
            return []
        if found.ndim != 1 or found.dtype.kind not in "iu":
            raise self._plugin.unfit("find a list of numbers of shapes")
        kept = found if among is None else found[np.isin(found, among)]
        return [int(shape_id) for shape_id in kept]


class _PluginReranker:
    """Distances of a plug-in, checked."""

    def __init__(self, reranker: MatchReranker, plugin: Plugin) -> None:
        self._reranker, self._plugin = reranker, plugin

    def distances(self, query: Query, matches: Sequence[Match]) -> NDArray[np.float64]:
        with self._plugin.blamed(LibraryError):
            distances = np.asarray(self._reranker.distances(query, matches), np.float64)
        if distances.shape != (len(matches),) or not (np.isfinite(distances) & (distances >= 0)).all():
            raise self._plugin.unfit("give each match a finite distance of at least 0")
        return distances


def _candidates_from_plugin(value: object, plugin: Plugin) -> CandidateFactory:
    check_takes(value, plugin, ("store", "model", "settings"))
    factory = cast(CandidateFactory, value)

    def make(store: Store, model: ShapeModel, settings: CandidateSettings) -> CandidateStage:
        with plugin.blamed(LibraryError):
            stage = factory(store, model, settings)
        if not callable(getattr(stage, "find", None)):
            raise plugin.unfit("make an object with a method 'find'")
        return _PluginStage(stage, plugin)

    return make


def _reranker_from_plugin(value: object, plugin: Plugin) -> RerankerFactory:
    check_takes(value, plugin, ("store", "model", "settings"))
    factory = cast(RerankerFactory, value)

    def make(store: Store, model: ShapeModel, settings: SearchSettings) -> MatchReranker:
        with plugin.blamed(LibraryError):
            reranker = factory(store, model, settings)
        if not callable(getattr(reranker, "distances", None)):
            raise plugin.unfit("make an object with a method 'distances'")
        return _PluginReranker(reranker, plugin)

    return make


CANDIDATE_STAGES: Registry[CandidateFactory] = Registry(
    "candidate stage",
    "shapegoogle.candidate_stages",
    {OWN_STAGE: NearestCodes},
    _candidates_from_plugin,
)
"""Classes of candidate stages by name, called with the store, the model and the settings."""

RERANKERS: Registry[RerankerFactory] = Registry(
    "re-ranker", "shapegoogle.rerankers", {}, _reranker_from_plugin
)
"""Classes of re-rankers of plug-ins by name, called with the store, the model and the settings."""


def chosen(registry: Registry[T], name: str) -> T:
    """Load a stage by its name.

    Parameters
    ----------
    registry : Registry
    name : str

    Returns
    -------
    factory : callable

    Raises
    ------
    LibraryError
        If there is none of that name.
    PluginError
        If it cannot be loaded.
    """
    if name not in registry:
        known = f"there are {', '.join(registry)}" if len(registry) else "there are none"
        raise LibraryError(
            f"there is no {registry.kind} {name!r}: {known}; check the spelling, or install the package of "
            "the plug-in"
        )
    return registry[name]


def check_stages(settings: SearchSettings) -> None:
    """Raise the errors of `chosen` for the stages that settings name."""
    if not settings.candidates.stages:
        raise LibraryError(f"a search needs a candidate stage, such as {OWN_STAGE!r}")
    for name in settings.candidates.stages:
        chosen(CANDIDATE_STAGES, name)
    if settings.rerank.reranker is not None:
        chosen(RERANKERS, settings.rerank.reranker)


def reorder(reranker: MatchReranker, query: Query, matches: Sequence[Match]) -> list[Match]:
    """Sort matches by the distances of a re-ranker.

    Parameters
    ----------
    reranker : MatchReranker
    query : Query
    matches : sequence of Match
        Best first.

    Returns
    -------
    matches : list of Match
        With the new distances; similarities stay those of the pairs.
    """
    distances = np.asarray(reranker.distances(query, matches), np.float64).round(DISTANCE_DECIMALS)
    moved = [
        ranked(match, distance, match.likeness)
        for match, distance in zip(matches, distances.tolist(), strict=True)
    ]
    # Stable: copies at the least distance have an order of their own.
    return sorted(moved, key=lambda match: match.distance)

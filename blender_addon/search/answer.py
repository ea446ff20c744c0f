# SPDX-License-Identifier: GPL-3.0-or-later
"""Show an answer: fill the gallery with its matches, then compare their surfaces a few at a time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy

from .. import jobs, state
from ..gallery import labels, pictures
from ..gallery.finding import find_objects
from ..state import session_of

if TYPE_CHECKING:
    from shapegoogle_core import Match
    from shapegoogle_core.service.requests import Answer

__all__ = ["explain_matches", "show_answer", "show_evidence", "show_failure"]

# Matches whose surfaces are compared in one task; a new query has to wait for it.
EXPLAINED_AT_ONCE = 6


def show_answer(context: Any, answer: Answer, seconds: float) -> None:
    """Put the matches of an answer into the gallery.

    Parameters
    ----------
    context : bpy.types.Context
    answer : Answer
    seconds : float
        How long it took.
    """
    session = session_of(context)
    session.searching = False
    session.library, session.asked = str(answer.library), answer.examples
    session.matches.clear()
    state.current().search.answer = answer
    pictures.clear()
    state.current().gallery.placed.clear()
    for match in answer.matches:
        line = session.matches.add()
        line.name = match.name
        line.object_name = match.object_name
        line.shape_id = match.shape_id
        line.source = match.source
        line.similarity, line.distance = match.similarity, match.distance
        line.size = (match.area / answer.area) ** 0.5
        line.vertex_count, line.face_count, line.area = match.vertex_count, match.face_count, match.area
        line.placement_count = match.placement_count
        labels.set_state(line, labels.COMPARING)
        pictures.keep(match.shape_id, answer.thumbnails.get(match.shape_id))
    find_objects(context, session.matches)
    session.active_match = 0 if answer.matches else -1
    session.page = 0
    count = f"{len(answer.matches)} of {answer.shape_count:,} shapes"
    session.answer = f"{session.query}: the best {count}, {seconds:.1f} s"
    session.shape_count = answer.shape_count


def show_evidence(context: Any, explained: dict[int, Match]) -> None:
    """Put evidence below the pictures of the matches it belongs to.

    Parameters
    ----------
    context : bpy.types.Context
    explained : dict of int to Match
        By the id of the shape; a match that cannot be compared keeps its similarity alone.
    """
    answer = state.current().search.answer
    moved = []
    for line in session_of(context).matches:
        if line.shape_id in explained:
            match = explained[line.shape_id]
            if match.object_name != line.object_name:
                line.object_name, line.area = match.object_name, match.area
                moved.append(line)
            if answer is not None:
                line.size = (match.area / answer.area) ** 0.5
            labels.set_evidence(line, match.evidence)
    find_objects(context, moved)


def explain_matches(answer: Answer, first: int = 0) -> None:
    """Compare the surfaces of the matches in the worker process, as long as their answer is the one shown.

    Parameters
    ----------
    answer : Answer
    first : int
        Position of the match to go on from.
    """
    from shapegoogle_core.service.requests import explain

    portion = answer.matches[first : first + EXPLAINED_AT_ONCE]
    if not portion or not _is_shown(answer):
        return

    def done(explained: dict[int, Match]) -> None:
        if _is_shown(answer):
            show_evidence(bpy.context, explained)
            explain_matches(answer, first + EXPLAINED_AT_ONCE)

    def failed(error: BaseException) -> None:
        if _is_shown(answer):
            rest = {match.shape_id for match in answer.matches[first:]}
            for line in session_of(bpy.context).matches:
                if line.shape_id in rest:
                    labels.set_state(line, labels.NOT_COMPARED)
            session_of(bpy.context).answer += f"; surfaces could not be compared: {error}"

    jobs.watch(jobs.worker().submit(explain, answer.library, answer.signatures, portion), done, failed)


def _is_shown(answer: Answer) -> bool:
    return state.current().search.answer is answer


def show_failure(context: Any, reason: str) -> None:
    """Empty the gallery and show why there is no answer.

    Parameters
    ----------
    context : bpy.types.Context
    reason : str
    """
    session = session_of(context)
    session.matches.clear()
    state.current().search.answer = None
    session.active_match = -1
    session.answer = reason

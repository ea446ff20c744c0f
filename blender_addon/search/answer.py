# SPDX-License-Identifier: GPL-3.0-or-later
"""Show an answer: fill the gallery with its matches, then compare their surfaces a few at a time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy

from .. import jobs, state
from ..gallery import labels, pictures
from ..gallery.filters import is_filtered
from ..gallery.finding import find_objects
from ..library.address import library_key
from ..library.present import refresh
from ..state import session_of
from ..translation import counted, error_text, tr

if TYPE_CHECKING:
    from shapegoogle_core import Match
    from shapegoogle_core.worker.requests import Answer

__all__ = [
    "describe_match",
    "drop_answer",
    "explain_matches",
    "show_answer",
    "show_evidence",
    "show_matches",
    "show_versions",
]

# Matches whose surfaces are compared in one task; a new query has to wait for it.
EXPLAINED_AT_ONCE = 6
EXPLAINED_BY_SERVICE = 25


def show_answer(context: Any, answer: Answer, seconds: float) -> None:
    """Put the matches of a new query into the gallery.

    Parameters
    ----------
    context : bpy.types.Context
    answer : Answer
    seconds : float
        How long it took.
    """
    session = session_of(context)
    session.searching = False
    session.asked = answer.examples
    state.current().search.examples = state.current().search.coming
    pictures.clear()
    # What came from the library is not new to it, also when this list begins again.
    state.current().new_objects.known |= state.current().gallery.placed
    state.current().gallery.placed.clear()
    state.current().search.asked_with = state.current().search.asking_with
    show_matches(context, answer, seconds)
    session.active_match = 0 if answer.matches else -1


def show_matches(context: Any, answer: Answer, seconds: float) -> None:
    """Put the matches of the present query into the gallery; the chosen one stays chosen if it is among them.

    Parameters
    ----------
    context : bpy.types.Context
    answer : Answer
    seconds : float
        How long it took.
    """
    session, search = session_of(context), state.current().search
    chosen = session.active_match
    chosen_id = session.matches[chosen].shape_id if 0 <= chosen < len(session.matches) else None
    # The library as it is chosen: the answer may spell its path in another way.
    session.library = library_key(context)
    session.opened = -1
    session.versions.clear()
    search.answer, search.versions = answer, None
    search.explained.clear()
    state.current().gallery.view.scroll = 0.0
    _fill(session.matches, answer)
    find_objects(context, session.matches)
    ids = [match.shape_id for match in answer.matches]
    session.active_match = ids.index(chosen_id) if chosen_id in ids else 0 if ids else -1
    session.page = 0
    session.shape_count = answer.shape_count
    parts = (_sentence(session, len(ids), answer.shape_count, seconds), *search.asked_with.notes)
    session.answer = "; ".join(parts)


def _sentence(session: Any, count: int, among: int, seconds: float) -> str:
    filtered = is_filtered(session)
    if not count:
        template = (
            tr("{query}: no match meets the filters among {among:,} shapes")
            if filtered
            else tr("{query}: no match among {among:,} shapes")
        )
        return template.format(query=session.query, among=among)
    if session.collapse and filtered:
        found = counted(
            "{count} different shape that meets the filters",
            "{count} different shapes that meet the filters",
            count,
        )
    elif session.collapse:
        found = counted("{count} different shape", "{count} different shapes", count)
    elif filtered:
        found = counted("{count} shape that meets the filters", "{count} shapes that meet the filters", count)
    else:
        found = counted("{count:,} shape", "{count:,} shapes", count)
    return tr("{query}: {found}, the best of {among:,}, {seconds:.1f} s").format(
        query=session.query, found=found, among=among, seconds=seconds
    )


def show_versions(context: Any, answer: Answer, index: int) -> None:
    """Put the versions of a match into the gallery, in place of the matches.

    Parameters
    ----------
    context : bpy.types.Context
    answer : Answer
        With the match and its versions.
    index : int
        Of the match.
    """
    session = session_of(context)
    state.current().search.versions = answer
    _fill(session.versions, answer)
    find_objects(context, session.versions)
    session.opened, session.page_of_matches, session.page = index, session.page, 0
    ids = [match.shape_id for match in answer.matches]
    match_id = session.matches[index].shape_id
    session.active_version = ids.index(match_id) if match_id in ids else 0


def _fill(lines: Any, answer: Answer) -> None:
    """Describe each match of an answer in a line."""
    lines.clear()
    for match in answer.matches:
        describe_match(lines.add(), match, answer.area)
        pictures.keep(match.shape_id, answer.thumbnails.get(match.shape_id))


def describe_match(line: Any, match: Match, area: float) -> None:
    """Describe a match in a line, without its evidence.

    Parameters
    ----------
    line : SHAPEGOOGLE_PG_match
    match : Match
    area : float
        Of the query.
    """
    line.name = match.name
    line.object_name = match.object_name
    line.title = match.name if match.name != match.object_name else ""
    line.shape_type = match.origin.shape_type or ""
    line.tags, line.catalog = ", ".join(match.tags), match.origin.catalog
    line.frame = "" if match.origin.frame is None else str(match.origin.frame)
    line.shape_id = match.shape_id
    line.source = match.source
    line.similarity, line.distance = match.similarity, match.distance
    line.size = match.relative_size(area)
    line.vertex_count, line.face_count, line.area = match.vertex_count, match.face_count, match.area
    line.likeness = -1 if match.likeness is None else match.likeness
    line.placement_count = match.placement_count
    line.version_count = match.versions
    line.evidence = labels.COMPARING


def show_evidence(context: Any, explained: dict[int, Match]) -> None:
    """Put evidence below the pictures of the matches it belongs to.

    Parameters
    ----------
    context : bpy.types.Context
    explained : dict of int to Match
        By the id of the shape; a match that cannot be compared keeps its similarity alone.
    """
    session, answer = session_of(context), state.current().search.answer
    moved = []
    for line in (*session.matches, *session.versions):
        if line.shape_id in explained:
            match = explained[line.shape_id]
            state.current().search.explained[line.shape_id] = match
            if match.object_name != line.object_name:
                line.object_name, line.area = match.object_name, match.area
                moved.append(line)
            if answer is not None:
                line.size = match.relative_size(answer.area)
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
    from shapegoogle_core.worker.requests import explain

    # A service allows a number of requests in a minute.
    count = EXPLAINED_BY_SERVICE if answer.library.is_service else EXPLAINED_AT_ONCE
    portion = answer.matches[first : first + count]
    if not portion or not _is_shown(answer):
        return

    def done(explained: dict[int, Match]) -> None:
        if _is_shown(answer):
            show_evidence(bpy.context, explained)
            explain_matches(answer, first + count)

    def failed(error: BaseException) -> None:
        if _is_shown(answer):
            session = session_of(bpy.context)
            rest = {match.shape_id for match in answer.matches[first:]}
            for lines in (session.matches, session.versions):
                for line in lines:
                    if line.shape_id in rest and line.evidence == labels.COMPARING:
                        line.evidence = labels.NOT_COMPARED
            session.answer = tr("{answer}; surfaces could not be compared: {reason}").format(
                answer=session.answer, reason=error_text(error)
            )
            refresh(bpy.context)  # such as a library that was deleted meanwhile

    jobs.watch(jobs.worker().submit(explain, answer.library, answer.signatures, portion), done, failed)


def _is_shown(answer: Answer) -> bool:
    search = state.current().search
    return answer is search.answer or answer is search.versions


def drop_answer(context: Any, reason: str) -> None:
    """Empty the gallery, and end a search that runs.

    Parameters
    ----------
    context : bpy.types.Context
    reason : str
        Shown in place of the answer; may be empty.
    """
    session, search = session_of(context), state.current().search
    if search.waiting is not None:
        search.waiting.cancel()
        search.waiting = None
    session.searching = False
    session.matches.clear()
    session.versions.clear()
    session.active_match, session.opened, session.page = -1, -1, 0
    search.answer = search.versions = None
    pictures.clear()
    session.answer = reason

# SPDX-License-Identifier: GPL-3.0-or-later
"""Decide about the chosen match, or about the chosen member of a group of duplicates."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import EnumProperty

from .. import jobs, state
from ..gallery.labels import title
from ..gallery.on_match import OnMatch, active_match
from ..library.address import library_address
from ..library.open_file import open_source, shown_file
from ..library.status_bar import tell
from ..preferences import preferences
from ..search.operators import refine, refine_and_wait
from ..state import session_of
from ..translation import counted, error_text, tr
from .properties import KINDS, show_decisions

if TYPE_CHECKING:
    from concurrent.futures import Future

    from shapegoogle_core.library.decisions.decision import Decision
    from shapegoogle_core.worker.decisions import Outside

__all__ = ["DECISIONS", "register", "unregister"]

DECISIONS = (
    (
        "NOT_A_MATCH",
        "Not a Match",
        "Searches with this query do not find this shape any more, nor the versions collapsed with it. The "
        "panel Decisions takes it back",
        "CANCEL",
        0,
    ),
    (
        "KEEP_BOTH",
        "Keep Both",
        "The two shapes are not listed as duplicates of each other any more. The panel Decisions takes it "
        "back",
        "DUPLICATE",
        1,
    ),
    (
        "MASTER",
        "Set as Master",
        "The shape comes first among its duplicates: the others may be replaced by it. The panel Decisions "
        "takes it back",
        "FUND",
        2,
    ),
)
"""Items of the decisions that can be made in Blender."""

_TOOLTIPS = {item[0]: item[2] for item in DECISIONS}


def submit(
    context: Any, kind: str, shapes: Sequence[int | Outside], others: Sequence[int]
) -> Future[list[Decision]]:
    """Have the worker remember decisions in the library, under the author's name.

    Parameters
    ----------
    context : bpy.types.Context
    kind : str
        One of `KINDS`.
    shapes : sequence of int or Outside
    others : sequence of int
        See `shapegoogle_core.worker.decisions.decide`.

    Returns
    -------
    decisions : Future
        All of the library.
    """
    from shapegoogle_core.worker.decisions import decide

    chosen = preferences(context)
    return jobs.worker().submit(
        decide, library_address(context), KINDS[kind][0], shapes, others, chosen.author_name()
    )


class _Decides:
    """Base of the operators that decide; `_plan` says what about, `_follow` what is shown then."""

    kind = ""

    def _plan(self, context: Any) -> tuple[list[Any], list[int], str] | None:
        """Return the shapes, those that they are paired with, and what is said of the decision."""
        raise NotImplementedError

    @staticmethod
    def _follow(context: Any, kind: str, shapes: Sequence[Any], *, wait: bool = False) -> None:
        """Show what has changed by it."""
        raise NotImplementedError

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Decide in the worker process; the window stays usable."""
        planned = self._plan(context)
        if planned is None:
            return {"CANCELLED"}
        shapes, others, sentence = planned
        kind, follow = self.kind, self._follow

        def done(made: list[Decision]) -> None:
            _show(bpy.context, made, sentence)
            tell(bpy.context, sentence)  # the panel of decisions may be closed, or out of sight
            follow(bpy.context, kind, shapes)

        def failed(error: BaseException) -> None:
            _say(bpy.context, error_text(error))
            tell(bpy.context, error_text(error))

        jobs.watch(submit(context, kind, shapes, others), done, failed)
        return {"FINISHED"}

    def execute(self: Any, context: Any) -> set[str]:
        """Decide before returning."""
        from shapegoogle_core import ShapeGoogleError

        planned = self._plan(context)
        if planned is None:
            return {"CANCELLED"}
        shapes, others, sentence = planned
        try:
            _show(context, submit(context, self.kind, shapes, others).result(), sentence)
            self._follow(context, self.kind, shapes, wait=True)
        except ShapeGoogleError as error:
            self.report({"ERROR"}, error_text(error))
            return {"CANCELLED"}
        self.report({"INFO"}, sentence)
        return {"FINISHED"}

    @classmethod
    def description(cls, _context: Any, properties: Any) -> str:
        """Return the tooltip of one decision."""
        return tr(_TOOLTIPS[properties.kind])


def _show(context: Any, made: Sequence[Decision], sentence: str) -> None:
    show_decisions(context, made)
    _say(context, sentence)


def _say(context: Any, sentence: str) -> None:
    session_of(context).decided = sentence


def query_shapes() -> tuple[list[int | Outside], str]:
    """Return the shapes that the answer shown was searched with, and their names.

    Returns
    -------
    shapes : list of int or Outside
        Numbers of those that are examples from the library.
    names : str
    """
    from shapegoogle_core.worker.decisions import Outside

    search = state.current().search
    if search.answer is None:
        return [], ""
    shapes = [
        number or Outside(signature, name, open_source())
        for signature, (name, number) in zip(search.answer.signatures, search.examples, strict=True)
    ]
    return shapes, ", ".join(name for name, _ in search.examples)


class SHAPEGOOGLE_OT_decide_match(OnMatch, _Decides, bpy.types.Operator):
    """Decide about the chosen match."""

    bl_idname = "shape_google.decide_match"
    bl_label = "Decide"
    bl_description = "Decide about the chosen match"

    kind: EnumProperty(name="Decision", items=DECISIONS)

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that a match is chosen, of the library that is shown."""
        if not super().poll(context):
            return False
        if state.current().search.answer is None or session_of(context).searching:
            cls.poll_message_set(tr("Find similar shapes and choose a match first"))
            return False
        return True

    def _plan(self, context: Any) -> tuple[list[Any], list[int], str] | None:
        from shapegoogle_core.library.decisions.decision import told_apart
        from shapegoogle_core.worker.decisions import Outside

        match, session = active_match(context), session_of(context)
        shapes, names = query_shapes()
        name = title(match)
        if self.kind == "MASTER":
            return [match.shape_id], [], tr("{query} is the master among its duplicates").format(query=name)
        source = open_source() if any(isinstance(shape, Outside) for shape in shapes) else ""
        names, name = told_apart((names, shown_file(source)), (name, shown_file(match.source)))
        others = [match.shape_id]
        if self.kind == "KEEP_BOTH":
            return shapes, others, tr("Keep both {query} and {name}").format(query=names, name=name)
        if session.opened < 0:  # a card stands for all its versions
            answer = state.current().search.answer
            others += [
                number
                for found in ([] if answer is None else answer.matches)
                if found.shape_id == match.shape_id
                for number in found.version_ids
            ]
        if len(others) > 1:
            sentence = counted(
                "{name} and its other version are no match for {query}",
                "{name} and its {count:,} other versions are no match for {query}",
                len(others) - 1,
                name=name,
                query=names,
            )
        else:
            sentence = tr("{name} is no match for {query}").format(name=name, query=names)
        return shapes, others, sentence

    @staticmethod
    def _follow(context: Any, kind: str, _shapes: Sequence[Any], *, wait: bool = False) -> None:
        """Search again without what is no match."""
        if kind != "NOT_A_MATCH":
            return
        if wait:
            refine_and_wait(context)
        else:
            refine(context)


class SHAPEGOOGLE_OT_decide_duplicate(_Decides, bpy.types.Operator):
    """Decide about the chosen member of the group."""

    bl_idname = "shape_google.decide_duplicate"
    bl_label = "Decide"
    bl_description = "Decide about the chosen member of the group"

    kind: EnumProperty(name="Decision", items=DECISIONS[1:])

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that a member of a group of the library is chosen."""
        shown = context.window_manager.shape_google_duplicates
        if shown.running:
            cls.poll_message_set(tr("Wait until the search or the linking has ended, or cancel it"))
            return False
        if shown.found_in == "SCENE":
            cls.poll_message_set(
                tr("A library remembers decisions: index this scene, and find duplicates in the library")
            )
            return False
        if shown.found_in != "LIBRARY" or _chosen_member(shown) is None:
            cls.poll_message_set(tr("Find duplicates in the library, and choose a member of a group"))
            return False
        return True

    def _plan(self, context: Any) -> tuple[list[Any], list[int], str] | None:
        shown = context.window_manager.shape_google_duplicates
        chosen = _chosen_member(shown)
        if chosen is None:
            return None
        group, member = chosen
        if self.kind == "MASTER":
            return (
                [member.shape_id],
                [],
                tr("{query} is the master among its duplicates").format(query=member.title),
            )
        first = group.members[0]
        # Of the first one all others are said to be duplicates.
        others = [first.shape_id] if member != first else [line.shape_id for line in group.members[1:]]
        if member == first:
            sentence = counted(
                "Keep {name} and the other one",
                "Keep {name} and all {count:,} others",
                len(others),
                name=member.title,
            )
        else:
            from shapegoogle_core.library.decisions.decision import told_apart

            query, name = told_apart(
                (member.title, shown_file(member.source)), (first.title, shown_file(first.source))
            )
            sentence = tr("Keep both {query} and {name}").format(query=query, name=name)
        return [member.shape_id], others, sentence

    @staticmethod
    def _follow(context: Any, kind: str, shapes: Sequence[Any], *, wait: bool = False) -> None:
        """Show the groups without what is kept; a new master has to be compared with the others."""
        shown = context.window_manager.shape_google_duplicates
        if kind == "MASTER":
            bpy.ops.shape_google.find_duplicates("EXEC_DEFAULT" if wait else "INVOKE_DEFAULT")
            return
        # Another line may be chosen by now, or others be listed.
        found = [
            (number, place)
            for number, group in enumerate(shown.groups)
            for place, member in enumerate(group.members)
            if member.shape_id in shapes
        ]
        if shown.found_in != "LIBRARY" or not found:
            return
        number, place = found[0]
        group = shown.groups[number]
        if place == 0 or len(group.members) < 3:
            shown.groups.remove(number)
            shown.index = min(shown.index - (number < shown.index), max(0, len(shown.groups) - 1))
            return
        group.members.remove(place)
        group.meshes -= 1
        group.active_member = min(group.active_member - (place < group.active_member), len(group.members) - 1)


def _chosen_member(shown: Any) -> tuple[Any, Any] | None:
    group = shown.groups[shown.index] if 0 <= shown.index < len(shown.groups) else None
    if group is None or not 0 <= group.active_member < len(group.members):
        return None
    return group, group.members[group.active_member]


register, unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_OT_decide_match, SHAPEGOOGLE_OT_decide_duplicate)
)

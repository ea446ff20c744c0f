# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of the session that the panel Decisions shows."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import BoolProperty, CollectionProperty, IntProperty, StringProperty

from ..state import session_of
from ..translation import tr

if TYPE_CHECKING:
    from shapegoogle_core.library.decisions.decision import Decision

__all__ = ["KINDS", "DecisionProperties", "register", "show_decisions", "unregister"]

KINDS = {
    "NOT_A_MATCH": ("not a match", "CANCEL"),
    "KEEP_BOTH": ("keep both", "DUPLICATE"),
    "MASTER": ("master", "FUND"),
    "TAG": ("tag", "BOOKMARKS"),
    "NO_TAG": ("no tag", "REMOVE"),
}
"""The core's name and the icon of each kind of decision."""

_ICONS = dict(KINDS.values())


class SHAPEGOOGLE_PG_decision(bpy.types.PropertyGroup):
    """A decision about shapes of the library; its name is its sentence, which the list is filtered by."""

    number: IntProperty()
    chosen: BoolProperty(name="Chosen", description="Undo this decision with Undo Decisions")
    icon: StringProperty()
    author: StringProperty(name="Author")
    time: StringProperty(name="Time")


class DecisionProperties:
    """Part of the session: the decisions of the library."""

    decisions: CollectionProperty(type=SHAPEGOOGLE_PG_decision)
    active_decision: IntProperty(name="Decision")
    decided: StringProperty(name="Decided", description="What was decided last, or why that failed")


def show_decisions(context: Any, made: Sequence[Decision]) -> None:
    """List decisions, the latest first; those that were chosen stay chosen.

    Parameters
    ----------
    context : bpy.types.Context
    made : sequence of Decision
        All of the library, oldest first.
    """
    session = session_of(context)
    latest = [decision for decision in reversed(made) if decision.number]
    if [line.number for line in session.decisions] == [decision.number for decision in latest]:
        return
    chosen = {line.number for line in session.decisions if line.chosen}
    session.decisions.clear()
    for decision in latest:
        line = session.decisions.add()
        line.name = _sentence(decision)
        line.number, line.author = decision.number, decision.author
        line.icon = _ICONS[decision.kind]
        line.time = time.strftime("%Y-%m-%d %H:%M", time.localtime(decision.time))
        line.chosen = decision.number in chosen
    session.active_decision = min(session.active_decision, max(0, len(latest) - 1))


def _sentence(decision: Decision) -> str:
    """Return a decision in the language of the interface."""
    first, second = decision.titles
    template = {
        "not a match": tr("{name} is no match for {query}"),
        "keep both": tr("Keep both {query} and {name}"),
        "master": tr("{query} is the master among its duplicates"),
        "tag": tr("{query} has the tag {tag}"),
        "no tag": tr("{query} does not have the tag {tag}"),
    }[decision.kind]
    return template.format(query=first, name=second, tag=decision.tag)


register, unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_PG_decision,))

# SPDX-License-Identifier: GPL-3.0-or-later
"""Texts of a match: below its picture, in the details of the chosen match, and in its tooltip."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from shapegoogle_core import Evidence

__all__ = [
    "COMPARING",
    "NOT_COMPARED",
    "below_picture",
    "details",
    "set_evidence",
    "set_state",
    "similarity_text",
    "title",
    "tooltip",
]

COMPARING = "Comparing …"
"""Stands in for evidence until the surfaces have been compared."""
NOT_COMPARED = "Not compared"
"""Stands in for evidence if the comparison failed."""


def below_picture(match: Any) -> str:
    """Return the text under a picture in the gallery: similarity and kind, short enough for its width.

    Parameters
    ----------
    match : SHAPEGOOGLE_PG_match

    Returns
    -------
    text : str
        Such as "0.98  Re-posed"; without evidence the similarity alone.
    """
    return f"{similarity_text(match)}  {match.label}".rstrip()


def title(match: Any) -> str:
    """Return the name of a match: of its object, or of its asset or file if the object's says nothing.

    Parameters
    ----------
    match : SHAPEGOOGLE_PG_match

    Returns
    -------
    title : str
    """
    return str(match.title or match.object_name or match.name)


def details(match: Any) -> list[str]:
    """Return the lines that describe the chosen match.

    Parameters
    ----------
    match : SHAPEGOOGLE_PG_match

    Returns
    -------
    lines : list of str
    """
    similarity = f"similarity {similarity_text(match)}"
    return [
        f"{match.relation}, {similarity}" if match.relation else similarity.capitalize(),
        f"{match.vertex_count:,} vertices, size ×{match.size:.3g}",
    ]


def tooltip(match: Any) -> str:
    """Return the tooltip of a match, with all that has no room below its picture.

    Parameters
    ----------
    match : SHAPEGOOGLE_PG_match

    Returns
    -------
    text : str
    """
    where = f"{match.object_name} in {match.source}" if match.object_name else match.source
    lines = [where or match.name]
    if match.title and match.title != match.object_name:
        lines.insert(0, match.title)
    what = [match.shape_type.capitalize()] if match.shape_type else []
    if match.placement_count > 1:
        what.append(f"shown {match.placement_count:,} times")
    if match.frame:
        what.append(f"frame {match.frame}")
    if match.catalog:
        what.append(f"catalog {match.catalog}")
    if match.tags:
        what.append(f"tags {match.tags}")
    if what:
        lines.append(", ".join(what))
    kind = f"{match.kind}. " if match.kind else ""
    likeness = f"likeness {match.likeness:.2f}, " if match.likeness >= 0 else ""
    lines.append(
        f"{kind}Similarity {match.similarity:.3f}, {likeness}distance {match.distance:.4f}, "
        f"{match.vertex_count:,} vertices, size ×{match.size:.3g}"
    )
    return "\n".join(lines)


def similarity_text(match: Any) -> str:
    """Return a similarity with two digits; only a match at distance 0 is shown as 1.

    Parameters
    ----------
    match : SHAPEGOOGLE_PG_match

    Returns
    -------
    text : str
    """
    rounded = f"{match.similarity:.2f}"
    return "0.99+" if rounded == "1.00" and match.distance > 0 else rounded


def set_evidence(match: Any, evidence: Evidence | None) -> None:
    """Write evidence in words into a match.

    Parameters
    ----------
    match : SHAPEGOOGLE_PG_match
        Gets ``kind`` ("Re-posed ×0.978"), ``relation`` (without the size, which is shown on its own, unless
        the size is all that differs) and ``label`` (shorter still, for the width of a picture).
    evidence : Evidence or None
        None if the match cannot be compared: it shows only its similarity.
    """
    from shapegoogle_core.rendering.text import evidence_text

    if evidence is None:
        set_state(match, "")
        return
    match.kind = _capital(evidence_text(evidence))
    without_size = evidence if evidence.kind == "scaled" else replace(evidence, factor=1.0)
    match.relation = _capital(evidence_text(without_size))
    match.label = match.relation
    if evidence.kind == "part of" and evidence.share is not None:
        match.label = f"{100 * evidence.share:.0f} % of it"
    if evidence.kind == "nothing in common":
        match.label = "Unlike"


def set_state(match: Any, text: str) -> None:
    """Write a text in place of evidence into a match.

    Parameters
    ----------
    match : SHAPEGOOGLE_PG_match
    text : str
    """
    match.kind = match.relation = match.label = text


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]

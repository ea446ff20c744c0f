# SPDX-License-Identifier: GPL-3.0-or-later
"""Texts of a match: below its picture, in the details of the chosen match, and in its tooltip."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..translation import counted, marked, tr

if TYPE_CHECKING:
    from shapegoogle_core import Evidence

__all__ = [
    "COMPARING",
    "NOT_COMPARED",
    "below_picture",
    "details",
    "evidence_text",
    "one_line",
    "set_evidence",
    "similarity_text",
    "title",
    "tooltip",
]

COMPARING = "COMPARING"
"""Stands in for the kind of evidence until the surfaces have been compared."""
NOT_COMPARED = "FAILED"
"""Stands in for the kind of evidence if the comparison failed."""

# As `shapegoogle_core.library.evidence.KINDS`, which registering must not import; a test compares them.
KINDS = {
    "identical": marked("Identical"),
    "moved": marked("Moved"),
    "scaled": marked("Scaled"),
    "mirrored": marked("Mirrored"),
    "re-meshed": marked("Re-meshed"),
    "version": marked("Version"),
    "re-posed": marked("Re-posed"),
    "part of": marked("Contains the query"),
    "contains": marked("Part of the query"),
    "similar": marked("Similar"),
    "same kind": marked("Same kind"),
    "nothing in common": marked("Nothing in common"),
}
_STATES = {COMPARING: marked("Comparing …"), NOT_COMPARED: marked("Not compared")}
# Factors of the size that are shown: below this the two sizes look the same.
_SHOWN_FACTOR = 0.02
# Kinds of two different surfaces, whose sizes say nothing.
_WITHOUT_SIZE = ("similar", "same kind", "nothing in common")
# As `shapegoogle_core.library.origin.SHAPE_TYPES`, likewise.
TYPES = {
    "file": marked("File"),
    "object": marked("Object"),
    "point cloud": marked("Point cloud"),
    "curve": marked("Curve"),
    "text": marked("Text"),
    "surface": marked("Surface"),
    "metaball": marked("Metaball"),
    "collection": marked("Collection"),
    "instance": marked("Instance"),
    "scatter": marked("Scatter"),
}


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
    return f"{similarity_text(match)}  {_short(match)}".rstrip()


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
    # The size is shown on its own, unless it is all that differs.
    relation = evidence_text(match, with_size=match.evidence == "scaled")
    similarity = similarity_text(match)
    if relation:
        first = tr("{evidence}, similarity {similarity}").format(evidence=relation, similarity=similarity)
    else:
        first = tr("Similarity {similarity}").format(similarity=similarity)
    return [first, _size(match)]


def tooltip(match: Any) -> str:
    """Return the tooltip of a match, with all that has no room below its picture.

    Parameters
    ----------
    match : SHAPEGOOGLE_PG_match

    Returns
    -------
    text : str
    """
    where = match.source or match.name
    if match.object_name:
        where = tr("{name} in {path}").format(name=match.object_name, path=match.source)
    lines = [where]
    if match.title and match.title != match.object_name:
        lines.insert(0, match.title)
    what = [tr(TYPES.get(match.shape_type, match.shape_type))] if match.shape_type else []
    if match.placement_count > 1:
        what.append(counted("shown {count:,} time", "shown {count:,} times", match.placement_count))
    if match.frame:
        what.append(tr("frame {frame}").format(frame=match.frame))
    if match.catalog:
        what.append(tr("catalog {catalog}").format(catalog=match.catalog))
    if match.tags:
        what.append(tr("tags {tags}").format(tags=match.tags))
    if what:
        lines.append(", ".join(what))
    figures = [tr("Similarity {value:.3f}").format(value=match.similarity)]
    if match.likeness >= 0:
        figures.append(tr("likeness {value:.2f}").format(value=match.likeness))
    figures.append(tr("distance {value:.4f}").format(value=match.distance))
    lines += [evidence_text(match), ", ".join(figures), _size(match)]
    return "\n".join(line for line in lines if line)


def _size(match: Any) -> str:
    return counted(
        "{count:,} vertex, size ×{size:.3g}",
        "{count:,} vertices, size ×{size:.3g}",
        match.vertex_count,
        size=match.size,
    )


def one_line(match: Any) -> str:
    """Return what matters of a match in a line, the place of its file last: that may be long.

    Parameters
    ----------
    match : SHAPEGOOGLE_PG_match

    Returns
    -------
    text : str
    """
    parts = [title(match), below_picture(match), f"×{match.size:.3g}", match.tags, match.source]
    return "  ·  ".join(part for part in parts if part)


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
    """Keep evidence in a match.

    Parameters
    ----------
    match : SHAPEGOOGLE_PG_match
    evidence : Evidence or None
        None if the match cannot be compared: it shows only its similarity.
    """
    match.evidence = "" if evidence is None else evidence.kind
    match.share = -1.0 if evidence is None or evidence.share is None else evidence.share


def evidence_text(match: Any, *, with_size: bool = True) -> str:
    """Return the evidence of a match in words.

    Parameters
    ----------
    match : SHAPEGOOGLE_PG_match
    with_size : bool, optional
        Whether to add the size relative to the query, where it differs.

    Returns
    -------
    text : str
        Such as "Re-posed ×0.978"; empty without evidence.
    """
    if match.evidence in _STATES:
        return tr(_STATES[match.evidence])
    text = tr(KINDS.get(match.evidence, match.evidence))
    if match.share >= 0 and match.evidence == "part of":
        text = tr("The query is {share:.0f} % of it").format(share=100 * match.share)
    elif match.share >= 0:
        text = tr("{share:.0f} % of the query").format(share=100 * match.share)
    differs = match.evidence not in _WITHOUT_SIZE and abs(match.size - 1) > _SHOWN_FACTOR
    return f"{text} ×{match.size:.3g}" if with_size and differs and text else text


def _short(match: Any) -> str:
    """Return the evidence in words for the width of a picture."""
    if match.evidence == "part of" and match.share >= 0:
        return tr("{share:.0f} % of it").format(share=100 * match.share)
    if match.evidence == "nothing in common":
        return tr("Unlike")
    return evidence_text(match, with_size=match.evidence == "scaled")

# SPDX-License-Identifier: MIT
"""Texts that show results to people; programs read the values instead."""

from __future__ import annotations

from shapegoogle_core.library.evidence import Evidence

__all__ = ["evidence_text"]

# Factors of the size that are shown: below this the two sizes look the same.
_SHOWN_FACTOR = 0.02
# Kinds of two different surfaces, whose sizes say nothing.
_WITHOUT_SIZE = ("similar", "same kind", "nothing in common")


def evidence_text(evidence: Evidence | None) -> str:
    """Describe evidence in a few words.

    Parameters
    ----------
    evidence : Evidence or None

    Returns
    -------
    text : str
        Such as "scaled ×2.54" or "49 % of the query"; empty without evidence.

    Examples
    --------
    >>> from shapegoogle_core.library.evidence import Evidence
    >>> evidence_text(Evidence("contains", factor=1.0, share=0.49))
    '49 % of the query'
    """
    if evidence is None:
        return ""
    text: str = evidence.kind
    if evidence.share is not None:
        share = f"{100 * evidence.share:.0f} %"
        text = f"the query is {share} of it" if evidence.kind == "part of" else f"{share} of the query"
    if evidence.kind not in _WITHOUT_SIZE and abs(evidence.factor - 1) > _SHOWN_FACTOR:
        text += f" ×{evidence.factor:.3g}"
    return text

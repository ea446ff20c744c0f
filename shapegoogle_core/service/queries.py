# SPDX-License-Identifier: MIT
"""Searches of the service: pages of one answer that stays the same while somebody looks through it.

The matches that were found are kept in the spool, which all processes share. The first page is the answer of
`Library.query`. When more matches are wanted than are known, a longer search appends those that are new.
"""

from __future__ import annotations

import base64
import binascii
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.origin import Origin
from shapegoogle_core.library.storage.signature_file import signature_from_bytes
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.service.contents import Example, QueryRequest
from shapegoogle_core.service.records import filter_from, match_record
from shapegoogle_core.service.settings import ServiceError, short_name
from shapegoogle_core.service.spool import Spool
from shapegoogle_core.service.uploads import Uploads

__all__ = ["Queries", "known_shape"]

MOST_MATCHES = 1_000
"""Matches that can be looked through; further ones have nothing in common with the query."""

_PART = "query.json"
# What a match is made of again; its alignment is computed again where evidence is wanted.
_KEPT = tuple(
    field.name
    for field in fields(Match)
    if field.name not in ("placement", "evidence", "alignment", "aligned_sample", "bent_distance", "origin")
)


@dataclass
class _Answer:
    """The matches that are known: what they are made of, and as they are shown once they were explained."""

    request: QueryRequest
    matches: list[dict[str, Any]]
    shown: list[dict[str, Any] | None]
    complete: bool

    @classmethod
    def read(cls, content: bytes) -> _Answer:
        record = json.loads(content)
        return cls(
            QueryRequest.model_validate(record["request"]),
            record["matches"],
            record["shown"],
            record["complete"],
        )

    def to_bytes(self) -> bytes:
        return json.dumps(
            {
                "request": self.request.model_dump(),
                "matches": self.matches,
                "shown": self.shown,
                "complete": self.complete,
            }
        ).encode()

    def append(self, matches: Sequence[Match]) -> None:
        known = {match["shape_id"] for match in self.matches}
        new = [match for match in matches if match.shape_id not in known]
        self.matches += [
            {name: getattr(match, name) for name in _KEPT} | {"origin": asdict(match.origin)} for match in new
        ]
        self.shown += [None] * len(new)


class Queries:
    """Runs searches, and returns pages of their answers.

    Parameters
    ----------
    spool : Spool
    uploads : Uploads
    """

    def __init__(self, spool: Spool, uploads: Uploads) -> None:
        self._spool = spool
        self._uploads = uploads

    def start(self, library: Library, request: QueryRequest) -> dict[str, Any]:
        """Run a search and return the first page of its answer.

        Parameters
        ----------
        library : Library
        request : QueryRequest

        Returns
        -------
        page : dict
            For `AnswerPage`.

        Raises
        ------
        ServiceError
            404 for an unknown shape or upload, 422 if the search cannot be run.
        """
        # It must not depend on what is kept of another search.
        own = {name: [self._earlier(one) for one in getattr(request, name)] for name in ("like", "unlike")}
        answer = _Answer(request.model_copy(update=own), [], [], complete=False)
        matches = self._search(library, answer.request, request.limit, request.evidence)
        answer.append(matches)
        answer.complete = len(matches) < request.limit
        answer.shown[: request.evidence] = self.shown(library, matches[: request.evidence])
        return self._page(library, self._spool.new_name(), answer, 0, request.limit, 0)

    def page(self, library: Library, name: str, offset: int, limit: int, evidence: int) -> dict[str, Any]:
        """Return a page of the answer to an earlier search.

        Parameters
        ----------
        library : Library
        name : str
            As a client sent it.
        offset, limit : int
        evidence : int
            Number of matches of the page whose surfaces are compared, if they were not yet.

        Returns
        -------
        page : dict
            For `AnswerPage`.

        Raises
        ------
        ServiceError
            404 if the search is not known any more.
        """
        answer = _Answer.read(self._spool.get(name, _PART))
        wanted = min(offset + limit, MOST_MATCHES)
        if wanted > len(answer.matches) and not answer.complete:
            top = min(max(wanted, 2 * len(answer.matches)), MOST_MATCHES)
            found = self._search(library, answer.request, top, 0)
            answer.append(found)
            answer.complete = len(found) < top or top == MOST_MATCHES
        return self._page(library, name, answer, offset, limit, evidence)

    def versions(self, library: Library, name: str, shape_id: int) -> dict[str, Any]:
        """Return the family of a match of a search with ``families``.

        Parameters
        ----------
        library : Library
        name : str
            As a client sent it.
        shape_id : int
            Of the match.

        Returns
        -------
        page : dict
            For `AnswerPage`; there are no further pages.

        Raises
        ------
        ServiceError
            404 if the search is not known any more, or did not find this shape.
        """
        answer = _Answer.read(self._spool.get(name, _PART))
        for record in answer.matches:
            if record["shape_id"] == shape_id:
                examples = self.signatures(library, answer.request.like)
                found = library.versions(examples, _match(record), explain=len(record["version_ids"]) + 1)
                return {
                    "query": name,
                    "offset": 0,
                    "matches": self.shown(library, found),
                    "next": None,
                    "shapes": len(library),
                }
        raise ServiceError(404, f"this search has not found shape {shape_id}")

    def signature(self, library: Library, example: Example) -> ShapeSignature:
        """Return the signature of an example.

        Parameters
        ----------
        library : Library
        example : Example

        Returns
        -------
        signature : ShapeSignature

        Raises
        ------
        ServiceError
            404 for an unknown shape, upload or search, 422 for a signature that cannot be used.
        """
        if example.shape_id is not None:
            known_shape(library, example.shape_id)
            return library.signature(example.shape_id)
        if example.upload is not None:
            return self._uploads.signature(library, example.upload, example.index)
        if example.query is not None:
            return self.signature(library, self._earlier(example))
        try:
            content = base64.b64decode(example.signature or "", validate=True)
            return signature_from_bytes(content, library.model, short_name(library.name))
        except binascii.Error as error:
            raise ServiceError(422, "the signature is not base64; encode its bytes again") from error
        except (ValueError, LibraryError) as error:
            raise ServiceError(422, str(error)) from error

    def signatures(self, library: Library, examples: Sequence[Example]) -> list[ShapeSignature]:
        """Return the signatures of several examples, see `signature`."""
        return [self.signature(library, example) for example in examples]

    def _earlier(self, example: Example) -> Example:
        """Return what an example of an earlier search was; others as they are."""
        if example.query is None:
            return example
        earlier = _Answer.read(self._spool.get(example.query, _PART)).request.like
        if example.index >= len(earlier):
            raise ServiceError(404, f"this search has no example {example.index}; search again")
        return earlier[example.index]

    def _search(self, library: Library, request: QueryRequest, top: int, evidence: int) -> list[Match]:
        where = filter_from(request.where, library)
        if where is not None and where.kind is not None and library.model.settings.sample is None:
            raise ServiceError(422, "this library keeps no samples to find a kind with; leave the kind out")
        return library.query(
            self.signatures(library, request.like),
            top=top,
            explain=min(evidence, top),
            unlike=self.signatures(library, request.unlike),
            where=where,
            families=request.families,
            rank=request.rank,
        )

    def _page(
        self, library: Library, name: str, answer: _Answer, offset: int, limit: int, evidence: int
    ) -> dict[str, Any]:
        positions = range(len(answer.matches))[offset : offset + limit]
        missing = [position for position in positions[:evidence] if answer.shown[position] is None]
        if missing:
            examples = self.signatures(library, answer.request.like)
            where = filter_from(answer.request.where, library)
            matches = [_match(answer.matches[position]) for position in missing]
            explained = library.explain(examples, matches, len(matches), where=where)
            for position, shown in zip(missing, self.shown(library, explained), strict=True):
                answer.shown[position] = shown
        self._spool.put(name, _PART, answer.to_bytes())
        others = [position for position in positions if answer.shown[position] is None]
        unexplained = self.shown(library, [_match(answer.matches[position]) for position in others])
        records = dict(zip(others, unexplained, strict=True))
        shown_here = [answer.shown[position] or records[position] for position in positions]
        end = offset + limit
        more = end < len(answer.matches) or (not answer.complete and end < MOST_MATCHES)
        return {
            "query": name,
            "offset": offset,
            "matches": shown_here,
            "next": end if more else None,
            "shapes": len(library),
        }

    def shown(self, library: Library, matches: Sequence[Match]) -> list[dict[str, Any]]:
        """Return matches for `MatchRecord`, with the tags that their shapes have now."""
        roots = library.roots(counted=False)
        # Without those that another program has removed since.
        tags = {record.shape_id: record.tags for record in library.records([m.shape_id for m in matches])}
        return [match_record(match, tags.get(match.shape_id, ()), roots) for match in matches]


def known_shape(library: Library, shape_id: int) -> None:
    """Make sure that there is a shape.

    Parameters
    ----------
    library : Library
    shape_id : int

    Raises
    ------
    ServiceError
        404 if there is none.
    """
    if not library.has_shape(shape_id):
        raise ServiceError(
            404, f"the library has no shape {shape_id}; it was removed or replaced: search again"
        )


def _match(record: dict[str, Any]) -> Match:
    lists = {"version_ids": tuple(record["version_ids"]), "tags": tuple(record["tags"])}
    return Match(**{**record, **lists, "origin": Origin(**record["origin"])})

# SPDX-License-Identifier: MIT
"""What all addresses share: the parts of the running service, and the errors they may answer with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from fastapi import Path, Query, Request

from shapegoogle_core.service.contents import ErrorAnswer
from shapegoogle_core.service.library_lanes import LibraryLanes
from shapegoogle_core.service.long_answers import LongAnswers
from shapegoogle_core.service.queries import Queries
from shapegoogle_core.service.settings import ServiceSettings
from shapegoogle_core.service.spool import Spool
from shapegoogle_core.service.uploads import Uploads

__all__ = ["ERRORS", "Limit", "Offset", "Parts", "ShapeNumber", "SpoolName", "parts_of"]

ERRORS: dict[int | str, dict[str, Any]] = {
    status: {"model": ErrorAnswer, "description": description}
    for status, description in (
        (400, "The request is not valid."),
        (401, "A token is needed."),
        (403, "The token does not allow this."),
        (404, "There is no such thing (any more)."),
        (408, "The request arrived too slowly."),
        (413, "The request is too large."),
        (422, "The request cannot be understood, or the mesh cannot be read."),
        (429, "Too many requests."),
        (500, "A fault in the service."),
        (503, "The service is busy, or its library cannot be read."),
        (504, "The answer took too long."),
    )
}
"""Answers that every address may give besides its own."""

ShapeNumber = Annotated[int, Path(ge=1, le=2**62)]
SpoolName = Annotated[str, Path(max_length=64)]
Offset = Annotated[int, Query(ge=0, le=100_000)]
Limit = Annotated[int, Query(ge=1, le=100)]


@dataclass(frozen=True)
class Parts:
    """The parts of the running service.

    Attributes
    ----------
    settings : ServiceSettings
    lanes : LibraryLanes
    spool : Spool
    uploads : Uploads
    queries : Queries
    long_answers : LongAnswers
    """

    settings: ServiceSettings
    lanes: LibraryLanes
    spool: Spool
    uploads: Uploads
    queries: Queries
    long_answers: LongAnswers


def parts_of(request: Request) -> Parts:
    """Return the parts of the service that answers a request."""
    parts: Parts = request.app.state.parts
    return parts

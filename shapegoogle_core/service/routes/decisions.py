# SPDX-License-Identifier: MIT
"""Decisions and tags."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Depends, Path, Request

from shapegoogle_core.library.decisions.decision import Decision, ShapeKey
from shapegoogle_core.library.library import Library
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.service.access import Client, reader, writer
from shapegoogle_core.service.contents import DecisionList, DecisionRecord, NewDecision
from shapegoogle_core.service.queries import known_shape
from shapegoogle_core.service.records import source_from
from shapegoogle_core.service.routes.shared import ERRORS, parts_of
from shapegoogle_core.service.settings import ServiceError

__all__ = ["router"]

router = APIRouter(prefix="/api", responses=ERRORS, tags=["decisions"])


@router.get("/decisions", dependencies=[Depends(reader)])
async def list_decisions(request: Request) -> DecisionList:
    """List what was decided about shapes of the library, oldest first."""
    made = await parts_of(request).lanes.run("read", lambda library: library.decisions())
    return DecisionList.model_validate({"decisions": [_record(decision) for decision in made]})


@router.post("/decisions")
async def decide(
    request: Request, new: NewDecision, client: Annotated[Client, Depends(writer)]
) -> DecisionRecord:
    """Remember a decision; later searches and lists of duplicates follow it."""
    parts = parts_of(request)
    # With tokens nobody decides in the name of somebody else.
    author = client.name or new.author

    def decided(library: Library) -> Decision:
        if new.other is not None:
            known_shape(library, new.other)
        shape: int | ShapeSignature
        if new.shape.shape_id is None:
            shape = parts.queries.signature(library, new.shape)
        else:
            known_shape(library, new.shape.shape_id)
            shape = new.shape.shape_id
        try:
            source = "" if new.source is None else source_from(new.source, library.roots(counted=False))
            about = {"name": new.name, "source": source} if new.shape.shape_id is None else {}
            return library.decide(new.kind, shape, new.other, tag=new.tag, author=author, **about)
        except ValueError as error:
            raise ServiceError(422, str(error)) from error

    return DecisionRecord.model_validate(_record(await parts.lanes.write(decided)))


@router.delete("/decisions/{number}", dependencies=[Depends(writer)])
async def undo(request: Request, number: Annotated[int, Path(ge=1, le=2**62)]) -> DecisionRecord:
    """Take a decision back."""

    def undone(library: Library) -> Decision:
        if all(decision.number != number for decision in library.decisions()):
            raise ServiceError(404, f"there is no decision {number}; it was undone already")
        return library.undo(number)

    return DecisionRecord.model_validate(_record(await parts_of(request).lanes.write(undone)))


def _record(decision: Decision) -> dict[str, Any]:
    return {
        **decision.to_json(),
        "shape": _key(decision.shape),
        "other": None if decision.other is None else _key(decision.other),
        "sentence": decision.sentence,
    }


def _key(key: ShapeKey) -> dict[str, str]:
    return {**key.to_json(), "fingerprint": key.fingerprint}

# SPDX-License-Identifier: MIT
"""What programs such as `shapegoogle_core.ServiceLibrary` ask for besides what the web page needs."""

from __future__ import annotations

import base64
from typing import Any

from fastapi import APIRouter, Depends, Request, Response

from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.signature_file import signature_to_bytes
from shapegoogle_core.service.access import reader, searcher
from shapegoogle_core.service.contents import ShapeList
from shapegoogle_core.service.program_contents import (
    ComparisonAnswer,
    ComparisonRequest,
    ListRequest,
    PictureAnswer,
    PlacementAnswer,
    ShapesRequest,
    SuggestionAnswer,
    SuggestionRequest,
)
from shapegoogle_core.service.queries import known_shape
from shapegoogle_core.service.records import filter_from, shape_record
from shapegoogle_core.service.routes.shared import ERRORS, ShapeNumber, parts_of

__all__ = ["router"]

router = APIRouter(prefix="/api", responses=ERRORS, tags=["programs"])


@router.post("/comparisons", dependencies=[Depends(searcher)])
async def compare(request: Request, asked: ComparisonRequest) -> ComparisonAnswer:
    """Compare a query with certain shapes, such as the matches of a search or the versions of one of them."""
    queries = parts_of(request).queries

    def compared(library: Library) -> dict[str, Any]:
        matches = library.compare_with(
            queries.signatures(library, asked.like),
            asked.shape_ids,
            explain=asked.evidence,
            where=filter_from(asked.where, library),
        )
        return {"matches": queries.shown(library, matches)}

    return ComparisonAnswer.model_validate(await parts_of(request).lanes.run("search", compared))


@router.post("/suggestions", dependencies=[Depends(searcher)])
async def suggest(request: Request, asked: SuggestionRequest) -> SuggestionAnswer:
    """Suggest tags, catalogs, folders and name words: those of the nearest relatives of a shape."""
    queries = parts_of(request).queries

    def suggested(library: Library) -> dict[str, Any]:
        if asked.shape.shape_id is not None:
            known_shape(library, asked.shape.shape_id)
        own = asked.shape.shape_id
        shape = queries.signature(library, asked.shape) if own is None else own
        where = filter_from(asked.where, library)
        found = library.suggest(shape, relatives=asked.relatives, where=where)
        return {"suggestions": [suggestion.to_json() for suggestion in found]}

    return SuggestionAnswer.model_validate(await parts_of(request).lanes.run("search", suggested))


@router.post("/shapes", dependencies=[Depends(reader)])
async def list_some_shapes(request: Request, asked: ListRequest) -> ShapeList:
    """List shapes by their numbers, or those that meet conditions."""

    def listed(library: Library) -> dict[str, Any]:
        roots = library.roots(counted=False)
        if asked.shape_ids is not None:
            shapes = library.records(asked.shape_ids)
            return {"shapes": [shape_record(shape, roots) for shape in shapes], "next": None}
        where = filter_from(asked.where, library)
        shapes = library.find(where, after=asked.after, limit=asked.limit + 1)
        more = len(shapes) > asked.limit
        shapes = shapes[: asked.limit]
        return {
            "shapes": [shape_record(shape, roots) for shape in shapes],
            "next": shapes[-1].shape_id if more else None,
        }

    return ShapeList.model_validate(await parts_of(request).lanes.run("read", listed))


@router.post("/thumbnails", dependencies=[Depends(reader)])
async def show_thumbnails(request: Request, asked: ShapesRequest) -> PictureAnswer:
    """Return the pictures of several shapes at once."""

    def found(library: Library) -> dict[int, str]:
        pictures = library.thumbnails(asked.shape_ids)
        return {number: base64.b64encode(picture).decode() for number, picture in pictures.items()}

    return PictureAnswer(pictures=await parts_of(request).lanes.run("read", found))


@router.post("/placements", dependencies=[Depends(reader)])
async def show_placements(request: Request, asked: ShapesRequest) -> PlacementAnswer:
    """Return the objects that show shapes, and where they are in their files."""

    def found(library: Library) -> dict[int, list[dict[str, Any]]]:
        known = [record.shape_id for record in library.records(asked.shape_ids)]
        return {
            number: [
                {
                    "object_name": placement.object_name,
                    "matrix": placement.matrix.ravel().tolist(),
                    "extents": placement.extents,
                }
                for placement in library.placements(number)
            ]
            for number in known
        }

    placements = await parts_of(request).lanes.run("read", found)
    return PlacementAnswer.model_validate({"placements": placements})


@router.get("/shapes/{shape_id}/signature", dependencies=[Depends(reader)], response_class=Response)
async def show_signature(request: Request, shape_id: ShapeNumber) -> Response:
    """Return the signature of a shape, as `signature_from_bytes` reads it with the library's model."""

    def found(library: Library) -> bytes:
        known_shape(library, shape_id)
        return signature_to_bytes(library.signature(shape_id))

    content = await parts_of(request).lanes.run("read", found)
    return Response(content, media_type="application/octet-stream")

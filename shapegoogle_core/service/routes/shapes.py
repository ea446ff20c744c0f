# SPDX-License-Identifier: MIT
"""Shapes of the library: list, record, picture, preview, file; duplicates and the map."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request, Response
from fastapi.responses import FileResponse

from shapegoogle_core.library.duplicates.groups import DuplicateGroup
from shapegoogle_core.library.duplicates.settings import MIN_SIMILARITY
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.library import Library
from shapegoogle_core.rendering import preview_of_points
from shapegoogle_core.rendering.library_map import lay_out
from shapegoogle_core.service.access import reader
from shapegoogle_core.service.contents import DuplicateList, LibraryMap, ShapeDetails, ShapeList
from shapegoogle_core.service.queries import known_shape
from shapegoogle_core.service.records import duplicate_record, shape_record
from shapegoogle_core.service.routes.shared import ERRORS, Limit, Offset, ShapeNumber, parts_of
from shapegoogle_core.service.settings import ServiceError

__all__ = ["router"]

router = APIRouter(prefix="/api", responses=ERRORS, tags=["shapes"], dependencies=[Depends(reader)])

LeastSimilarity = Annotated[
    float, Query(ge=0.5, le=1, description="Of a similar shape to the first of its group; rounded to 0.01.")
]

# A number never means another shape, so that a browser need not ask again for a while.
_KEEP = {"Cache-Control": "private, max-age=600"}


@router.get("/shapes")
async def list_shapes(
    request: Request,
    search: Annotated[str, Query(max_length=200, description="In the name or the path.")] = "",
    tag: Annotated[str, Query(max_length=200)] = "",
    after: Annotated[int, Query(ge=0, le=2**62)] = 0,
    limit: Limit = 50,
) -> ShapeList:
    """List shapes of the library in the order of their numbers."""

    def listed(library: Library) -> ShapeList:
        where = Filter(text=search if search.strip() else None, tag=tag if tag.strip() else None)
        shapes = library.find(where, after=after, limit=limit + 1)
        roots = library.roots(counted=False)
        return ShapeList.model_validate(
            {
                "shapes": [shape_record(shape, roots) for shape in shapes[:limit]],
                "next": shapes[limit - 1].shape_id if len(shapes) > limit else None,
            }
        )

    return await parts_of(request).lanes.run("read", listed)


@router.get("/shapes/{shape_id}")
async def show_shape(request: Request, shape_id: ShapeNumber) -> ShapeDetails:
    """Return the record of a shape."""

    def found(library: Library) -> ShapeDetails:
        known_shape(library, shape_id)
        return ShapeDetails.model_validate(
            shape_record(library.shape(shape_id), library.roots(counted=False))
        )

    return await parts_of(request).lanes.run("read", found)


@router.get("/shapes/{shape_id}/thumbnail", response_class=Response)
async def show_thumbnail(request: Request, shape_id: ShapeNumber) -> Response:
    """Return the picture of a shape as PNG."""

    def found(library: Library) -> bytes | None:
        known_shape(library, shape_id)
        return library.thumbnail(shape_id)

    picture = await parts_of(request).lanes.run("read", found)
    if picture is None:
        raise ServiceError(404, f"shape {shape_id} has no picture")
    return Response(picture, media_type="image/png", headers=_KEEP)


@router.get("/shapes/{shape_id}/preview", response_class=Response)
async def show_preview(request: Request, shape_id: ShapeNumber) -> Response:
    """Return a small mesh of a shape, to show it; of a shape without one its sample of points."""

    def found(library: Library) -> bytes | None:
        known_shape(library, shape_id)
        preview = library.preview(shape_id)
        if preview is not None:
            return preview
        sample = library.signature(shape_id).sample
        return None if sample is None else preview_of_points(sample.center + sample.unit * sample.points)

    preview = await parts_of(request).lanes.run("read", found)
    if preview is None:
        raise ServiceError(404, f"nothing of shape {shape_id} can be shown; index its file again")
    return Response(preview, media_type="application/octet-stream", headers=_KEEP)


@router.get("/shapes/{shape_id}/file", response_class=FileResponse)
async def download(request: Request, shape_id: ShapeNumber) -> Response:
    """Download the file that a shape comes from, where the service allows it."""
    parts = parts_of(request)
    if not parts.settings.allow_download:
        raise ServiceError(403, "this service does not allow downloads")

    def found(library: Library) -> str:
        known_shape(library, shape_id)
        record = library.source_of(shape_id)
        # Only an indexed file: a label is any text, and could name any file.
        if record is None or record.size is None or not record.root:
            raise ServiceError(404, f"shape {shape_id} comes from no indexed file")
        return record.path

    path = Path(await parts.lanes.run("read", found))
    if not await asyncio.to_thread(path.is_file):
        raise ServiceError(404, f"the file {path.name!r} is not there any more")
    return FileResponse(path, filename=path.name, media_type="application/octet-stream")


@router.get("/duplicates")
async def list_duplicates(
    request: Request, offset: Offset = 0, limit: Limit = 20, min_similarity: LeastSimilarity = MIN_SIMILARITY
) -> DuplicateList:
    """List groups of shapes of which one would be enough, the largest saving first."""
    parts = parts_of(request)
    # Each is computed once, so that there are not too many.
    least = round(min_similarity, 2)
    groups: list[DuplicateGroup] | None = await parts.long_answers.get(
        f"duplicates {least}", lambda library: library.duplicates(least)
    )
    if groups is None:
        return DuplicateList(ready=False, total=0, offset=0, groups=[], next=None)
    roots = await parts.lanes.run("read", lambda library: library.roots(counted=False))
    end = offset + limit
    return DuplicateList.model_validate(
        {
            "ready": True,
            "total": len(groups),
            "offset": offset,
            "groups": [duplicate_record(group, roots) for group in groups[offset:end]],
            "next": end if end < len(groups) else None,
        }
    )


@router.get("/map")
async def show_map(request: Request) -> LibraryMap:
    """Lay out the shapes in the plane so that those that are alike are near."""
    found = await parts_of(request).long_answers.get("map", lay_out)
    if found is None:
        return LibraryMap(ready=False, total=0, points=[])
    total, points = found
    return LibraryMap.model_validate(
        {
            "ready": True,
            "total": total,
            "points": [
                {"shape_id": point.shape_id, "name": point.name, "x": point.x, "y": point.y}
                for point in points
            ],
        }
    )

# SPDX-License-Identifier: MIT
"""Uploads, searches, and the pages of their answers."""

from __future__ import annotations

import asyncio
import shutil
from pathlib import Path
from tempfile import mkdtemp
from typing import Annotated, Any, BinaryIO

from fastapi import APIRouter, Depends, File, Query, Request, Response, UploadFile
from fastapi import Path as PathParameter

from shapegoogle_core.service.access import reader, searcher
from shapegoogle_core.service.contents import AnswerPage, QueryRequest, UploadAnswer
from shapegoogle_core.service.routes.shared import ERRORS, Limit, Offset, ShapeNumber, SpoolName, parts_of
from shapegoogle_core.service.uploads import safe_name

__all__ = ["router"]

UploadIndex = Annotated[int, PathParameter(ge=0, le=99)]

router = APIRouter(prefix="/api", responses=ERRORS, tags=["search"])


@router.post("/uploads", dependencies=[Depends(searcher)])
async def upload(
    request: Request, file: Annotated[UploadFile, File(description="A mesh file.")]
) -> UploadAnswer:
    """Read a mesh file and describe its shapes, to search with them for the next two hours."""
    parts = parts_of(request)
    folder = Path(mkdtemp(dir=parts.uploads.folder))
    path = folder / safe_name(file.filename or "")
    try:
        await asyncio.to_thread(_copy, file.file, path)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    name, uploaded = await parts.uploads.describe(path)
    return UploadAnswer.model_validate(
        {
            "upload": name,
            "shapes": [
                {
                    "index": index,
                    "name": shape.name,
                    "object_name": shape.object_name,
                    "vertices": shape.signature.vertex_count,
                    "faces": shape.signature.face_count,
                    "area": shape.signature.area,
                }
                for index, shape in enumerate(uploaded.shapes)
            ],
            "problems": list(uploaded.problems),
        }
    )


@router.get("/uploads/{name}/{index}/thumbnail", dependencies=[Depends(reader)], response_class=Response)
def upload_thumbnail(request: Request, name: SpoolName, index: UploadIndex) -> Response:
    """Return the picture of a shape of an upload as PNG."""
    return Response(parts_of(request).spool.get(name, f"{index}.png"), media_type="image/png")


@router.get("/uploads/{name}/{index}/preview", dependencies=[Depends(reader)], response_class=Response)
def upload_preview(request: Request, name: SpoolName, index: UploadIndex) -> Response:
    """Return a small mesh of a shape of an upload, to show it."""
    content = parts_of(request).spool.get(name, f"{index}.preview")
    return Response(content, media_type="application/octet-stream")


@router.post("/queries", dependencies=[Depends(searcher)])
async def search(request: Request, query: QueryRequest) -> AnswerPage:
    """Search, and return the first page of the answer."""
    parts = parts_of(request)
    page: dict[str, Any] = await parts.lanes.run(
        "search", lambda library: parts.queries.start(library, query)
    )
    return AnswerPage.model_validate(page)


@router.get("/queries/{name}", dependencies=[Depends(searcher)])
async def page_of_search(
    request: Request,
    name: SpoolName,
    offset: Offset = 0,
    limit: Limit = 24,
    evidence: Annotated[int, Query(ge=0, le=100)] = 0,
) -> AnswerPage:
    """Return a page of the answer to an earlier search."""
    parts = parts_of(request)
    page = await parts.lanes.run(
        "search", lambda library: parts.queries.page(library, name, offset, limit, evidence)
    )
    return AnswerPage.model_validate(page)


@router.get("/queries/{name}/versions/{shape_id}", dependencies=[Depends(searcher)])
async def versions_of_match(request: Request, name: SpoolName, shape_id: ShapeNumber) -> AnswerPage:
    """Return the family of a match of a search with `families`: its copies and versions."""
    parts = parts_of(request)
    page = await parts.lanes.run("search", lambda library: parts.queries.versions(library, name, shape_id))
    return AnswerPage.model_validate(page)


def _copy(content: BinaryIO, path: Path) -> None:
    with path.open("wb") as file:
        shutil.copyfileobj(content, file)

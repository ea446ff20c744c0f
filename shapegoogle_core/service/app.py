# SPDX-License-Identifier: MIT
"""The application of the service, which a server such as uvicorn runs in each of its processes."""

from __future__ import annotations

import logging
import multiprocessing
import os
import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from multiprocessing.process import BaseProcess
from pathlib import Path

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException
from starlette.staticfiles import StaticFiles

from shapegoogle_core import __version__
from shapegoogle_core.errors import LibraryError, MeshError, ShapeGoogleError
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.address import shown_place
from shapegoogle_core.service.access import TOKENS_UNREADABLE, Access
from shapegoogle_core.service.library_lanes import LibraryLanes
from shapegoogle_core.service.limits import Limits
from shapegoogle_core.service.long_answers import LongAnswers
from shapegoogle_core.service.queries import Queries
from shapegoogle_core.service.routes import about, decisions, programs, searching, shapes
from shapegoogle_core.service.routes.shared import Parts
from shapegoogle_core.service.settings import ServiceError, ServiceSettings, short_name
from shapegoogle_core.service.spool import Spool
from shapegoogle_core.service.tokens import TokenError
from shapegoogle_core.service.uploads import Uploads

__all__ = ["make_app", "process_app"]

PAGE = Path(__file__).parent / "page"

_LOG = logging.getLogger("shapegoogle.service")
# Errors of the framework, in words of this program.
_SENTENCES = {
    400: "the request is not valid; see /api/openapi.json",
    404: "there is nothing at this address; see /api/openapi.json",
    405: "this address does not take such requests; see /api/openapi.json",
}


def make_app(settings: ServiceSettings) -> FastAPI:
    """Make the application of a service.

    Parameters
    ----------
    settings : ServiceSettings

    Returns
    -------
    app : FastAPI
        Opens the library when it starts.
    """

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        with Library.open(settings.library, read_only=True) as library:
            model = library.model
        spool, lanes = Spool(Path(settings.spool)), LibraryLanes(settings)
        uploads = Uploads(settings, spool, model)
        queries = Queries(spool, uploads)
        app.state.parts = Parts(settings, lanes, spool, uploads, queries, LongAnswers(lanes))
        try:
            yield
        finally:
            uploads.close()
            lanes.close()

    app = FastAPI(
        title="Shape Google",
        description='Search a library of 3D shapes by shape. Errors are `{"error": "one sentence"}`.',
        version=__version__,
        lifespan=lifespan,
        openapi_url="/api/openapi.json",
        # Their pages load scripts from the internet.
        docs_url=None,
        redoc_url=None,
    )
    access = app.state.access = Access(settings)
    for module in (about, searching, shapes, programs, decisions):
        app.include_router(module.router)
    app.mount("/", StaticFiles(directory=PAGE, html=True))
    app.add_exception_handler(RequestValidationError, _invalid)
    app.add_exception_handler(HTTPException, _refused)
    app.add_exception_handler(ShapeGoogleError, _failed)
    app.add_exception_handler(Exception, _unexpected)
    app.add_middleware(Limits, settings=settings, access=access)
    return app


def process_app() -> FastAPI:
    """Make the application of a process of the service, from the settings in its environment.

    Returns
    -------
    app : FastAPI
    """
    parent = multiprocessing.parent_process()
    if parent is not None:
        # A parent that is killed cannot end its processes, and they would go on listening.
        threading.Thread(target=_end_with, args=(parent,), daemon=True).start()
    return make_app(ServiceSettings.from_environment())


def _end_with(parent: BaseProcess) -> None:
    parent.join()
    os._exit(1)


def _answer(status: int, sentence: str, retry_after: int | None = None) -> JSONResponse:
    headers = {} if retry_after is None else {"Retry-After": str(retry_after)}
    if status == 401:
        headers["WWW-Authenticate"] = "Bearer"
    return JSONResponse({"error": sentence}, status, headers)


async def _failed(request: Request, error: Exception) -> JSONResponse:
    if isinstance(error, ServiceError):
        return _answer(error.status, str(error), error.retry_after)
    # The library's path is of no use to a client.
    settings: ServiceSettings = request.app.state.parts.settings
    if isinstance(error, TokenError):
        _LOG.error("%s", error)
        return _answer(500, TOKENS_UNREADABLE)
    sentence = str(error)
    for place in (settings.library, shown_place(settings.library)):
        sentence = sentence.replace(place, short_name(settings.library))
    if isinstance(error, MeshError):
        return _answer(422, sentence)
    _LOG.error("%s %s: %s", request.method, request.url.path, error)
    return _answer(503 if isinstance(error, LibraryError) else 500, sentence)


async def _refused(_request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, HTTPException)
    answer = _answer(error.status_code, _SENTENCES.get(error.status_code, str(error.detail)))
    answer.headers.update(error.headers or {})
    return answer


async def _invalid(_request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, RequestValidationError)
    first = error.errors()[0]
    place = ".".join(str(part) for part in first["loc"] if part not in ("body", "query", "path"))
    reason = str(first["msg"]).removeprefix("Value error, ")
    reason = f"{reason[:1].lower()}{reason[1:]}"
    return _answer(422, f"{place}: {reason}" if place else reason)


async def _unexpected(request: Request, error: Exception) -> JSONResponse:
    _LOG.error("%s %s failed", request.method, request.url.path, exc_info=error)
    return _answer(
        500,
        "the service failed because of a fault in Shape Google, not in the request; whoever runs it finds "
        "what to report in its log",
    )

# SPDX-License-Identifier: MIT
"""The service and its library: health, numbers, the model; sessions of the web page."""

from __future__ import annotations

import hashlib
from typing import Annotated
from weakref import WeakKeyDictionary

from fastapi import APIRouter, Depends, Request, Response
from fastapi.security import HTTPAuthorizationCredentials, HTTPBearer

from shapegoogle_core import __version__
from shapegoogle_core.client.versions import API_VERSION
from shapegoogle_core.library.library import Library
from shapegoogle_core.mesh import MESH_SUFFIXES
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.service.access import COOKIE, Access, reader
from shapegoogle_core.service.contents import Health, Info, NewSession, SessionState
from shapegoogle_core.service.routes.shared import ERRORS, parts_of
from shapegoogle_core.service.settings import ServiceError, short_name

__all__ = ["router"]

router = APIRouter(prefix="/api", responses=ERRORS, tags=["service"])

# Files of the models in use.
_MODELS: WeakKeyDictionary[ShapeModel, tuple[str, bytes]] = WeakKeyDictionary()
# Seconds that a browser keeps the token.
_SESSION_SECONDS = 30 * 24 * 3600


@router.get("/health")
async def health(request: Request) -> Health:
    """Say whether the service can read its library."""
    access: Access = request.app.state.access
    access.count("read", request)
    await parts_of(request).lanes.run("read", len)
    return Health(status="ok")


@router.get("/info", dependencies=[Depends(reader)])
async def info(request: Request) -> Info:
    """Return numbers of the library, and what the service offers."""
    settings = parts_of(request).settings

    def read(library: Library) -> Info:
        known = library.info()
        return Info.model_validate(
            {
                **{name: known[name] for name in ("shapes", "sources", "failed", "model", "model_name")},
                "without_views": known["without_views"],
                "model_hash": _model_file(library)[0],
                "library": short_name(library.name),
                "version": __version__,
                "api": API_VERSION,
                "roots": [root.name for root in library.roots(counted=False)],
                "allow_download": settings.allow_download,
                "max_upload": settings.max_upload * 2**20,
                "formats": sorted(MESH_SUFFIXES),
            }
        )

    return await parts_of(request).lanes.run("read", read)


@router.get("/model", dependencies=[Depends(reader)], response_class=Response)
async def model(request: Request) -> Response:
    """Return the model of the library as a file, for clients that describe meshes themselves."""
    content_hash, content = await parts_of(request).lanes.run("read", _model_file)
    tag = f'"{content_hash}"'
    if request.headers.get("if-none-match") == tag:
        return Response(status_code=304, headers={"ETag": tag})
    return Response(content, media_type="application/octet-stream", headers={"ETag": tag})


@router.get("/session")
async def session(
    request: Request,
    bearer: Annotated[HTTPAuthorizationCredentials | None, Depends(HTTPBearer(auto_error=False))],
) -> SessionState:
    """Say what the client may do, with its token or without."""
    access: Access = request.app.state.access
    access.check_origin(request)
    access.count("read", request)
    return _state(access, bearer.credentials if bearer is not None else request.cookies.get(COOKIE))


@router.post("/session")
async def sign_in(request: Request, response: Response, new: NewSession) -> SessionState:
    """Keep a token in a cookie that scripts of the page cannot read."""
    access: Access = request.app.state.access
    access.check_origin(request)
    access.count("search", request)
    state = _state(access, new.token)
    if state.scope == "none":
        raise ServiceError(401, "the token is not valid; ask whoever runs this service for one")
    if not access.needs_token:
        return state
    response.set_cookie(
        COOKIE,
        new.token,
        max_age=_SESSION_SECONDS,
        httponly=True,
        samesite="strict",
        secure=request.url.scheme == "https",
    )
    return state


@router.delete("/session")
async def sign_out(request: Request, response: Response) -> SessionState:
    """Forget the token."""
    access: Access = request.app.state.access
    access.check_origin(request)
    response.delete_cookie(COOKIE, httponly=True, samesite="strict")
    return _state(access, None)


def _model_file(library: Library) -> tuple[str, bytes]:
    """Return the model as a file, with its hash; writing it takes a second, so it is kept."""
    if library.model not in _MODELS:
        content = library.model.to_bytes()
        _MODELS[library.model] = hashlib.sha256(content).hexdigest(), content
    return _MODELS[library.model]


def _state(access: Access, text: str | None) -> SessionState:
    if not access.needs_token:
        return SessionState(needs_token=False, scope="write", name="")
    token = access.token(text)
    if token is None:
        return SessionState(needs_token=True, scope="none", name="")
    return SessionState(needs_token=True, scope=token.scope, name=token.name)

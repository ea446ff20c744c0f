# SPDX-License-Identifier: MIT
"""Limits of every request, before any of its content is looked at; and headers of every answer."""

from __future__ import annotations

import asyncio
import json
import logging
import time
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any

from starlette.exceptions import HTTPException
from starlette.requests import Request

from shapegoogle_core.service.access import TOKENS_UNREADABLE, Access
from shapegoogle_core.service.settings import ServiceError, ServiceSettings
from shapegoogle_core.service.tokens import TokenError

__all__ = ["Limits"]

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
Application = Callable[[MutableMapping[str, Any], Receive, Send], Awaitable[None]]

# Everything but an upload is JSON, with at most some signatures in it.
_MOST_JSON = 4 * 2**20
# A multipart body is a little longer than the file in it.
_ENVELOPE = 2**16
UPLOADS = "/api/uploads"
SESSION = "/api/session"

_LOG = logging.getLogger("shapegoogle.service")

_HEADERS = [
    # The page works without the internet, and nothing of it can be made to load or run something else.
    (
        b"content-security-policy",
        b"default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
        b"connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
    (b"cross-origin-resource-policy", b"same-origin"),
]


class _RefusedError(HTTPException):
    """A body that is refused; the framework lets such an error through while it reads a body."""

    def __init__(self, status: int, sentence: str, retry_after: int | None = None) -> None:
        super().__init__(status, sentence, None if retry_after is None else {"Retry-After": str(retry_after)})


class Limits:
    """An ASGI application around another one, which refuses bodies that are too large or too slow.

    The framework receives a body before it looks at the token, so those who have none are refused here: they
    must not fill the disk of the service.

    Parameters
    ----------
    app : callable
    settings : ServiceSettings
    access : Access
    """

    def __init__(self, app: Application, settings: ServiceSettings, access: Access) -> None:
        self._app = app
        self._settings = settings
        self._access = access

    async def __call__(self, scope: MutableMapping[str, Any], receive: Receive, send: Send) -> None:
        """Answer a request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        most = self._settings.max_upload * 2**20 if scope["path"] == UPLOADS else _MOST_JSON
        started = False

        async def answer(message: Message) -> None:
            nonlocal started
            if message["type"] == "http.response.start":
                started = True
                message["headers"] = [*message.get("headers", []), *_HEADERS]
            await send(message)

        try:
            await self._app(scope, self._limited(scope, receive, most), answer)
        except _RefusedError as refused:
            if started:
                raise
            body = json.dumps({"error": refused.detail}).encode()
            headers = [(b"content-type", b"application/json"), (b"connection", b"close")]
            await answer({"type": "http.response.start", "status": refused.status_code, "headers": headers})
            await answer({"type": "http.response.body", "body": body})

    def _check_sender(self, scope: MutableMapping[str, Any]) -> None:
        try:
            self._access.check_sender(Request(scope))
        except ServiceError as error:
            raise _RefusedError(error.status, str(error), error.retry_after) from error
        except TokenError as error:
            _LOG.error("%s", error)
            raise _RefusedError(500, TOKENS_UNREADABLE) from error

    def _limited(self, scope: MutableMapping[str, Any], receive: Receive, most: int) -> Receive:
        if scope["method"] in ("GET", "HEAD"):
            # Nobody reads their body. What is received is only that the client goes away, perhaps while a
            # file of the page is sent to it, for which no token is needed.
            return receive
        received = 0
        until = time.monotonic() + self._settings.upload_seconds
        complete = False
        checked = scope["path"] == SESSION  # which is there to send a token
        size = dict(scope["headers"]).get(b"content-length", b"0")
        claimed = int(size) if size.isdigit() else 0
        too_large = _RefusedError(
            413,
            f"the request has more than {most // 2**20:,} MB; simplify the mesh, or ask whoever runs this "
            "service for a higher limit",
        )

        async def limited() -> Message:
            nonlocal received, complete, checked
            if not checked:
                self._check_sender(scope)
                checked = True
            if claimed > most + _ENVELOPE:
                raise too_large
            if complete:  # what follows is only that the client goes away
                return await receive()
            try:
                message = await asyncio.wait_for(receive(), max(0.001, until - time.monotonic()))
            except TimeoutError as error:
                raise _RefusedError(
                    408,
                    f"the request did not arrive within {self._settings.upload_seconds:g} s; try again over "
                    "a faster connection",
                ) from error
            received += len(message.get("body", b""))
            complete = not message.get("more_body", False)
            if received > most + _ENVELOPE:
                raise too_large
            return message

        return limited

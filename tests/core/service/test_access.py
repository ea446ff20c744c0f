# SPDX-License-Identifier: MIT
"""Tokens, scopes, rates, sizes and slow clients."""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import trimesh
from fastapi.testclient import TestClient

import shapegoogle_core as sg
from shapegoogle_core.library.library import Library
from shapegoogle_core.service.access import Access
from shapegoogle_core.service.app import make_app
from shapegoogle_core.service.library_lanes import LibraryLanes
from shapegoogle_core.service.limits import Limits
from shapegoogle_core.service.lines import LibraryThread, Line
from shapegoogle_core.service.settings import ServiceError, ServiceSettings
from shapegoogle_core.service.spool import Spool
from shapegoogle_core.service.tokens import TokenError, TokenFile
from shapegoogle_core.service.uploads import Uploads

Serve = Callable[..., TestClient]
QUERY = {"like": [{"shape_id": 1}], "limit": 1, "evidence": 0}


def bearer(token: str) -> dict[str, str]:
    return {"Authorization": f"Bearer {token}"}


@pytest.fixture
def tokens(tmp_path: Path) -> TokenFile:
    return TokenFile(tmp_path / "tokens.json")


def test_tokens_have_scopes_and_can_be_revoked(serve: Serve, tokens: TokenFile, library_path: Path) -> None:
    reading, writing = tokens.create("ana", "read"), tokens.create("ben", "write")
    client = serve(token_file=str(tokens.path), library=str(library_path))
    decision = {"kind": "master", "shape": {"shape_id": 1}, "author": "somebody else"}
    assert client.get("/api/health").status_code == 200
    assert client.get("/api/info").status_code == 401
    assert client.get("/api/info", headers=bearer("sg_wrong")).status_code == 401
    assert client.post("/api/queries", json=QUERY, headers=bearer(reading)).status_code == 200
    refused = client.post("/api/decisions", json=decision, headers=bearer(reading))
    assert (refused.status_code, "reading only" in refused.json()["error"]) == (403, True)
    made = client.post("/api/decisions", json=decision, headers=bearer(writing))
    assert (made.status_code, made.json()["author"]) == (200, "ben")
    assert tokens.revoke("ben")
    assert client.post("/api/decisions", json=decision, headers=bearer(writing)).status_code == 401
    assert reading not in tokens.path.read_text()


def test_the_page_itself_needs_no_token(serve: Serve, tokens: TokenFile) -> None:
    tokens.create("ana", "read")
    client = serve(token_file=str(tokens.path))
    page = client.get("/")
    assert (page.status_code, "sign-in" in page.text) == (200, True)
    assert client.get("/style.css").status_code == 200


def test_the_page_keeps_a_token_in_a_cookie(serve: Serve, tokens: TokenFile) -> None:
    token = tokens.create("ana", "read")
    client = serve(token_file=str(tokens.path))
    assert client.get("/api/session").json() == {"needs_token": True, "scope": "none", "name": ""}
    assert client.post("/api/session", json={"token": "wrong"}).status_code == 401
    signed = client.post("/api/session", json={"token": token})
    assert signed.json()["scope"] == "read"
    assert {"HttpOnly", "SameSite=strict"} <= set(signed.headers["set-cookie"].split("; "))
    assert client.get("/api/info").status_code == 200
    client.delete("/api/session")
    assert client.get("/api/info").status_code == 401


def test_other_web_pages_can_do_nothing(client: TestClient) -> None:
    assert (
        client.post("/api/queries", json=QUERY, headers={"Sec-Fetch-Site": "cross-site"}).status_code == 403
    )
    assert (
        client.post("/api/queries", json=QUERY, headers={"Origin": "http://evil.example"}).status_code == 403
    )
    assert (
        client.post("/api/queries", json=QUERY, headers={"Sec-Fetch-Site": "same-origin"}).status_code == 200
    )
    assert client.get("/api/info", headers={"Host": "evil.example"}).status_code == 403
    assert "default-src 'none'" in client.get("/api/info").headers["content-security-policy"]


def test_too_many_searches(serve: Serve) -> None:
    client = serve(rate=2)
    codes = [client.post("/api/queries", json=QUERY) for _ in range(3)]
    assert [answer.status_code for answer in codes] == [200, 200, 429]
    assert int(codes[2].headers["Retry-After"]) >= 1
    assert client.get("/api/info").status_code == 200  # looking costs little


def test_too_large(serve: Serve) -> None:
    client = serve(max_upload=1)
    answer = client.post("/api/uploads", files={"file": ("large.obj", b"#" * (2 * 2**20))})
    assert (answer.status_code, "1 MB" in answer.json()["error"]) == (413, True)

    def chunks() -> Any:
        yield b'{"like": ['
        for _ in range(100):
            yield b" " * 2**16

    # Without saying how long it will be.
    answer = client.post("/api/queries", content=chunks(), headers={"content-type": "application/json"})
    assert answer.status_code == 413


def test_too_slow(settings: ServiceSettings) -> None:
    sent: list[dict[str, Any]] = []

    async def application(scope: Any, receive: Any, send: Any) -> None:
        while (await receive())["more_body"]:
            pass

    async def receive() -> dict[str, Any]:
        await asyncio.sleep(0.02)
        return {"type": "http.request", "body": b"x", "more_body": True}

    async def send(message: Any) -> None:
        sent.append(message)

    limited = Limits(application, replace(settings, upload_seconds=0.2), Access(settings))
    scope = {
        "type": "http",
        "method": "POST",
        "path": "/api/uploads",
        "headers": [(b"host", b"localhost")],
    }
    asyncio.run(limited(scope, receive, send))
    assert sent[0]["status"] == 408
    assert "did not arrive" in json.loads(sent[1]["body"])["error"]


@pytest.mark.parametrize("path", ["/api/uploads", "/api/queries", "/api/decisions"])
def test_nothing_is_received_without_a_token(settings: ServiceSettings, tokens: TokenFile, path: str) -> None:
    tokens.create("ana", "read")
    received = 0

    sent: list[dict[str, Any]] = []

    async def receive() -> dict[str, Any]:
        nonlocal received
        received += 1
        return {"type": "http.request", "body": b" " * 2**16, "more_body": received < 5}

    async def send(message: Any) -> None:
        sent.append(message)

    form = b"multipart/form-data; boundary=x" if path == "/api/uploads" else b"application/json"
    headers = [(b"host", b"localhost"), (b"content-type", form), (b"authorization", b"Bearer sg_wrong")]
    scope = {
        "type": "http",
        "method": "POST",
        "scheme": "http",
        "path": path,
        "query_string": b"",
        "headers": headers,
        "client": ("192.0.2.1", 1),
    }
    asyncio.run(make_app(replace(settings, token_file=str(tokens.path)))(scope, receive, send))
    assert (sent[0]["status"], received) == (401, 0)
    assert dict(sent[0]["headers"])[b"www-authenticate"] == b"Bearer"
    assert "is not valid (any more)" in json.loads(sent[1]["body"])["error"]


def test_an_upload_that_is_refused_leaves_nothing(settings: ServiceSettings, tmp_path: Path) -> None:
    async def upload() -> ServiceError:
        with sg.Library.open(settings.library, read_only=True) as library:
            uploads = Uploads(replace(settings, max_waiting=0), Spool(tmp_path), library.model)
        try:
            path = uploads.folder / "refused" / "ball.off"
            path.parent.mkdir()
            path.write_text("OFF")
            with pytest.raises(ServiceError, match="too many uploads") as refused:
                await uploads.describe(path)
            assert not path.parent.exists()
            return refused.value
        finally:
            uploads.close()

    assert asyncio.run(upload()).status == 503


def test_a_library_that_was_moved_away_is_not_made_anew(serve: Serve, library_path: Path) -> None:
    client = serve(library=str(library_path))
    library_path.unlink()
    decision = {"kind": "master", "shape": {"shape_id": 1}}
    answer = client.post("/api/decisions", json=decision)
    assert (answer.status_code, library_path.exists()) == (503, False)
    assert answer.json()["error"].startswith("there is no library 'shapes.sglib'")


def test_tokens_that_cannot_be_read(serve: Serve, tokens: TokenFile) -> None:
    tokens.path.write_text("[]")
    client = serve(token_file=str(tokens.path))
    headers = bearer("sg_any")
    for answer in (
        client.get("/api/info", headers=headers),
        client.post("/api/queries", json=QUERY, headers=headers),
    ):
        assert (answer.status_code, str(tokens.path.parent) in answer.text) == (500, False)
        assert "cannot read its tokens" in answer.json()["error"]


def test_tokens_made_at_once_are_all_there(tmp_path: Path) -> None:
    path = tmp_path / "tokens.json"
    names = [f"client {number}" for number in range(24)]
    with ThreadPoolExecutor(8) as pool:
        # A file of its own for each, as other programs have.
        texts = list(pool.map(lambda name: TokenFile(path).create(name, "read"), names))
    assert [token.name for token in TokenFile(path).tokens()] == sorted(names)
    with ThreadPoolExecutor(8) as pool:
        assert all(pool.map(lambda name: TokenFile(path).revoke(name), names[:-1]))
    (left,) = TokenFile(path).tokens()
    assert TokenFile(path).find(texts[-1]) == left


def test_addresses_that_are_none(client: TestClient) -> None:
    assert client.get("/api/info", headers={"Host": "["}).status_code == 403
    assert client.post("/api/queries", json=QUERY, headers={"Origin": "http://["}).status_code == 403


def test_a_busy_library(settings: ServiceSettings) -> None:
    ended = threading.Event()

    async def ask() -> list[int]:
        lanes = LibraryLanes(replace(settings, time_limit=0.5, max_waiting=2))
        waiting = [lanes.run("search", lambda library: ended.wait()) for _ in range(3)]
        found = await asyncio.gather(*waiting, return_exceptions=True)
        ended.set()
        lanes.close()
        return [error.status for error in found if isinstance(error, ServiceError)]

    assert asyncio.run(ask()) == [504, 504, 503]


def test_what_was_given_up_does_not_hold_up_the_others() -> None:
    started, ended = threading.Semaphore(0), threading.Event()

    def endless(_thread: LibraryThread) -> None:
        started.release()
        ended.wait()

    def name_of(number: int, _thread: LibraryThread) -> str:
        return f"search {number}"

    async def ask() -> list[str]:
        line = Line("unused.sglib", 2)
        found = []
        for number in range(3):
            running = line.submit(endless)
            await asyncio.to_thread(started.acquire)
            waiting = line.submit(partial(name_of, number))
            with pytest.raises(ServiceError, match="too many requests are waiting"):
                line.submit(endless)
            line.give_up(running)
            if number < 2:
                found.append(await waiting)
        # Three threads are lost, so nobody is left; but one that has finished helps out.
        with pytest.raises(ServiceError, match="took too long still occupy the service"):
            line.submit(endless)
        ended.set()
        found.append(await waiting)
        found.append(await line.submit(partial(name_of, 3)))
        line.close()
        return found

    assert asyncio.run(ask()) == ["search 0", "search 1", "search 2", "search 3"]


def test_what_was_given_up_while_it_waited_does_not_run() -> None:
    ended, reached = threading.Event(), threading.Event()
    ran: list[int] = []

    async def ask() -> None:
        line = Line("unused.sglib", 3)
        line.submit(lambda _thread: ended.wait())
        waiting = line.submit(lambda _thread: ran.append(1))
        line.submit(lambda _thread: reached.set())
        line.give_up(waiting)
        ended.set()
        # Without letting the event loop run: the thread may be faster than it.
        assert reached.wait(60)
        line.close()

    asyncio.run(ask())
    assert ran == []


def test_shutting_down_does_not_wait_for_duplicates(settings: ServiceSettings) -> None:
    started, ended = threading.Event(), threading.Event()

    def endless(_library: Library) -> bool:
        started.set()
        return ended.wait()

    async def ask() -> bool:
        lanes = LibraryLanes(settings)
        running, waiting = lanes.start_long(endless), lanes.start_long(len)
        await asyncio.to_thread(started.wait)
        lanes.close()
        assert not ended.is_set()
        return running.cancelled() and waiting.cancelled()

    assert asyncio.run(ask())
    ended.set()


def test_an_upload_that_takes_too_long_or_too_much(serve: Serve) -> None:
    ball = trimesh.creation.icosphere(6).export(file_type="off").encode()
    answer = serve(time_limit=0.05).post("/api/uploads", files={"file": ("ball.off", ball)})
    assert (answer.status_code, "given up" in answer.json()["error"]) == (504, True)
    answer = serve(memory_limit=1).post("/api/uploads", files={"file": ("ball.off", ball)})
    assert (answer.status_code, "1 MB of memory" in answer.json()["error"]) == (422, True)


@pytest.mark.parametrize("content", ["", "[]", '{"tokens": [{"name": "a"}]}', "\x00"])
def test_a_damaged_file_of_tokens(tokens: TokenFile, content: str) -> None:
    tokens.path.write_text(content)
    with pytest.raises(TokenError, match="is not a file of tokens"):
        tokens.find("anything")


def test_names_of_tokens_are_used_once(tokens: TokenFile) -> None:
    tokens.create("ana", "read")
    with pytest.raises(TokenError, match="has a token 'ana' already"):
        tokens.create("ana", "write")
    assert not tokens.revoke("ben")
    assert [(token.name, token.scope) for token in tokens.tokens()] == [("ana", "read")]

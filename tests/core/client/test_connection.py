# SPDX-License-Identifier: MIT
"""What goes wrong between a client and a service is one sentence, against other real servers."""

from __future__ import annotations

import base64
import hashlib
import json
import math
import os
import select
import socket
import ssl
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

import shapegoogle_core as sg
from shapegoogle_core.client import Connection, KeptTokens, LibraryAddress, ServiceAddress, proxies
from shapegoogle_core.client.connection import NotThereError
from shapegoogle_core.client.models import model_file, model_of_service
from shapegoogle_core.client.places import Places
from shapegoogle_core.client.values import one_of, picture, real, text
from shapegoogle_core.client.versions import API_VERSION, check_versions
from shapegoogle_core.library.search.settings import RerankSettings
from tests.core.sentences import faults

CERTIFICATE = Path(__file__).with_name("self_signed.pem")
Answers = list[tuple[int, dict[str, str], bytes]]
Serve = Callable[..., str]


@pytest.fixture
def serve() -> Iterator[Serve]:
    """Start servers that give some answers, one after the other, the last one for ever."""
    running = []

    def start(*answers: tuple[int, dict[str, str], bytes], encrypted: bool = False) -> str:
        left = list(answers)

        class Handler(BaseHTTPRequestHandler):
            def do_POST(self) -> None:
                self.rfile.read(int(self.headers["Content-Length"]))
                self.do_GET()

            def do_GET(self) -> None:
                status, headers, content = left.pop(0) if len(left) > 1 else left[0]
                self.send_response(status)
                for name, value in headers.items():
                    self.send_header(name, value)
                self.send_header("Content-Length", str(len(content)))
                self.end_headers()
                self.wfile.write(content)

            def log_message(self, *_: object) -> None:
                """Keep quiet."""

        server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        if encrypted:
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
            context.load_cert_chain(CERTIFICATE)
            server.socket = context.wrap_socket(server.socket, server_side=True)
        running.append(server)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        return f"http{'s' if encrypted else ''}://localhost:{server.server_port}"

    yield start
    for server in running:
        server.shutdown()
        server.server_close()


def refusal(address: str, certificate: str = "") -> str:
    """Ask for something; return the sentence that says why there is no answer."""
    with pytest.raises(sg.LibraryError) as caught:
        Connection(ServiceAddress.parse(address), certificate=certificate).get("info")
    sentence = str(caught.value)
    assert not faults(sentence)
    return sentence


def error(sentence: str) -> bytes:
    return json.dumps({"error": sentence}).encode()


@pytest.mark.parametrize(
    ("status", "headers", "content", "expected"),
    [
        (200, {}, b"<html>", "no Shape Google service that this version understands"),
        (404, {}, b"<html>", "no Shape Google service that this version understands"),
        (302, {"Location": "https://a.b/"}, b"", "sends requests on to another address; use 'https://a.b/'"),
        (401, {}, error("x"), "needs a token; ask whoever runs the service for one"),
        (403, {}, error("the token 'a' allows reading only"), "the token 'a' allows reading only"),
        (429, {"Retry-After": "40"}, error("too many requests; try again in 40 s"), "again in 40 s"),
        (502, {}, b"<html>bad gateway", "does not work at the moment; try again later"),
        (503, {}, error("the library is busy; try again"), "the library is busy"),
        (504, {}, error("the library did not answer within 60 s"), "did not answer within 60 s"),
        (500, {}, b'{"error": "two\\nlines"}', "does not work at the moment"),
        (413, {}, b"", "refused the request as too large or too frequent"),
        (503, {"Retry-After": "\xb2"}, b"", "does not work at the moment"),
        (503, {"Retry-After": "9" * 5_000}, b"", "does not work at the moment"),
        (302, {"Location": f"https://{'a' * 5_000}/"}, b"", "sends requests on to another address"),
    ],
)
def test_a_refusal(serve: Serve, status: int, headers: dict[str, str], content: bytes, expected: str) -> None:
    assert expected in refusal(serve((status, headers, content)))


def test_a_busy_service_is_asked_again(serve: Serve) -> None:
    address = serve((429, {"Retry-After": "0"}, error("wait")), (200, {}, b'{"a": 1}'))
    assert Connection(ServiceAddress.parse(address)).get("info") == {"a": 1}


def test_what_is_not_there_is_told_apart(serve: Serve) -> None:
    connection = Connection(ServiceAddress.parse(serve((404, {}, error("there is no shape 7")))))
    with pytest.raises(NotThereError, match="there is no shape 7"):
        connection.get("shapes/7")


def test_a_connection_that_is_lost_or_refused() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        port = listening.getsockname()[1]

        def hang_up(said: bytes) -> None:
            with listening.accept()[0] as client:
                client.recv(4_000)
                client.sendall(said)

        for said in (b"", b"HTTP/1.1 200 OK\r\nContent-Length: 9\r\n\r\n{}"):
            thread = threading.Thread(target=hang_up, args=(said,))
            thread.start()
            assert "was lost; try again" in refusal(f"http://127.0.0.1:{port}")
            thread.join()
        # It is accepted by the system, and never answered.
        slow = Connection(ServiceAddress.parse(f"http://127.0.0.1:{port}"), timeout=0.2)
        with pytest.raises(sg.LibraryError, match=r"did not answer within 0\.2 s"):
            slow.get("info")
    assert "nothing answers at" in refusal(f"http://127.0.0.1:{port}")
    assert "there is no server 'nowhere.invalid'" in refusal("https://nowhere.invalid")


def test_certificates(serve: Serve, tmp_path: Path) -> None:
    address = serve((200, {}, b'{"a": 1}'), encrypted=True)
    assert "has a certificate that nobody this computer knows has signed" in refusal(address)
    own = Connection(ServiceAddress.parse(address), certificate=str(CERTIFICATE))
    assert own.get("info") == {"a": 1}
    plain = serve((200, {}, b"{}"))
    assert "does not speak HTTPS" in refusal(plain.replace("http:", "https:"))
    (tmp_path / "no.pem").write_text("no certificate")
    assert "cannot be read as a certificate" in refusal(address, certificate=str(tmp_path / "no.pem"))


@pytest.fixture
def proxy() -> Iterator[tuple[str, list[tuple[str, str]]]]:
    """A proxy that needs a name and a password: its address, and what it was asked for by whom."""
    asked: list[tuple[str, str]] = []

    class Handler(BaseHTTPRequestHandler):
        def do_CONNECT(self) -> None:
            name = self.headers.get("Proxy-Authorization", "")
            asked.append((self.path, base64.b64decode(name.removeprefix("Basic ")).decode()))
            if not name:
                self.send_error(407)
                return
            host, _, port = self.path.rpartition(":")
            with socket.create_connection((host, int(port))) as there:
                self.wfile.write(b"HTTP/1.1 200 OK\r\n\r\n")
                ends = {self.connection: there, there: self.connection}
                while ends:
                    for ready in select.select(list(ends), [], [])[0]:
                        content = ready.recv(2**16)
                        if not content:
                            return
                        ends[ready].sendall(content)

        def log_message(self, *_: object) -> None:
            """Keep quiet."""

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"127.0.0.1:{server.server_port}", asked
        server.shutdown()


def test_proxies(
    serve: Serve, proxy: tuple[str, list[tuple[str, str]]], monkeypatch: pytest.MonkeyPatch
) -> None:
    place, asked = proxy
    address = serve((200, {}, b'{"a": 1}'), encrypted=True)
    for variable in ("https_proxy", "http_proxy"):
        monkeypatch.setenv(variable, f"http://ana:se%20cret@{place}")
    monkeypatch.delenv("no_proxy", raising=False)
    monkeypatch.delenv("NO_PROXY", raising=False)
    for own in (address, serve((200, {}, b'{"a": 1}'))):
        assert Connection(ServiceAddress.parse(own), "secret", str(CERTIFICATE)).get("info") == {"a": 1}
    assert asked == [], "a service of this computer is asked without a proxy"

    # Other names than those of this computer lead nowhere here.
    monkeypatch.setattr(proxies, "is_loopback", lambda _host: False)
    other = Connection(ServiceAddress.parse(address), "secret", str(CERTIFICATE))
    assert other.get("info") == {"a": 1}
    assert asked == [(address.removeprefix("https://"), "ana:se cret")]
    other.close()

    monkeypatch.setenv("https_proxy", f"http://{place}")
    assert f"the proxy '{place}' leads to no service" in refusal(address)
    monkeypatch.setenv("https_proxy", "socks5://127.0.0.1:1080")
    assert "must be like http://proxy:3128" in refusal(address)
    monkeypatch.setenv("no_proxy", "localhost")
    assert "nobody this computer knows has signed" in refusal(address)


@pytest.mark.parametrize(
    ("address", "expected"),
    [
        ("http://shapes.example", "is not encrypted"),
        ("https://ana:secret@shapes.example", "takes no name and password"),
        ("https://", "is no address of a service"),
        ("https://two words", "is no address of a service"),
        ("https://a:70000", "is no address of a service"),
        ("https://a:0", "is no address of a service"),
        ("https://shapes..studio", "is no address of a service"),
        ("https://a/?x=1", "leave out what follows"),
    ],
)
def test_addresses_that_are_refused(address: str, expected: str) -> None:
    with pytest.raises(sg.LibraryError, match=expected) as caught:
        ServiceAddress.parse(address)
    assert "secret" not in str(caught.value)
    assert not faults(str(caught.value))


def test_addresses() -> None:
    assert str(ServiceAddress.parse(" https://Shapes.example/props/ ")) == "https://shapes.example/props"
    assert str(ServiceAddress.parse("http://[::1]:8765")) == "http://[::1]:8765"


def test_versions_say_which_side_is_too_old() -> None:
    address = ServiceAddress.parse("https://a")
    check_versions(address, {"api": API_VERSION, "version": "1"})
    with pytest.raises(sg.LibraryError, match="update Shape Google on this computer"):
        check_versions(address, {"api": API_VERSION + 1, "version": "2"})
    with pytest.raises(sg.LibraryError, match="ask whoever runs the service to update it"):
        check_versions(address, {"api": API_VERSION - 1, "version": "0"})


def test_places(tmp_path: Path) -> None:
    places = Places(["assets", "scans"])
    assert places.source({"root": "assets", "path": "a/b.obj"}) == "assets/a/b.obj"
    assert places.source({"root": "", "path": "label"}) == "label"
    assert places.place("assets/a/b.obj") == {"root": "assets", "path": "a/b.obj"}
    assert places.place(str(tmp_path / "b.obj")) is None
    places.folders["assets"] = str(tmp_path)
    assert places.source({"root": "assets", "path": "a/b.obj"}) == str(tmp_path / "a" / "b.obj")
    assert places.place(str(tmp_path / "a" / "b.obj")) == {"root": "assets", "path": "a/b.obj"}
    assert places.conditions(sg.Filter(folder=tmp_path / "a")) == {"folder": "assets/a"}
    # A service names no files outside the folder that was chosen.
    for path in ("../b.obj", "a/../../b.obj", "/etc/b.obj", "C:\\b.obj", "..\\b.obj"):
        assert not Path(places.source({"root": "assets", "path": path})).is_absolute()
    for root, path in (("", "/etc/b.obj"), ("/etc", "b.obj"), ("C:", "b.obj"), ("", r"\\nas\b.obj")):
        assert places.source({"root": root, "path": path}) == "b.obj"
    with understood_as_wrong():
        places.source({"root": "assets", "path": "a\0b"})


def understood_as_wrong() -> Any:
    return pytest.raises((TypeError, ValueError))


def test_values_that_no_service_sends() -> None:
    for value in (1, None, "half a pair \ud800", "a\0b"):
        with understood_as_wrong():
            text(value)
    for number in ("1", None, math.nan, math.inf):
        with understood_as_wrong():
            real(number)
    with understood_as_wrong():
        one_of(("a", "b"), {})
    stored = BytesIO()
    Image.new("L", (4, 4)).save(stored, "png")
    png = stored.getvalue()
    assert picture(base64.b64encode(png).decode()) == png
    huge = png[:16] + b"\0\0\xff\xff" + png[20:]
    for content in (b"", b"no picture", png[:20], huge):
        with understood_as_wrong():
            picture(base64.b64encode(content).decode())


def test_pages_that_do_not_go_on_end(serve: Serve, tmp_path: Path) -> None:
    model = sg.load_model()
    content = model.to_bytes()
    about = {"api": API_VERSION, "version": "1", "model_hash": hashlib.sha256(content).hexdigest()}
    info = json.dumps({**about, "roots": [], "shapes": 1, "without_views": 0}).encode()
    page = json.dumps({"shapes": [], "next": 0, "ready": True, "groups": []}).encode()
    address = serve((200, {}, info), (200, {}, content), (200, {}, page))
    with sg.ServiceLibrary.connect(address, cache=tmp_path) as library:
        for ask in (library.find, library.duplicates):
            with pytest.raises(sg.LibraryError, match="no Shape Google service"):
                ask()


def test_few_models_are_kept_and_only_models(serve: Serve, tmp_path: Path) -> None:
    def ask(content: bytes) -> None:
        address = ServiceAddress.parse(serve((200, {}, content)))
        model_of_service(Connection(address), hashlib.sha256(content).hexdigest(), tmp_path)

    with pytest.raises(sg.LibraryError, match="is not a Shape Google model"):
        ask(b"anything else")
    assert list(tmp_path.iterdir()) == []
    for number in range(9):
        path = model_file(f"{number:064}", tmp_path)
        path.touch()
        os.utime(path, (number, number))
    ask(sg.load_model().to_bytes())
    assert len(list(tmp_path.iterdir())) == 8
    assert not model_file(f"{1:064}", tmp_path).exists()


def test_files_that_a_service_cannot_know(tmp_path: Path) -> None:
    places = Places(["assets"])
    outside = str(tmp_path / "open.blend")
    assert places.conditions(sg.Filter(sources=(outside,))) is None
    assert places.conditions(sg.Filter(not_sources=(outside,))) == {}


def test_tokens_are_for_the_user_alone(tmp_path: Path) -> None:
    tokens = KeptTokens(tmp_path / "kept" / "tokens.json")
    assert tokens.token("https://a") == ""
    tokens.keep("https://a", " one\n")
    tokens.keep("https://b", "two")
    assert [tokens.token(f"https://{name}") for name in "ab"] == ["one", "two"]
    tokens.keep("https://a", "")
    assert tokens.token("https://a") == ""
    path = tmp_path / "kept" / "tokens.json"
    if not path.drive:
        assert path.stat().st_mode & 0o777 == 0o600


def test_a_library_that_must_not_be_opened(tmp_path: Path) -> None:
    with pytest.raises(sg.LibraryError, match="not now"):
        LibraryAddress("https://a", refusal="not now").open()
    with pytest.raises(sg.LibraryError, match="is a service, which others can search"):
        sg.Library.open("https://a")
    with pytest.raises(sg.LibraryError, match="settings of its own"):
        sg.open_library("https://a", search=replace(sg.SearchSettings(), rerank=RerankSettings(reranker="x")))
    with pytest.raises(sg.LibraryError, match="characters that no token has"):
        sg.open_library("https://a", token="a b")

# SPDX-License-Identifier: MIT
"""Indexing on a Dask cluster of this machine, into a database."""

from __future__ import annotations

import multiprocessing
import socket
import ssl
from collections.abc import Callable
from pathlib import Path

import pytest

from shapegoogle_core.cli.parser import main
from shapegoogle_core.errors import LibraryError, ShapeGoogleError
from shapegoogle_core.indexing import find_meshes
from shapegoogle_core.indexing.cluster import (
    _index_task,
    _local_cluster,
    _Task,
    check_address,
    index_on_cluster,
)
from shapegoogle_core.indexing.progress.events import FileOutcome
from shapegoogle_core.indexing.settings import IndexSettings
from shapegoogle_core.library.library import Library
from shapegoogle_core.model import ShapeModel


def kill_a_worker() -> None:
    """End one of the workers of this process's cluster as the system does that needs its memory."""
    workers = [child for child in multiprocessing.active_children() if "Dask Worker" in child.name]
    assert len(workers) == 2
    workers[0].kill()


def test_two_workers_fill_a_database_also_when_one_is_killed(
    folder: Path, make_mesh: Callable[..., Path], postgresql_url: str, model: ShapeModel
) -> None:
    make_mesh(folder / "late.obj", seed=4)
    (folder / "broken.off").write_text("no mesh")
    paths = find_meshes([folder])
    seen: list[FileOutcome] = []

    def progress(outcome: FileOutcome) -> None:
        if not seen:
            kill_a_worker()
        seen.append(outcome)

    with Library.open(postgresql_url, model) as library:
        library.add_root(folder)
        settings = IndexSettings(jobs=2)
        report = index_on_cluster(
            library, postgresql_url, paths, settings, "local", progress=progress, files_per_task=1
        )
        ((broken, reason),) = report.failed
        # A file that the killed worker had stored is found there by the next one, and not stored again.
        assert (report.added + report.unchanged, broken.name) == (4, "broken.off")
        assert "broken.off" in reason
        assert sorted(outcome.path for outcome in seen) == paths
        assert sorted(shape.source for shape in library.shapes()) == sorted(map(str, {*paths} - {broken}))
        # The same again: what is there is not read again, and no worker is needed.
        there = [path for path in paths if path != broken]
        again = index_on_cluster(library, postgresql_url, there, settings, "tls://nowhere:1")
        assert (again.unchanged, again.added, again.failed, len(library)) == (4, 0, [], 4)
        match, *_ = library.query(library.signature(1), top=1)
        assert match.similarity == pytest.approx(1)


def is_refused(host: str, port: int, context: ssl.SSLContext) -> bool:
    """Whether a server ends a connection instead of listening to it."""
    try:
        with (
            socket.create_connection((host, port), timeout=10) as plain,
            context.wrap_socket(plain) as encrypted,
        ):
            encrypted.sendall(bytes(8))
            # A certificate that is refused shows in the first answer.
            return encrypted.recv(1) == b""
    except (ssl.SSLError, ConnectionError):
        return True


def test_nobody_else_speaks_to_a_cluster_of_this_machine() -> None:
    from distributed import Client
    from distributed.security import Security

    with _local_cluster(1) as cluster:
        with Client(cluster) as client:
            workers = list(client.scheduler_info()["workers"])
            nannies = [worker["nanny"] for worker in client.scheduler_info()["workers"].values()]
            assert client.submit(sum, (1, 2)).result() == 3
        for address in (cluster.scheduler_address, *workers, *nannies):
            assert address.startswith("tls://127.0.0.1:")
            host, port = address.removeprefix("tls://").split(":")
            # One who trusts everybody, but has no key, or another one.
            for key in (None, Security.temporary().get_connection_args("client")["ssl_context"]):
                context = key or ssl.create_default_context()
                context.check_hostname = False
                context.verify_mode = ssl.CERT_NONE
                assert is_refused(host, int(port), context)
        with pytest.raises(OSError):
            Client(cluster.scheduler_address.replace("tls", "tcp"), timeout=5)


@pytest.mark.parametrize(
    ("address", "reason"),
    [
        ("tcp://farm:8786", "on another machine, and messages to it are not encrypted"),
        ("tcp://10.0.0.5:8786", "on another machine"),
        ("farm", "not the address of a Dask scheduler"),
        ("http://farm", "not the address of a Dask scheduler"),
    ],
)
def test_addresses_that_are_refused(address: str, reason: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ShapeGoogleError, match=reason):
        check_address(address)
    for good in ("local", "tls://farm:8786", "tcp://localhost:8786", "tcp://[::1]:8786"):
        check_address(good)
    check_address("tcp://farm:8786", trusted=True)


def test_a_scheduler_that_is_not_there(
    folder: Path,
    tmp_path: Path,
    model_file: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("shapegoogle_core.indexing.cluster.CONNECT_SECONDS", 1)
    command = ["index", str(folder), "--library", str(tmp_path / "new.sglib"), "--model", str(model_file)]
    assert main([*command, "--cluster", "tcp://127.0.0.1:1"]) == 2
    assert "no Dask scheduler answers at 'tcp://127.0.0.1:1'" in capsys.readouterr().err


def test_a_worker_makes_no_library(tmp_path: Path) -> None:
    place = tmp_path / "elsewhere.sglib"
    task = _Task(place, (), {}, IndexSettings(jobs=1), None)
    with pytest.raises(LibraryError, match="there is no library"):
        _index_task(task)
    assert not place.exists()


def test_no_password_comes_into_logs_of_workers() -> None:
    task = _Task("postgresql://ana:secret@server/shapes", (), {}, IndexSettings(jobs=1), None)
    assert "secret" not in repr(task)

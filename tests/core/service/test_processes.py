# SPDX-License-Identifier: MIT
"""The command, and services of several processes of which some are killed."""

from __future__ import annotations

import os
import signal
import sqlite3
import subprocess
import sys
import threading
import time
import urllib.error
from contextlib import closing
from pathlib import Path

import pytest

import shapegoogle_core as sg
from tests.core.service.running import running_service

QUERY = {"like": [{"shape_id": 1}], "limit": 5, "evidence": 5}


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "shapegoogle_core", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_a_service_for_the_network_needs_tokens(made_library: Path, tmp_path: Path) -> None:
    result = run("serve", "--library", str(made_library), "--host", "0.0.0.0")
    assert (result.returncode, result.stdout) == (2, "")
    assert "everybody in the network could search; create a token" in result.stderr
    assert "there is no library" in run("serve", "--library", str(tmp_path / "none.sglib")).stderr


def test_tokens_on_the_command_line(tmp_path: Path) -> None:
    file = ["--token-file", str(tmp_path / "tokens.json")]
    created = run("token", "create", "ana", "--scope", "write", *file)
    assert created.stdout.startswith("sg_")
    assert run("token", "list", *file).stdout.split()[:2] == ["ana", "write"]
    assert run("token", "revoke", "ben", *file).returncode == 1
    assert run("token", "revoke", "ana", *file).returncode == 0
    assert run("token", "create", *file).returncode == 2
    assert "has no tokens" in run("token", "list", *file).stderr


def is_alive(process_id: int) -> bool:
    """Whether a process of Python's own starting runs; of one that ended nothing is left but its number."""
    try:
        return b"spawn_main" in Path(f"/proc/{process_id}/cmdline").read_bytes()
    except FileNotFoundError:
        return False


def children(process_id: int) -> list[int]:
    """Processes that a process of the service has started."""
    lists = [path.read_text() for path in Path(f"/proc/{process_id}/task").glob("*/children")]
    return [child for child in map(int, " ".join(lists).split()) if is_alive(child)]


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="finds processes in /proc")
def test_killed_processes_lose_nothing(library_path: Path) -> None:
    with running_service(library_path, "--workers", "2", "--rate", "100000") as running:
        expected = running.post("queries", QUERY)["matches"]
        running.post("decisions", {"kind": "master", "shape": {"shape_id": 1}})
        answers: list[object] = []
        ended = threading.Event()

        def ask() -> None:
            while not ended.is_set():
                try:
                    answers.append(running.post("queries", QUERY)["matches"] == expected)
                except (urllib.error.URLError, ConnectionError):  # answered by a process that was killed
                    time.sleep(0.1)

        clients = [threading.Thread(target=ask) for _ in range(4)]
        for client in clients:
            client.start()
        for _ in range(2):
            workers = children(running.process.pid)
            assert len(workers) == 2
            time.sleep(1)
            os.kill(workers[0], signal.SIGKILL)
            until = time.monotonic() + 60
            while (set(children(running.process.pid)) == set(workers)) and time.monotonic() < until:
                time.sleep(0.2)
            while len(children(running.process.pid)) < 2 and time.monotonic() < until:
                time.sleep(0.2)
        before = len(answers)
        until = time.monotonic() + 60
        while len(answers) < before + 5 and time.monotonic() < until:
            time.sleep(0.2)
        ended.set()
        for client in clients:
            client.join()
        assert len(answers) >= before + 5
        assert all(answers)
        assert [decision["kind"] for decision in running.get("decisions")["decisions"]] == ["master"]
    with closing(sqlite3.connect(library_path)) as connection:
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    with sg.Library.open(library_path, read_only=True) as library:
        assert len(library) == 7


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="finds processes in /proc")
@pytest.mark.parametrize("workers", ["1", "2"])
def test_no_process_outlives_a_killed_service(library_path: Path, made_library: Path, workers: str) -> None:
    with running_service(library_path, "--workers", workers) as running:
        # An upload starts the process that reads it.
        mesh = made_library.parent / "models" / "box.ply"
        subprocess.run(
            ["curl", "-sf", "-F", f"file=@{mesh}", f"{running.address}api/uploads"],
            check=True,
            capture_output=True,
        )
        started = children(running.process.pid)
        started += [grandchild for child in started for grandchild in children(child)]
        # The worker, if there are several, and the process that has read the upload.
        assert len(started) == (1 if workers == "1" else 3)
        os.kill(running.process.pid, signal.SIGKILL)
        until = time.monotonic() + 30
        while any(map(is_alive, started)) and time.monotonic() < until:
            time.sleep(0.1)
        assert not any(map(is_alive, started))

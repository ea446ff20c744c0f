# SPDX-License-Identifier: MIT
"""The demo of a studio on one machine: a database, a cluster that fills it, and the service with its page."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FrameType
from typing import IO, NoReturn

from lib import bootstrap
from lib.demo_comparison import Answers, answers_of_library, answers_of_service, first_difference, query_files
from lib.demo_creatures import LIBRARY, MESHES, forget_other_model, run_command, write_library_meshes

__all__ = ["StudioError", "run"]

WORKERS = 2
PATIENCE = 60.0  # seconds for a program to start


class StudioError(Exception):
    """A part of the studio does not start, or two parts disagree; the message is one sentence."""


def run(*, check: bool) -> int:
    """Start everything, print the address of the page, and stop everything in the end.

    Parameters
    ----------
    check : bool
        Compare the answers of file, database and service, and stop; else wait for Ctrl-C.

    Returns
    -------
    code : int
        Exit code: 1 if something does not start or differs, 130 if it was interrupted before that was known.
    """
    from shapegoogle_core import ShapeGoogleError

    ready = False
    started = time.monotonic()
    signal.signal(signal.SIGTERM, _interrupt)
    try:
        with ExitStack() as stack:
            address, place = _start(stack)
            ready = True
            print(f"\nThe library is at {address} (after {time.monotonic() - started:.0f} s)", flush=True)
            if check:
                _check(address, place)
            else:
                print(
                    "Drop a mesh file on that page, or choose a shape. Ctrl-C stops everything.", flush=True
                )
                while True:
                    time.sleep(1)
    except KeyboardInterrupt:
        print("\nEverything is stopped.", flush=True)
        return 0 if ready and not check else 130
    except (StudioError, ShapeGoogleError, bootstrap.SetupError) as error:
        print(f"demo.py: {error}", file=sys.stderr, flush=True)
        return 1
    print(f"Everything agrees, and is stopped. Done in {time.monotonic() - started:.0f} s", flush=True)
    return 0


def _interrupt(_number: int, _frame: FrameType | None) -> NoReturn:
    raise KeyboardInterrupt


def _start(stack: ExitStack) -> tuple[str, str]:
    """Start the parts, one after the other; return the addresses of the page and of the library."""
    from benchmarks.studio.server import PostgresqlServer, bundled_programs, system_programs

    if sys.platform == "win32":
        raise StudioError("this part of the demo needs Linux or macOS; on Windows run it in WSL")
    write_library_meshes()
    programs = system_programs() or bundled_programs()
    if programs is None:
        raise StudioError("there is no PostgreSQL here; install one (Debian: sudo apt install postgresql)")
    folder = Path(stack.enter_context(TemporaryDirectory(prefix="shapegoogle-studio-")))
    print("Starting PostgreSQL ...", flush=True)
    server = PostgresqlServer(programs)
    stack.callback(server.remove)
    place = server.url()
    cluster = stack.enter_context(_cluster(folder))
    _index(place, cluster)
    address = stack.enter_context(_service(place))
    return address, place


def _index(place: str, cluster: str) -> None:
    run_command("index", MESHES, "--library", place, "--cluster", cluster)


@contextmanager
def _cluster(folder: Path) -> Iterator[str]:
    """Run a Dask scheduler and workers, whom only those can speak to who have the key in the folder."""
    from distributed import Client
    from distributed.security import Security

    made = Security.temporary()
    assert isinstance(made.tls_client_cert, str)  # in memory, since they are made for this run
    assert isinstance(made.tls_client_key, str)
    (folder / "certificate.pem").write_text(made.tls_client_cert)
    key = folder / "key.pem"
    key.touch(mode=0o600)
    key.write_text(made.tls_client_key)
    os.environ["DASK_DISTRIBUTED__COMM__REQUIRE_ENCRYPTION"] = "True"
    os.environ["DASK_DISTRIBUTED__COMM__TLS__CA_FILE"] = str(folder / "certificate.pem")
    for role in ("SCHEDULER", "WORKER", "CLIENT"):
        os.environ[f"DASK_DISTRIBUTED__COMM__TLS__{role}__CERT"] = str(folder / "certificate.pem")
        os.environ[f"DASK_DISTRIBUTED__COMM__TLS__{role}__KEY"] = str(key)
    # Workers read files in processes of their own.
    os.environ["DASK_DISTRIBUTED__WORKER__DAEMON"] = "False"
    os.environ["DASK_LOGGING__DISTRIBUTED"] = "error"
    print(f"Starting a Dask scheduler and {WORKERS} workers ...", flush=True)
    found = folder / "scheduler.json"
    dask = [sys.executable, "-m", "dask"]
    scheduler = [*dask, "scheduler", "--host", "tls://127.0.0.1", "--port", "0", "--no-dashboard"]
    # Files of this run only, of worker processes too.
    local = ["--local-directory", str(folder / "workers")]
    threads = ["--nworkers", str(WORKERS), "--nthreads", "1"]
    with (folder / "log").open("w") as log, ExitStack() as stack:
        first = stack.enter_context(_program([*scheduler, "--scheduler-file", str(found)], log))
        until = time.monotonic() + PATIENCE
        while not (found.exists() and found.read_text().endswith("}")):
            _check_starts("the Dask scheduler", first, until, folder / "log")
        address: str = json.loads(found.read_text())["address"]
        workers = [*dask, "worker", address, "--host", "127.0.0.1", "--no-dashboard", *threads, *local]
        second = stack.enter_context(_program(workers, log))
        security = Security(
            tls_ca_file=made.tls_client_cert,
            tls_client_cert=made.tls_client_cert,
            tls_client_key=made.tls_client_key,
            require_encryption=True,
        )
        with Client(address, security=security, timeout=PATIENCE) as client:
            while len(client.scheduler_info(n_workers=-1)["workers"]) < WORKERS:
                _check_starts("a Dask worker", second, until, folder / "log")
        yield address


def _check_starts(name: str, process: subprocess.Popen[str], until: float, log: Path) -> None:
    """Wait a little for a program that starts; raise an error if it has ended or takes too long."""
    if process.poll() is not None or time.monotonic() > until:
        said = log.read_text(errors="replace").strip()
        raise StudioError(f"{name} does not start: {said or 'it says nothing about it'}")
    time.sleep(0.1)


@contextmanager
def _service(place: str) -> Iterator[str]:
    """Run the service of a library at any free port; yield the address of its page."""
    command = ["serve", "--library", place, "--port", "0", "--rate", "6000", "--allow-download"]
    print(f"\n$ shapegoogle {' '.join(command)}", flush=True)
    with _program([sys.executable, "-m", "shapegoogle_core", *command], subprocess.PIPE) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        found = re.search(r"http://\S+", line)
        if found is None:
            raise StudioError(f"the service does not start: {line.strip()}{process.stdout.read().strip()}")
        yield found[0]


@contextmanager
def _program(command: Sequence[str], output: int | IO[str]) -> Iterator[subprocess.Popen[str]]:
    """Run a program during the block; it and all that it started are gone afterwards."""
    # A session of its own: Ctrl-C reaches this script, which then stops one after the other.
    process = subprocess.Popen(
        command,
        stdout=output,
        stderr=subprocess.STDOUT,
        text=True,
        cwd=bootstrap.ROOT,
        start_new_session=True,
    )
    try:
        yield process
    finally:
        process.terminate()
        try:
            process.wait(10)
        except subprocess.TimeoutExpired:
            print(f"{Path(command[0]).name} does not end, and is killed", flush=True)
        _kill_group(process.pid)
        process.wait()


def _kill_group(group: int) -> None:
    try:
        os.killpg(group, signal.SIGKILL)
    except ProcessLookupError:
        return


def _check(address: str, place: str) -> None:
    """Ask file, database and service the same; index again; raise an error at the first difference."""
    from shapegoogle_core import Library

    print("\nThe same as a file:", flush=True)
    forget_other_model(LIBRARY)
    run_command("index", MESHES, "--library", LIBRARY)
    queries = query_files()
    print(f"\nAsking file, database and service {len(queries)} queries ...", flush=True)
    answers: dict[str, Answers] = {
        "the file": answers_of_library(LIBRARY, queries),
        "the database": answers_of_library(place, queries),
        "the service": answers_of_service(address, queries),
    }
    _compare(answers)
    with Library.open(place, read_only=True) as library:
        before = {shape.source: shape.shape_id for shape in library.shapes()}
    print("\nIndexing again:", flush=True)
    run_command("index", MESHES, "--library", place)
    with Library.open(place, read_only=True) as library:
        after = {shape.source: shape.shape_id for shape in library.shapes()}
        count = len(library)
    if after != before or count != len(before):
        raise StudioError(
            f"indexing again has changed the database: {len(before)} shapes before, {count} afterwards"
        )
    _compare(
        {
            "the database": answers["the database"],
            "the database, indexed again,": answers_of_library(place, queries),
            "the service, after that,": answers_of_service(address, queries),
        }
    )


def _compare(answers: dict[str, Answers]) -> None:
    (name, expected), *others = answers.items()
    for other, found in others:
        difference = first_difference(expected, found)
        if difference is not None:
            raise StudioError(f"{other} and {name} answer differently: {difference}")

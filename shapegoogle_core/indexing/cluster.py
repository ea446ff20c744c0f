# SPDX-License-Identifier: MIT
"""Indexing on the workers of a Dask cluster, on one machine or many.

A scheduler is slow with a hundred thousand tasks, so one task is about a hundred files, and few tasks wait
for each worker. Workers read the files, which all of them must reach by the same paths, and store the shapes
in transactions of their own; only counts come back. What a lost worker had stored stays, and its task runs
again on another one.

Whoever reaches the ports of a cluster can run programs with its rights. Every user of this machine reaches
those of a local one, so its messages are encrypted with a key that only its processes have.
"""

from __future__ import annotations

import ipaddress
import logging
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from shapegoogle_core.errors import ShapeGoogleError
from shapegoogle_core.indexing.index import index_known_files
from shapegoogle_core.indexing.plan import plan_indexing
from shapegoogle_core.indexing.progress.events import FileOutcome, IndexReport
from shapegoogle_core.indexing.reading.external_reader import ExternalReader
from shapegoogle_core.indexing.reading.notes import total_left_out
from shapegoogle_core.indexing.settings import IndexSettings
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.address import Place
from shapegoogle_core.library.storage.opening import check_exists
from shapegoogle_core.library.storage.records import SourceRecord
from shapegoogle_core.processes.launching import default_jobs

if TYPE_CHECKING:
    from distributed import Client, LocalCluster

__all__ = ["LOCAL", "check_address", "index_on_cluster"]

LOCAL = "local"
"""Address that starts workers on this machine."""

# Files of one task, and tasks that wait for each worker.
_FILES = 100
_AHEAD = 2
CONNECT_SECONDS = 20


@dataclass(frozen=True)
class _Task:
    """Files for one worker.

    Attributes
    ----------
    place : Path or str
        The library.
    roots : tuple of (str, str)
        Names and paths of roots that lie elsewhere here than where the library says.
    known : dict of str to (SourceRecord or None)
        The files, and what the library knows about them.
    settings : IndexSettings
    reader : ExternalReader or None
    """

    # Dask writes the arguments of a task that fails into its log: an address may have a password in it.
    place: Place = field(repr=False)
    roots: tuple[tuple[str, str], ...]
    known: dict[str, SourceRecord | None]
    settings: IndexSettings
    reader: ExternalReader | None


@dataclass(frozen=True)
class _Done:
    """Outcome of a task."""

    report: IndexReport
    outcomes: tuple[FileOutcome, ...]


def check_address(address: str, *, trusted: bool = False) -> None:
    """Refuse an address whose messages others could read or make up.

    Parameters
    ----------
    address : str
        "local", or that of a Dask scheduler.
    trusted : bool, optional
        Whether the network is trusted.

    Raises
    ------
    ShapeGoogleError
        If messages to it are not encrypted, and it is on another machine.

    Examples
    --------
    >>> from shapegoogle_core.indexing.cluster import check_address
    >>> check_address("tcp://127.0.0.1:8786")
    """
    parts = urlsplit(address)
    if address == LOCAL or parts.scheme == "tls" or trusted:
        return
    if parts.scheme != "tcp" or not parts.hostname:
        raise ShapeGoogleError(
            f"'{address}' is not the address of a Dask scheduler; write tcp://127.0.0.1:8786, "
            "tls://scheduler:8786, or local"
        )
    if not _is_loopback(parts.hostname):
        raise ShapeGoogleError(
            f"'{address}' is on another machine, and messages to it are not encrypted: whoever reaches the "
            "scheduler can run programs on its workers; use tls://, or add --trust-network"
        )


def index_on_cluster(
    library: Library,
    place: Place,
    paths: Sequence[Path],
    settings: IndexSettings,
    address: str,
    *,
    progress: Callable[[FileOutcome], None] | None = None,
    reader: ExternalReader | None = None,
    files_per_task: int = _FILES,
) -> IndexReport:
    """Bring a library up to date with mesh files, on the workers of a cluster.

    Parameters
    ----------
    library : Library
        Open for writing.
    place : Path or str
        The same library, as the workers open it.
    paths : sequence of Path
        Mesh files; the workers reach them by these paths.
    settings : IndexSettings
        `jobs` is the number of processes of each worker, one by default, or with "local" that of workers.
    address : str
        "local" for workers on this machine, or the address of a Dask scheduler.
    progress : callable, optional
        Called with the `FileOutcome` of each file.
    reader : ExternalReader, optional
        See `index_files`.
    files_per_task : int, optional

    Returns
    -------
    report : IndexReport

    Raises
    ------
    ShapeGoogleError
        If there is no such cluster, or Dask is not installed.
    LibraryError
        If the library cannot be written.
    """
    # The second makes the key of a cluster of this machine.
    needed = ("distributed", "cryptography") if address == LOCAL else ("distributed",)
    for package in needed:
        if find_spec(package) is None:
            raise ShapeGoogleError(
                f"a cluster needs the package {package}; install it with: "
                'pip install "shapegoogle-core[cluster]"'
            )
    started = time.monotonic()
    library.add_roots(paths)
    known = library.sources()
    planned = plan_indexing(library, paths, settings, reader)
    total = _Total(progress)
    for outcome in planned:
        if outcome.status in ("unchanged", "failed"):
            total.note(outcome)
    waiting = [str(outcome.path) for outcome in planned if outcome.status in ("added", "updated")]
    roots = tuple((root.name, root.path) for root in library.roots() if root.stored)
    own_jobs = 1 if address == LOCAL else settings.jobs or 1
    # Workers have working directories of their own.
    shared = place.absolute() if isinstance(place, Path) else place
    tasks = [
        _Task(
            shared,
            roots,
            {path: known.get(path) for path in waiting[start : start + files_per_task]},
            replace(settings, jobs=own_jobs),
            reader,
        )
        for start in range(0, len(waiting), files_per_task)
    ]
    if tasks:
        workers = min(settings.jobs or default_jobs(), len(tasks))
        with _client(address, workers) as client:
            for task, done in _run(client, tasks):
                total.add(task, done)
    library.update_neighbours()
    return total.report(time.monotonic() - started)


class _Total:
    """Adds up the outcomes of tasks."""

    def __init__(self, progress: Callable[[FileOutcome], None] | None) -> None:
        self._progress = progress
        self._counts: Counter[str] = Counter()
        self._reports: list[IndexReport] = []
        self._failed: list[tuple[Path, str]] = []

    def note(self, outcome: FileOutcome) -> None:
        """Count a file that no worker has seen."""
        self._counts[outcome.status] += 1
        if outcome.status == "failed":
            self._failed.append((outcome.path, outcome.reason))
        if self._progress is not None:
            self._progress(outcome)

    def add(self, task: _Task, done: _Done | str) -> None:
        """Add the outcome of a task, or the reason why it has none."""
        if isinstance(done, str):
            for path in task.known:
                self.note(FileOutcome(Path(path), "failed", f"{Path(path).name!r} was not indexed: {done}"))
            return
        self._reports.append(done.report)
        if self._progress is not None:
            for outcome in done.outcomes:
                self._progress(outcome)

    def report(self, seconds: float) -> IndexReport:
        """Return the sum."""
        reports = self._reports
        return IndexReport(
            added=sum(report.added for report in reports),
            updated=sum(report.updated for report in reports),
            unchanged=self._counts["unchanged"] + sum(report.unchanged for report in reports),
            shapes=sum(report.shapes for report in reports),
            failed=[*self._failed, *(failure for report in reports for failure in report.failed)],
            seconds=seconds,
            updated_shapes=sum(report.updated_shapes for report in reports),
            partial_shapes=sum(report.partial_shapes for report in reports),
            warnings=[warning for report in reports for warning in report.warnings],
            left_out=total_left_out(left_out for report in reports for left_out in report.left_out),
        )


def _run(client: Client, tasks: Sequence[_Task]) -> Iterator[tuple[_Task, _Done | str]]:
    """Run tasks, few at once, and yield the outcome of each as it comes."""
    from distributed import as_completed

    left = iter(tasks)
    running: dict[Any, _Task] = {}
    pool = as_completed()

    def submit() -> None:
        task = next(left, None)
        if task is not None:
            future = client.submit(_index_task, task, pure=False)
            running[future] = task
            pool.add(future)

    try:
        for _ in range(_AHEAD * max(1, len(client.scheduler_info()["workers"]))):
            submit()
        for future in pool:
            task = running.pop(future)
            submit()
            if future.status == "finished":
                yield task, future.result()
            else:
                error = future.exception()
                if isinstance(error, ShapeGoogleError):
                    yield task, str(error)
                else:
                    yield task, "its worker ended several times, or has another version of Shape Google"
    finally:
        # After Ctrl-C: tasks that run end with their worker's next file, and what they stored stays.
        client.cancel(list(running))


def _index_task(task: _Task) -> _Done:
    """Index the files of a task, on a worker."""
    import multiprocessing

    if multiprocessing.current_process().daemon:
        raise ShapeGoogleError(
            "workers need processes of their own; start them with DASK_DISTRIBUTED__WORKER__DAEMON=False"
        )
    outcomes: list[FileOutcome] = []
    # Where a worker does not reach the library, it must not make another one.
    check_exists(task.place)
    with Library.open(task.place) as library:
        for name, path in task.roots:
            library.map_root(name, path)
        known: Mapping[str, SourceRecord] = {
            path: source for path, source in task.known.items() if source is not None
        }
        report = index_known_files(
            library, task.known, task.settings, known, progress=outcomes.append, reader=task.reader
        )
    return _Done(report, tuple(outcomes))


@contextmanager
def _client(address: str, workers: int) -> Iterator[Client]:
    """Connect to a cluster, or start one on this machine."""
    from distributed import Client

    if address != LOCAL:
        try:
            client = Client(address, timeout=CONNECT_SECONDS)
        except (OSError, ValueError) as error:
            raise ShapeGoogleError(
                f"no Dask scheduler answers at '{address}'; check the address, and start one with "
                "`dask scheduler`"
            ) from error
        with client:
            if not client.scheduler_info()["workers"]:
                raise ShapeGoogleError(
                    f"the cluster at '{address}' has no workers; start some with `dask worker {address}`"
                )
            yield client
        return
    with _local_cluster(workers) as cluster, Client(cluster) as client:
        yield client


@contextmanager
def _local_cluster(workers: int) -> Iterator[LocalCluster]:
    """Start workers on this machine, whom only those can speak to who have a key made for this run."""
    import dask
    from distributed import LocalCluster
    from distributed.security import Security

    configuration = {
        "distributed.worker.daemon": False,
        # Pages for browsers, which would show files and tasks to everybody on this machine.
        "distributed.scheduler.http.routes": [],
        "distributed.worker.http.routes": [],
    }
    with (
        dask.config.set(configuration),
        LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            host="127.0.0.1",
            protocol="tls",
            security=Security.temporary(),
            dashboard_address=None,
            # A task that fails raises in the client. What is left are workers that miss their scheduler when
            # a run is interrupted, each with a traceback.
            silence_logs=logging.CRITICAL,
        ) as cluster,
    ):
        yield cluster


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"

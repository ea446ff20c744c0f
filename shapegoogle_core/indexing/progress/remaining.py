# SPDX-License-Identifier: MIT
"""Estimating the remaining time of an indexing run.

What is left is counted in seconds of work: the shapes that wait to be described, and the files that have not
been read. Both are estimated from what similar ones took in this run; files are similar if they have the same
suffix and about the same size, meshes if they have about the same size. Sizes are sorted into bins, one for
each power of two. A distant bin counts less, so that the only file of 2,000 objects says little about the 350
small ones.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from shapegoogle_core.processes.pool import Spent

__all__ = ["RemainingTime", "describing_order", "working_order"]

# Weight of a bin relative to the next one: with 2⁻⁴, a file 32 times as large counts a millionth.
WEIGHT = 2.0**-4
# Seconds after which the speed of the machine counts half as much: others may use it, too.
HALF_LIFE = 60.0
# Seconds for which the assumed speed counts as much as the measured one.
ASSUMED = 10.0
# Seconds that may pass between two tasks of a process while there are others.
LONGEST_PAUSE = 0.5
# Shapes of one kind of file that count as much as all shapes of the same size.
FEW = 4.0
# Meshes of each size that are described first, so that none is a surprise later.
SAMPLES = 4
# Weight of the first description of each process, which imports modules.
FIRST = 0.05
# Part of the time without news by which the run is expected to go on.
PATIENCE = 0.5

ALL_KINDS = ""


def working_order(
    files: Iterable[tuple[Path, int]], several_shapes: Collection[str] = ()
) -> tuple[list[tuple[Path, int]], list[tuple[Path, int]]]:
    """Put files in the order in which the remaining time becomes known soon and processes end together.

    Of the files that may contain thousands of shapes, the largest come first, since most of the work may be
    in one of them. The others keep their order.

    Parameters
    ----------
    files : iterable of (Path, int)
        With their sizes in bytes.
    several_shapes : collection of str
        Suffixes of files that may contain more than one shape, in lower case.

    Returns
    -------
    samples : list of (Path, int)
        One file of each suffix, of median size, to be read before any shape is described.
    others : list of (Path, int)
    """
    groups: defaultdict[str, list[tuple[Path, int]]] = defaultdict(list)
    for path, size in files:
        groups[_kind(path)].append((path, size))
    samples, large, rest = [], [], []
    for kind, members in groups.items():
        by_size = sorted(members, key=lambda member: member[1])
        # The first in the order of those of this size: copies keep theirs.
        median = next(member for member in members if member[1] == by_size[len(by_size) // 2][1])
        samples.append(median)
        others = [member for member in members if member is not median]
        if kind in several_shapes:
            large += others
        else:
            rest += others
    large.sort(key=lambda member: -member[1])
    return samples, [*large, *rest]


def describing_order(meshes: Sequence[int]) -> list[int]:
    """Put the meshes of a file in the order in which the remaining time becomes known soon.

    A few of each size come first, or nobody would know what the largest take if they come last.

    Parameters
    ----------
    meshes : sequence of int
        Their sizes in bytes.

    Returns
    -------
    order : list of int
        Positions in `meshes`.

    Examples
    --------
    >>> from shapegoogle_core.indexing.progress.remaining import describing_order
    >>> describing_order([10, 11, 12, 13, 5000])
    [0, 4, 1, 2, 3]
    """
    numbers: defaultdict[int, int] = defaultdict(int)
    ranks = []
    for mesh in meshes:
        ranks.append(min(numbers[_bin(mesh)], SAMPLES))
        numbers[_bin(mesh)] += 1
    return sorted(range(len(meshes)), key=ranks.__getitem__)


@dataclass
class _Bin:
    """Sums over the files, or meshes, of about one size."""

    files: float = 0
    bytes: float = 0
    read_seconds: float = 0
    shapes: float = 0
    described: float = 0
    describe_seconds: float = 0


@dataclass
class _Unread:
    files: int = 0
    bytes: int = 0


@dataclass
class _Kind:
    """Files of one suffix: bins of those read, of their meshes by size, and of those not read."""

    seen: defaultdict[int, _Bin] = field(default_factory=lambda: defaultdict(_Bin))
    meshes: defaultdict[int, _Bin] = field(default_factory=lambda: defaultdict(_Bin))
    waiting: defaultdict[int, int] = field(default_factory=lambda: defaultdict(int))
    unread: defaultdict[int, _Unread] = field(default_factory=lambda: defaultdict(_Unread))


class RemainingTime:
    """Estimates the remaining time of an indexing run from the events that it is told.

    It has no clock of its own.

    Parameters
    ----------
    files : iterable of (Path, int)
        All files to read, with their sizes in bytes.
    jobs : int
        Number of processes.
    several_shapes : collection of str
        Suffixes of files that may contain more than one shape, in lower case.
    """

    def __init__(
        self, files: Iterable[tuple[Path, int]], jobs: int, several_shapes: Collection[str] = ()
    ) -> None:
        self._jobs = jobs
        self._several = frozenset(several_shapes)
        self._kinds: defaultdict[str, _Kind] = defaultdict(_Kind)
        for path, size in files:
            self.add(path, size)
        self._closed: set[Path] = set()
        self.shapes_done = 0
        self._last: float | None = None
        # Time of the processes, and what was expected for what they did in it, both fading.
        self._passed = self._expected = ASSUMED * jobs

    @property
    def shapes_waiting(self) -> int:
        """Number of shapes that were read and have not been described."""
        return sum(self._kinds[ALL_KINDS].waiting.values())

    def add(self, path: Path, size: int) -> None:
        """Note that there is one more file to read.

        Parameters
        ----------
        path : Path
        size : int
            In bytes.
        """
        unread = self._kinds[_kind(path)].unread[_bin(size)]
        unread.files += 1
        unread.bytes += size

    def read(self, path: Path, size: int, spent: Spent, meshes: Collection[int], now: float) -> None:
        """Note that a file was read, or could not be.

        Parameters
        ----------
        path : Path
        size : int
            In bytes.
        spent : Spent
        meshes : collection of int
            Size of each mesh in bytes that has to be described.
        now : float
            Time, in seconds.
        """
        cost = _cost(spent)
        usual = cost / self._slowness
        self._close(path, size, usual, len(meshes))
        for kind in self._kinds_of(path):
            for mesh in meshes:
                kind.waiting[_bin(mesh)] += 1
        self._note_speed(cost, usual, now)

    def passed_over(self, path: Path, size: int) -> None:
        """Note that a file need not be read: its content is known, or it cannot be opened.

        Parameters
        ----------
        path : Path
        size : int
            In bytes.
        """
        self._close(path, size, 0.0, 0)

    def described(self, path: Path, size: int, mesh: int, spent: Spent, now: float) -> None:
        """Note that a shape was described, or could not be.

        Parameters
        ----------
        path : Path
            Its file.
        size : int
            Of the file, in bytes.
        mesh : int
            Size of its mesh in bytes, as it was given to `read`.
        spent : Spent
        now : float
            Time, in seconds.
        """
        self.shapes_done += 1
        cost = _cost(spent)
        is_first = self.shapes_done <= self._jobs
        weight = FIRST if is_first else 1.0
        for kind in self._kinds_of(path):
            kind.waiting[_bin(mesh)] -= 1
            for entry in (kind.seen[_bin(size)], kind.meshes[_bin(mesh)]):
                entry.described += weight
                entry.describe_seconds += weight * cost / self._slowness
        if is_first:
            self._last = now
            return
        expected = _ratio(self._kinds[_kind(path)].meshes, _bin(mesh), "describe_seconds", "described")
        self._note_speed(cost, expected or 0.0, now)

    def shapes_expected(self) -> int:
        """Estimate the number of shapes in the files that have not been read.

        Returns
        -------
        shapes : int
        """
        return round(
            sum(
                self._shapes(name, size, unread)
                for name, kind in self._kinds.items()
                if name != ALL_KINDS
                for size, unread in kind.unread.items()
            )
        )

    def seconds_left(self, now: float) -> float | None:
        """Estimate the remaining time.

        Parameters
        ----------
        now : float
            Time, in seconds.

        Returns
        -------
        seconds : float or None
            None as long as too little is known: no file of some suffix has been read, or no shape described,
            or a file that may contain thousands of shapes is far larger than those that have been read.
        """
        waiting = [
            (kind, size, number)
            for name, kind in self._kinds.items()
            if name != ALL_KINDS
            for size, number in kind.waiting.items()
            if number
        ]
        unread = [
            (name, size, entry)
            for name, kind in self._kinds.items()
            if name != ALL_KINDS
            for size, entry in kind.unread.items()
            if entry.files
        ]
        if any(self._is_a_mystery(name, size) for name, size, _ in unread):
            return None
        work, tasks, longest = 0.0, 0.0, 0.0
        for kind, size, number in waiting:
            for meshes in (kind.meshes, self._kinds[ALL_KINDS].meshes):
                seconds = _ratio(meshes, size, "describe_seconds", "described")
                if seconds is not None:
                    break
            if seconds is None:
                return None
            work += number * seconds
            tasks += number
            longest = max(longest, seconds)
        for name, size, entry in unread:
            per_byte = _ratio(self._kinds[name].seen, size, "read_seconds", "bytes") or 0.0
            shapes = self._shapes(name, size, entry)
            each = self._seconds_per_shape(name, size)
            if each is None and shapes:
                return None
            work += per_byte * entry.bytes + shapes * (each or 0.0)
            tasks += entry.files + shapes
            longest = max(longest, per_byte * entry.bytes / entry.files + (each or 0.0))
        if not tasks:
            return 0.0
        left = self._slowness * max(work / min(self._jobs, max(tasks, 1.0)), longest)
        silence = 0.0 if self._last is None else max(now - self._last, 0.0)
        return max(left - silence, PATIENCE * silence)

    def _is_a_mystery(self, name: str, size: int) -> bool:
        """Whether nobody knows what is in files of a kind and size."""
        seen = self._kinds[name].seen
        return not seen or (name in self._several and size > max(seen) + 1)

    def _kinds_of(self, path: Path) -> tuple[_Kind, _Kind]:
        return self._kinds[_kind(path)], self._kinds[ALL_KINDS]

    def _close(self, path: Path, size: int, seconds: float, shapes: int) -> None:
        if path not in self._closed:  # a copy of a file that changed meanwhile is read after all
            self._closed.add(path)
            unread = self._kinds[_kind(path)].unread[_bin(size)]
            unread.files -= 1
            unread.bytes -= size
        for kind in self._kinds_of(path):
            seen = kind.seen[_bin(size)]
            seen.files += 1
            seen.bytes += max(size, 1)
            seen.read_seconds += seconds
            seen.shapes += shapes

    @property
    def _slowness(self) -> float:
        """How many times as long as at the beginning the machine takes for the same work."""
        return self._passed / self._expected

    def _note_speed(self, cost: float, expected: float, now: float) -> None:
        """Compare what a task has cost with what similar ones would have at the beginning."""
        fading = 1.0 if self._last is None else 0.5 ** ((now - self._last) / HALF_LIFE)
        self._passed = fading * self._passed + cost
        self._expected = fading * self._expected + expected
        self._last = now

    def _shapes(self, name: str, size: int, unread: _Unread) -> float:
        """Estimate the number of shapes in unread files of one kind and size."""
        seen = self._kinds[name].seen
        if name in self._several:
            return unread.bytes * (_ratio(seen, size, "shapes", "bytes") or 0.0)
        per_file = _ratio(seen, size, "shapes", "files")
        return unread.files * (1.0 if per_file is None else per_file)

    def _seconds_per_shape(self, name: str, size: int) -> float | None:
        """Estimate the time to describe a shape of an unread file of one kind and size.

        Few files of the kind may have been read, perhaps one, and that one may have been the first task of a
        process, which imports modules. So what meshes of the same sizes took, of whatever kind of file,
        counts as much as a few shapes of this kind.
        """
        kind, every = self._kinds[name], self._kinds[ALL_KINDS]
        usual = _ratio(every.seen, size, "describe_seconds", "described")
        own = _ratio(kind.seen, size, "describe_seconds", "described")
        if usual is None or own is None:
            return usual
        likely, meshes = 0.0, 0.0
        for mesh, entry in kind.meshes.items():
            likely += entry.described * (_ratio(every.meshes, mesh, "describe_seconds", "described") or usual)
            meshes += entry.described
        return (meshes * own + FEW * likely / meshes) / (meshes + FEW)


def _ratio(bins: Mapping[int, _Bin], size: int, above: str, below: str) -> float | None:
    """Ratio of two sums over all bins, those of another size with less weight; None if there is nothing."""
    weights = {other: WEIGHT ** abs(other - size) for other in bins}
    divisor = sum(weight * getattr(bins[other], below) for other, weight in weights.items())
    if not divisor:
        return None
    return float(sum(weight * getattr(bins[other], above) for other, weight in weights.items()) / divisor)


def _cost(spent: Spent) -> float:
    """Seconds of a process for a task, with those between two tasks; not with those without any task."""
    return spent.seconds + min(spent.idle, LONGEST_PAUSE)


def _kind(path: Path) -> str:
    return path.suffix.lower() or "."


def _bin(size: int) -> int:
    return size.bit_length()

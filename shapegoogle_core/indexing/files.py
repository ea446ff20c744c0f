# SPDX-License-Identifier: MIT
"""Mesh files on disk: finding them, and noticing changes."""

from __future__ import annotations

import errno
import hashlib
import os
import stat
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from shapegoogle_core.api.arguments import as_paths
from shapegoogle_core.errors import MeshError
from shapegoogle_core.indexing.exclusion import Exclusion
from shapegoogle_core.mesh.io.file import FormatError
from shapegoogle_core.mesh.io.gltf import buffer_files
from shapegoogle_core.mesh.io.other_formats import OTHER_SUFFIXES
from shapegoogle_core.mesh.io.reading import READERS

__all__ = [
    "ContentKey",
    "FileState",
    "absolute",
    "choices_of",
    "content_key",
    "content_of",
    "examine",
    "find_meshes",
    "stamp",
    "unreadable",
]

# Copies of a file are recognised by content and suffix: the suffix decides how the content is read, and so do
# the reader's options, which are written behind the hash: "9f86…+objects=assets".
ContentKey = tuple[str, str]


def absolute(path: str | Path) -> Path:
    """Return the absolute path without "..", links not followed: the name of a file in a library.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    path : Path
    """
    return Path(os.path.abspath(path))  # noqa: PTH100 - `resolve` would follow links


def find_meshes(
    inputs: str | Path | Iterable[str | Path],
    on_error: Callable[[Path, str], None] | None = None,
    suffixes: Collection[str] | None = None,
    *,
    exclude: str | Iterable[str] = (),
    on_excluded: Callable[[Path], None] | None = None,
    on_skipped: Callable[[Path], None] | None = None,
) -> list[Path]:
    """List the mesh files in folders and all folders below them.

    Names that begin with a dot are skipped. Links to folders are followed, each folder once, so cyclic
    links cause no endless loop. An input that is a file is listed whatever its name.

    Parameters
    ----------
    inputs : str, Path, or iterable of them
        Folders and files.
    on_error : callable, optional
        Called with the path and a sentence for each input that is missing, cannot be read or contains no
        mesh, and the others are listed. By default such an input raises.
    suffixes : collection of str, optional
        Suffixes of mesh files, in lower case with the dot; by default of all formats that are read, those of
        plug-ins too.
    exclude : str, or iterable of them, optional
        Patterns of files and folders to leave out, see `Exclusion`; those of names also hold for inputs that
        are files.
    on_excluded : callable, optional
        Called with each file of shapes that was left out, and each folder, which is not searched.
    on_skipped : callable, optional
        Called with each file that holds shapes in a format that is not read, such as .step.

    Returns
    -------
    paths : list of Path
        Absolute and sorted, each once.

    Raises
    ------
    ValueError
        If an input is neither a str nor a path, or a pattern is empty.
    MeshError
        For the first input that is missing, cannot be read or contains no mesh, unless `on_error` is given.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import shapegoogle_core as sg
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     for name in ("horse.ply", "cow.stl", "notes.txt"):
    ...         Path(folder, name).touch()
    ...     [path.name for path in sg.find_meshes([folder])]
    ['cow.stl', 'horse.ply']
    """

    def report(path: Path, reason: str) -> None:
        if on_error is None:
            raise MeshError(f"'{path}' {reason}")
        on_error(path, f"{path.name!r} {reason}")

    suffixes = frozenset(READERS) if suffixes is None else suffixes
    exclusion = Exclusion([exclude] if isinstance(exclude, str) else exclude)
    left_out: list[Path] = []
    skipped: list[Path] = []
    found: set[Path] = set()
    for path in map(absolute, as_paths(inputs)):
        if not path.is_dir():
            if exclusion.matches(path.name):
                left_out.append(path)
            elif os.path.lexists(path):
                found.add(path)
            else:
                report(path, "does not exist; check the spelling")
            continue
        before = len(left_out)
        meshes: list[Path] = []
        for file in _files_below(path, {*suffixes, *OTHER_SUFFIXES}, report, exclusion, left_out.append):
            (meshes if file.suffix.lower() in suffixes else skipped).append(file)
        if not meshes and len(left_out) == before:
            report(path, f"has no mesh files ({' '.join(sorted(suffixes))}) in it or below it")
        found.update(meshes)
    if on_excluded is not None:
        for path in dict.fromkeys(left_out):
            on_excluded(path)
    if on_skipped is not None:
        for path in dict.fromkeys(skipped):
            on_skipped(path)
    return sorted(found)


def _files_below(
    top: Path,
    suffixes: Collection[str],
    report: Callable[[Path, str], None],
    exclusion: Exclusion,
    leave_out: Callable[[Path], None],
) -> Iterator[Path]:
    seen: set[tuple[int, int]] = set()

    def unreadable(error: OSError) -> None:
        report(Path(error.filename), f"cannot be read: {error.strerror}")

    def excluded(path: Path, *, is_folder: bool) -> bool:
        if not exclusion.matches(path.relative_to(top).as_posix(), folder=is_folder):
            return False
        leave_out(path)
        return True

    for folder, subfolders, files in os.walk(top, followlinks=True, onerror=unreadable):
        status = Path(folder).stat()
        identity = (status.st_dev, status.st_ino)
        if identity in seen:
            subfolders.clear()
            continue
        seen.add(identity)
        # Sorted, so that a folder that can be reached in two ways always has the same path.
        subfolders[:] = sorted(
            name
            for name in subfolders
            if not name.startswith(".") and not excluded(Path(folder, name), is_folder=True)
        )
        for name in files:
            path = Path(folder, name)
            is_wanted = not name.startswith(".") and path.suffix.lower() in suffixes
            if is_wanted and not excluded(path, is_folder=False):
                yield path


@dataclass(frozen=True)
class FileState:
    """State of a mesh file when its content was hashed; a .gltf includes the files it refers to.

    Attributes
    ----------
    path : Path
    size : int
        In bytes.
    mtime_ns : int
        Time of the last change, in nanoseconds.
    sha256 : str
        Hash of the content, in hexadecimal digits, and the reader's options.
    """

    path: Path
    size: int
    mtime_ns: int
    sha256: str

    @property
    def key(self) -> ContentKey:
        """Key that copies of this file share with it."""
        return content_key(self.path, self.sha256)

    def changed(self) -> bool:
        """Whether the file has been changed or removed since.

        Returns
        -------
        changed : bool
        """
        try:
            return stamp(self.path) != (self.size, self.mtime_ns)
        except OSError:
            return True


def content_key(path: Path, sha256: str) -> ContentKey:
    """Return the key of a content; see `ContentKey`.

    Parameters
    ----------
    path : Path
    sha256 : str

    Returns
    -------
    key : tuple of (str, str)
    """
    return sha256, path.suffix.lower()


def content_of(sha256: str) -> str:
    """Return the hash of the content alone, without the reader's options.

    Parameters
    ----------
    sha256 : str

    Returns
    -------
    sha256 : str
    """
    return sha256.partition("+")[0]


def choices_of(sha256: str) -> str:
    """Return the reader's options behind a hash, as `ExternalReader.choices_for` writes them.

    Parameters
    ----------
    sha256 : str

    Returns
    -------
    choices : str
    """
    return sha256[len(content_of(sha256)) :]


def stamp(path: Path) -> tuple[int, int]:
    """Return size and time of the last change; while both are the same, so is the content.

    Parameters
    ----------
    path : Path

    Returns
    -------
    size : int
        In bytes.
    mtime_ns : int
        In nanoseconds.

    Raises
    ------
    OSError
        If the file is missing or not an ordinary file.
    """
    states = [part.stat() for part in _parts(path)]
    return sum(state.st_size for state in states), max(state.st_mtime_ns for state in states)


def examine(path: Path, choices: str = "") -> FileState:
    """Hash a file.

    Parameters
    ----------
    path : Path
    choices : str, optional
        Options of the reader, as `ExternalReader.choices_for` writes them.

    Returns
    -------
    state : FileState

    Raises
    ------
    OSError
        If the file cannot be read.
    """
    # The time before the content: a change in between is noticed in the next run.
    size, mtime_ns = stamp(path)
    digests = []
    for part in _parts(path):
        with part.open("rb") as file:
            digests.append(hashlib.file_digest(file, "sha256"))
    if len(digests) > 1:
        digests = [hashlib.sha256(b"".join(digest.digest() for digest in digests))]
    return FileState(path, size, mtime_ns, digests[0].hexdigest() + choices)


def unreadable(path: Path, error: OSError) -> str:
    """Say why a file cannot be opened.

    Parameters
    ----------
    path : Path
    error : OSError

    Returns
    -------
    reason : str
        A sentence.
    """
    if path.is_dir():
        return f"{path.name!r} is a folder; list its files with find_meshes"
    return f"{path.name!r} cannot be read: {error.strerror}; check that it is there and is yours"


def _parts(path: Path) -> list[Path]:
    """List the files that contain a shape: a .gltf stores its coordinates in files beside it, a .glb may."""
    if not stat.S_ISREG(path.stat().st_mode):
        # Reading a pipe or a device might never end.
        raise OSError(errno.EINVAL, "it is not an ordinary file")
    if path.suffix.lower() not in (".glb", ".gltf"):
        return [path]
    try:
        return [path, *buffer_files(path)]
    except FormatError:
        # Damaged: the reader reports how.
        return [path]

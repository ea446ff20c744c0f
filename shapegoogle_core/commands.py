# SPDX-License-Identifier: MIT
"""What each command of `shapegoogle` does, once its command line is understood."""

from __future__ import annotations

import json
import sys
import traceback
from argparse import Namespace
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from shapegoogle_core.errors import MeshError, ModelError
from shapegoogle_core.indexing import IndexReport, find_meshes, index_files
from shapegoogle_core.indexing.workers import default_jobs
from shapegoogle_core.library import Library, Match
from shapegoogle_core.mesh import Mesh, read_mesh
from shapegoogle_core.model import load_model
from shapegoogle_core.progress import IndexProgress, progress_bar

__all__ = ["DONE", "INTERRUPTED", "SOME_FAILED", "UNUSABLE", "index", "info", "query", "say", "train"]

# Exit codes; the command's help says what they mean.
DONE, SOME_FAILED, UNUSABLE, INTERRUPTED = 0, 1, 2, 130

Failures = list[tuple[Path, str]]


def index(options: Namespace) -> int:
    """Bring a library up to date with folders."""
    failed: Failures = []
    paths = _find(options.inputs, failed)
    if not paths and not options.prune:
        _list_failures(failed)
        return SOME_FAILED
    model = None if options.model is None else load_model(options.model)
    with Library.open(options.library, model) as library:
        folders = [entry for entry in options.inputs if Path(entry).is_dir()]
        removed = library.remove_missing(folders) if options.prune else []
        gone = [] if options.prune else library.missing(folders)
        progress = IndexProgress(len(paths), verbose=options.verbose)
        try:
            with progress:
                report = index_files(
                    library,
                    paths,
                    jobs=options.jobs,
                    time_limit=options.time_limit,
                    memory_limit=options.memory_limit,
                    retry=options.retry,
                    progress=progress,
                )
        except KeyboardInterrupt:
            say(
                f"shapegoogle: interrupted after {progress.done} of {len(paths)} files; "
                "what was stored stays, run the same command again to go on"
            )
            return INTERRUPTED
        shapes = len(library)
    failed += report.failed
    if options.json:
        print(json.dumps(_index_record(report, failed, removed, shapes)))
    else:
        print(_index_summary(report, failed, removed, shapes))
    if gone:
        say(f"{_count(len(gone), 'indexed file')} no longer there; forget with --prune")
    _list_failures(failed)
    return SOME_FAILED if failed else DONE


def _index_record(
    report: IndexReport, failed: Failures, removed: list[str], shapes: int
) -> dict[str, object]:
    return {
        "added": report.added,
        "updated": report.updated,
        "unchanged": report.unchanged,
        "removed": removed,
        "failed": [{"source": str(path), "error": reason} for path, reason in failed],
        "shapes": shapes,
        "seconds": round(report.seconds, 3),
    }


def _index_summary(report: IndexReport, failed: Failures, removed: list[str], shapes: int) -> str:
    described = report.added + report.updated
    if not described and not removed and not failed:
        return f"nothing to do: {_count(report.unchanged, 'file')} unchanged, {_count(shapes, 'shape')}"
    parts = [f"{report.added} added", f"{report.updated} updated", f"{report.unchanged} unchanged"]
    if removed:
        parts.append(f"{len(removed)} removed")
    if failed:
        parts.append(f"{len(failed)} failed")
    rate = f" ({described / report.seconds:.1f} files/s)" if described else ""
    return f"{', '.join(parts)} in {report.seconds:.1f} s{rate}; the library has {_count(shapes, 'shape')}"


def query(options: Namespace) -> int:
    """Print the best matches of each mesh."""
    failed: Failures = []
    with Library.open(options.library, read_only=True) as library:
        shapes = len(library)
        for path in options.meshes:
            record: dict[str, object] = {"query": path, "matches": []}
            try:
                matches = library.query(read_mesh(path), top=options.top, exact=options.exact)
            except (MeshError, MemoryError) as error:
                reason = str(error) if isinstance(error, MeshError) else f"{path!r} does not fit into memory"
                if options.verbose:
                    traceback.print_exc()
                failed.append((Path(path), reason))
                record["error"] = reason
            else:
                record["matches"] = [match.to_json() for match in matches]
                if not options.json:
                    print(_match_table(path, matches, shapes), end="\n\n")
            if options.json:
                print(json.dumps(record))
            # Whoever reads the other end of a pipe gets each answer as soon as it is there.
            sys.stdout.flush()
    if not options.json and len(failed) < len(options.meshes):
        print(
            "similarity: how likely it is the same shape transformed rather than the nearest of many others\n"
            "distance:   what orders the list, from 0 for the very same to 2"
        )
    _list_failures(failed)
    return SOME_FAILED if failed else DONE


def _match_table(query: str, matches: list[Match], shapes: int) -> str:
    rows = [("", "similarity", "distance", "name", "source")]
    rows += [
        (str(rank), _shown(match), f"{match.distance:.4f}", match.name, match.source)
        for rank, match in enumerate(matches, start=1)
    ]
    ranks, similarities, distances, names, _ = (max(map(len, column)) for column in zip(*rows, strict=True))
    lines = [
        f"{rank:>{ranks}}  {similarity:>{similarities}}  {distance:>{distances}}  {name:<{names}}  {source}"
        for rank, similarity, distance, name, source in rows
    ]
    return "\n".join(
        [f"{query}: the best {len(matches)} of {_count(shapes, 'shape')}", *map(str.rstrip, lines)]
    )


def _shown(match: Match) -> str:
    """Write the similarity so that only the very same shape is said to be 1."""
    rounded = f"{match.similarity:.3f}"
    return ">0.999" if rounded == "1.000" and match.distance > 0 else rounded


def info(options: Namespace) -> int:
    """Print what a library holds."""
    with Library.open(options.library, read_only=True) as library:
        info = library.info()
        failures = {path: source.error for path, source in library.sources().items() if source.error}
    if options.json:
        print(json.dumps({**info, "failures": failures}))
        return DONE
    width = max(map(len, info))
    for key, value in info.items():
        shown = f"{value:,}" if isinstance(value, int) else value
        print(f"{key.replace('_', ' '):<{width}}  {shown}")
    for path, error in failures.items():
        print(f"  {path}: {error}")
    return DONE


def train(options: Namespace) -> int:
    """Learn a model and write it to a file."""
    # Learning needs scikit-learn, which takes long to import.
    from shapegoogle_core.settings import PRESETS
    from shapegoogle_core.training import TrainingShape, train_model

    if options.preset not in PRESETS:
        raise ModelError(f"there is no preset {options.preset!r}; choose one of {', '.join(sorted(PRESETS))}")
    output = Path(options.output)
    if output.is_dir() or not output.parent.is_dir():
        # Better now than after an hour of training.
        raise ModelError(f"cannot write '{output}': name a file in a folder that exists")
    failed: Failures = []
    meshes: defaultdict[str, list[Mesh]] = defaultdict(list)
    for path in progress_bar(_find(options.inputs, failed), "reading"):
        try:
            mesh = read_mesh(path)
        except MeshError as error:
            say(f"skipped {path}: {error}")
            failed.append((path, str(error)))
        else:
            meshes[str(path.parent if options.poses else path)].append(mesh)
    model = train_model(
        [TrainingShape(identity, tuple(poses)) for identity, poses in sorted(meshes.items())],
        replace(PRESETS[options.preset], name=output.stem),
        versions=options.versions,
        jobs=options.jobs or default_jobs(),
        seed=options.seed,
        trained_on=f"{_count(len(meshes), 'shape')} of the user's, seed {options.seed}",
        progress=progress_bar,
    )
    model.save(output)
    size = output.stat().st_size
    print(f"{output}: model {model.identifier}, {size:,} bytes, from {_count(len(meshes), 'shape')}")
    _list_failures(failed)
    return SOME_FAILED if failed else DONE


def _find(inputs: Sequence[str], failed: Failures) -> list[Path]:
    def skip(path: Path, reason: str) -> None:
        say(f"skipped {path}: {reason}")
        failed.append((path, reason))

    return find_meshes(inputs, skip)


def _list_failures(failed: Failures) -> None:
    if failed:
        say(f"{_count(len(failed), 'input')} failed:")
        for path, reason in failed:
            say(f"  {path}: {reason}")


def _count(number: int, noun: str) -> str:
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


def say(text: str) -> None:
    """Print to stderr."""
    print(text, file=sys.stderr, flush=True)

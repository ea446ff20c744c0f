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

from shapegoogle_core.cli.arguments import DONE, INTERRUPTED, SOME_FAILED, say
from shapegoogle_core.errors import MeshError, ModelError
from shapegoogle_core.indexing import (
    ExternalReader,
    FoundShape,
    IndexReport,
    default_jobs,
    end_external_readers,
    find_meshes,
    index_files,
    read_shapes,
    readable_suffixes,
)
from shapegoogle_core.library import Library, Match
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import load_model
from shapegoogle_core.model.shape_model import ShapeSignature
from shapegoogle_core.processes.progress import IndexProgress, progress_bar
from shapegoogle_core.rendering.text import evidence_text

__all__ = ["index", "info", "query", "train"]

Failures = list[tuple[Path, str]]


def index(options: Namespace) -> int:
    """Bring a library up to date with folders."""
    failed: Failures = []
    paths = _find(options, failed)
    known = Path(options.library).exists()
    if not paths and not (options.prune and known):
        # A misspelt folder makes no library.
        if options.json:
            shapes = _shape_count(options.library) if known else 0
            print(json.dumps(_index_record(IndexReport(0, 0, 0, 0, [], 0.0), failed, [], shapes)))
        _list_failures(failed)
        return SOME_FAILED
    model = None if options.model is None else load_model(options.model)
    with Library.open(options.library, model) as library:
        folders = [entry for entry in options.inputs if _holds_something(Path(entry))]
        removed = library.remove_missing(folders) if options.prune else []
        gone = [] if options.prune else library.missing(folders)
        progress = IndexProgress(len(paths), verbose=options.verbose, events=options.events)
        try:
            with progress:
                report = index_files(
                    library,
                    paths,
                    jobs=options.jobs,
                    time_limit=options.time_limit,
                    memory_limit=options.memory_limit,
                    retry=options.retry,
                    reread=options.reread,
                    reader=_limited(options),
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


def _shape_count(library: str) -> int:
    with Library.open(library, read_only=True) as opened:
        return len(opened)


def _holds_something(folder: Path) -> bool:
    """Whether files may be said to be gone from a folder: an empty one may be where a drive belongs."""
    try:
        return any(folder.iterdir())
    except OSError:  # no folder, not there, or not to be read: `_find` has told
        return False


def _index_record(
    report: IndexReport, failed: Failures, removed: list[str], shapes: int
) -> dict[str, object]:
    return {
        "added": report.added,
        "updated": report.updated,
        "unchanged": report.unchanged,
        "removed": removed,
        "new_shapes": report.shapes,
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
    rate = f" ({report.shapes / report.seconds:.1f} shapes/s)" if report.shapes else ""
    return f"{', '.join(parts)} in {report.seconds:.1f} s{rate}; the library has {_count(shapes, 'shape')}"


def query(options: Namespace) -> int:
    """Print the best matches of each mesh, or of all of them together."""
    failed: Failures = []
    answered = False
    with Library.open(options.library, read_only=True) as library:
        shapes = len(library)
        unlike = _examples(library, options.unlike, options, failed)
        if options.together:
            like = _examples(library, options.meshes, options, failed)
            if isinstance(like, str) or isinstance(unlike, str):
                # Without one of its examples it would be another question.
                reasons = [reason for reason in (like, unlike) if isinstance(reason, str)]
                _answer(options, options.meshes, None, "; ".join(reasons))
            else:
                matches = library.query_signatures(like, options.top, options.exact, unlike=unlike)
                matches = library.explain(like, matches, options.evidence)
                _answer(options, options.meshes, None, matches, shapes)
                answered = True
        for path in () if options.together else options.meshes:
            if isinstance(unlike, str):
                _answer(options, path, None, unlike)
                continue
            try:
                found = _read_queries(path, options, failed)
            except (MeshError, MemoryError) as error:
                _answer(options, path, None, _query_failure(path, error, options, failed))
                continue
            for shape in found:
                try:
                    signature = library.model.describe(shape.mesh, keep_surface=options.evidence > 0)
                    matches = library.query_signatures([signature], options.top, options.exact, unlike=unlike)
                    matches = library.explain([signature], matches, options.evidence)
                except (MeshError, MemoryError) as error:
                    _answer(options, path, shape, _query_failure(path, error, options, failed))
                else:
                    _answer(options, path, shape, matches, shapes)
                    answered = True
    end_external_readers()
    if answered and not options.json:
        print(
            "similarity: how likely it is the same shape transformed rather than the nearest of many others\n"
            "distance:   what orders the list, from 0 for the very same to 2\n"
            "evidence:   what comparing the surfaces found; ×2 is twice the query's size"
        )
    _list_failures(failed)
    return SOME_FAILED if failed else DONE


def _examples(
    library: Library, paths: Sequence[str], options: Namespace, failed: Failures
) -> list[ShapeSignature] | str:
    """Describe all shapes of files that are examples of one thing; a sentence if one of the files fails."""
    signatures: list[ShapeSignature] = []
    reasons = []
    for path in paths:
        try:
            found = _read_queries(path, options, failed)
            signatures += [library.model.describe(shape.mesh, keep_surface=True) for shape in found]
        except (MeshError, MemoryError) as error:
            reasons.append(_query_failure(path, error, options, failed))
    return "; ".join(reasons) if reasons else signatures


def _read_queries(path: str, options: Namespace, failed: Failures) -> Sequence[FoundShape]:
    """All shapes of a query file, at least one; what is wrong with some of its objects is noted."""
    found = read_shapes(path, options.reader)
    failed += [(Path(path), problem) for problem in found.problems]
    if not found.shapes:
        raise MeshError(f"{Path(path).name!r} has no mesh objects; choose a file with a shape in it")
    return found.shapes


def _query_failure(path: str, error: BaseException, options: Namespace, failed: Failures) -> str:
    if options.verbose:
        traceback.print_exception(error)
    reason = str(error) if isinstance(error, MeshError) else f"{path!r} does not fit into memory"
    failed.append((Path(path), reason))
    return reason


def _answer(
    options: Namespace,
    query: str | list[str],
    shape: FoundShape | None,
    answer: list[Match] | str,
    shapes: int = 0,
) -> None:
    """Print what was found for one question, or a sentence on why it could not be looked for.

    The question is a file, one shape of a file, or several files together.
    """
    record: dict[str, object] = {"query": query}
    title = query if isinstance(query, str) else " and ".join(query)
    if shape is not None and shape.object_name:
        record["object"] = shape.object_name
        title = f"{title}, {shape.object_name}"
    if options.together or options.unlike:
        record["unlike"] = options.unlike
    if options.unlike:
        title = f"{title}, not like {' and '.join(options.unlike)}"
    if isinstance(answer, str):
        record |= {"matches": [], "error": answer}
    else:
        record["matches"] = [match.to_json() for match in answer]
        if not options.json:
            print(_match_table(title, answer, shapes), end="\n\n")
    if options.json:
        print(json.dumps(record))
    # Whoever reads the other end of a pipe gets each answer as soon as it is there.
    sys.stdout.flush()


def _match_table(query: str, matches: list[Match], shapes: int) -> str:
    rows = [("", "similarity", "distance", "evidence", "name", "source")]
    rows += [
        (
            str(rank),
            _shown(match),
            f"{match.distance:.4f}",
            evidence_text(match.evidence),
            match.name,
            match.source,
        )
        for rank, match in enumerate(matches, start=1)
    ]
    ranks, similarities, distances, kinds, names, _ = (
        max(map(len, column)) for column in zip(*rows, strict=True)
    )
    lines = [
        f"{rank:>{ranks}}  {similarity:>{similarities}}  {distance:>{distances}}  {kind:<{kinds}}  "
        f"{name:<{names}}  {source}"
        for rank, similarity, distance, kind, name, source in rows
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
    from shapegoogle_core.model import PRESETS
    from shapegoogle_core.model.training import TrainingShape, train_model

    if options.preset not in PRESETS:
        raise ModelError(f"there is no preset {options.preset!r}; choose one of {', '.join(sorted(PRESETS))}")
    settings = PRESETS[options.preset]
    if options.descriptor:
        settings = settings.with_descriptors(options.descriptor)
    output = Path(options.output)
    if output.is_dir() or not output.parent.is_dir():
        # Better now than after an hour of training.
        raise ModelError(f"cannot write '{output}': name a file in a folder that exists")
    failed: Failures = []
    meshes: defaultdict[str, list[Mesh]] = defaultdict(list)
    for path in progress_bar(_find(options, failed), "reading"):
        try:
            found = read_shapes(path, options.reader)
        except MeshError as error:
            say(f"skipped {path}: {error}")
            failed.append((path, str(error)))
        else:
            failed += [(path, problem) for problem in found.problems]
            for shape in found.shapes:
                if shape.mesh.is_point_cloud:
                    reason = f"{path.name!r} has no faces; a model is learnt from surfaces"
                    say(f"skipped {path}: {reason}")
                    failed.append((path, reason))
                    continue
                identity = path.parent if options.poses else path / shape.object_name
                meshes[str(identity)].append(shape.mesh)
    end_external_readers()
    model = train_model(
        [TrainingShape(identity, tuple(poses)) for identity, poses in sorted(meshes.items())],
        replace(settings, name=output.stem),
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


def _limited(options: Namespace) -> ExternalReader | None:
    """Return the reader with a part of the time limit, so that it is not the worker who is given up."""
    reader: ExternalReader | None = options.reader
    return (
        None
        if reader is None
        else replace(reader, time_limit=0.8 * options.time_limit, memory_limit=options.memory_limit)
    )


def _find(options: Namespace, failed: Failures) -> list[Path]:
    def skip(path: Path, reason: str) -> None:
        say(f"skipped {path}: {reason}")
        failed.append((path, reason))

    return find_meshes(options.inputs, skip, readable_suffixes(options.reader))


def _list_failures(failed: Failures) -> None:
    if failed:
        say(f"{_count(len(failed), 'input')} failed:")
        for path, reason in failed:
            say(f"  {path}: {reason}")


def _count(number: int, noun: str) -> str:
    return f"{number:,} {noun}{'' if number == 1 else 's'}"

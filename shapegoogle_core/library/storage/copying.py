# SPDX-License-Identifier: MIT
"""Copying a library between files and databases: in batches, so that an interrupted copy goes on.

Shapes keep their numbers, so that neighbours, decisions and what people noted stay valid. A mark in the new
library says that it is unfinished; it lasts until everything is there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.storage.records import CopyBatch, NewShape, SourceKey, SourceRecord
from shapegoogle_core.library.storage.signatures import stored_views, unpack_measures, unpack_sample
from shapegoogle_core.library.storage.store import Store, all_codes
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.views import CODE_BYTES, ShapeViews

__all__ = ["CopyReport", "copy_stored"]

# Shapes of one transaction: some ten megabytes.
_SHAPES = 200
_SOURCES = 5_000


@dataclass(frozen=True)
class CopyReport:
    """Outcome of copying a library.

    Attributes
    ----------
    copied : int
        Shapes that were copied by this run.
    shapes, sources, decisions : int
        Numbers in both libraries afterwards.

    Examples
    --------
    >>> import tempfile
    >>> import shapegoogle_core as sg
    >>> import trimesh
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with sg.Library.open(f"{folder}/shapes.sglib") as library:
    ...         _ = library.add(trimesh.creation.icosphere(2), name="ball")
    ...     report = sg.copy_library(f"{folder}/shapes.sglib", f"{folder}/copy.sglib")
    >>> report.copied, report.shapes
    (1, 1)
    """

    copied: int
    shapes: int
    sources: int
    decisions: int


def copy_stored(
    source: Store,
    target: Store,
    model: ShapeModel,
    progress: Callable[[Sequence[int]], Iterable[int]] = iter,
) -> CopyReport:
    """Copy all of a library into a new one, or continue an interrupted copy.

    Parameters
    ----------
    source : Store
        It may be changed by other programs meanwhile.
    target : Store
        New, or an unfinished copy of the same library.
    model : ShapeModel
        Of both.
    progress : callable, optional
        Wraps the loop over the shapes that are missing, as tqdm does.

    Returns
    -------
    report : CopyReport

    Raises
    ------
    LibraryError
        If the target holds another library; if either cannot be read or written.
    """
    _check_target(source, target)
    copied = 0
    roots = tuple((root.name, root.path) for root in source.roots())
    target.put_copy(CopyBatch(mark=source.name, roots=roots))
    while True:
        _copy_sources(source, target)
        missing = _missing(source, target, model)
        if not missing:
            break
        portion: list[int] = []
        for shape_id in progress(missing):
            portion.append(shape_id)
            if len(portion) == _SHAPES or shape_id == missing[-1]:
                batch = _shapes_of(source, model, portion)
                target.put_copy(replace(batch, mark=source.name, last_id=shape_id))
                copied += len(batch.shapes)
                portion = []
    _copy_decisions(source, target)
    target.put_copy(CopyBatch(last_id=source.last_id()))
    return CopyReport(copied, target.count(), len(target.sources()), len(target.decisions()))


def _check_target(source: Store, target: Store) -> None:
    mark = target.copy_mark()
    if mark is None and (target.last_id() or target.sources() or target.roots()):
        raise LibraryError(
            f"'{target.name}' is a library in use; copy into a new one, so that nothing in it is lost"
        )
    if mark is not None and mark != source.name:
        raise LibraryError(
            f"'{target.name}' is an unfinished copy of '{mark}'; continue with that, or choose a new place"
        )


def _copy_sources(source: Store, target: Store) -> None:
    """Bring the sources up to date, and remove those that are gone."""
    known = {record.key: record for record in target.sources()}
    there = {record.key: record for record in source.sources()}
    target.put_copy(
        CopyBatch(
            mark=source.name,
            roots=tuple((root.name, root.path) for root in source.roots()),
            removed_sources=tuple(known.keys() - there.keys()),
        )
    )
    changed = [record for key, record in there.items() if not _equal(known.get(key), record)]
    for start in range(0, len(changed), _SOURCES):
        portion = tuple(changed[start : start + _SOURCES])
        target.put_copy(CopyBatch(mark=source.name, sources=portion))


def _equal(known: SourceRecord | None, record: SourceRecord) -> bool:
    return known is not None and replace(known, path="", shape_count=0) == replace(
        record, path="", shape_count=0
    )


def _missing(source: Store, target: Store, model: ShapeModel) -> list[int]:
    """List the shapes that are still to be copied; those that are gone meanwhile are removed."""
    code_bytes = model.code_bits // 8
    there, _ = all_codes(source, "codes", code_bytes)
    copied, _ = all_codes(target, "codes", code_bytes)
    if len(gone := np.setdiff1d(copied, there)):
        target.remove_shapes(gone.tolist())
    missing: list[int] = np.setdiff1d(there, copied).tolist()
    return missing


def _copy_decisions(source: Store, target: Store) -> None:
    """Bring decisions, and the tags that follow them, up to date, as they are at one moment."""
    known = target.decisions()
    with source.snapshot():
        decisions = source.decisions()
        # Shapes may have been copied before somebody gave them a tag, or took it away.
        tags = _changed_tags(source, target)
    target.put_copy(
        CopyBatch(
            mark=source.name,
            decisions=tuple(decision for decision in decisions if decision not in known),
            removed_decisions=tuple(decision.number for decision in known if decision not in decisions),
            tags=tags,
        )
    )


def _changed_tags(source: Store, target: Store) -> dict[int, tuple[str, ...]]:
    """Return the tags of shapes that have others in the copy, by number."""
    changed: dict[int, tuple[str, ...]] = {}
    last_id = 0
    while copied := target.shapes_after(last_id, _SOURCES):
        last_id = copied[-1].shape_id
        there = {record.shape_id: record.tags for record in source.shapes([one.shape_id for one in copied])}
        changed |= {
            one.shape_id: there[one.shape_id]
            for one in copied
            if there.get(one.shape_id, one.tags) != one.tags
        }
    return changed


def _shapes_of(store: Store, model: ShapeModel, shape_ids: Sequence[int]) -> CopyBatch:
    """Read everything about some shapes."""
    local = model.settings.local
    with store.snapshot():
        records = store.shapes(shape_ids)
        keys = store.shape_keys(shape_ids)
        bags = _by_id(*store.bags(shape_ids, model.bag_size))
        codes = _by_id(*store.codes("codes", shape_ids, model.code_bits // 8))
        words = {} if local is None else _by_id(*store.codes("local_words", shape_ids, local.words // 8))
        view_codes = _by_id(*store.codes("view_codes", shape_ids, CODE_BYTES))
        views = _by_id(*stored_views(store, model, shape_ids))
        samples = store.samples(shape_ids)
        measures = unpack_measures(store, shape_ids)
        placements = store.placements(shape_ids)
        pictures = {shape_id: (store.thumbnail(shape_id), store.preview(shape_id)) for shape_id in shape_ids}
        neighbours = store.neighbours(shape_ids)
    made_by = "" if model.views is None else model.views.identifier
    shapes = []
    for record in records:
        i = record.shape_id
        signature = ShapeSignature(
            bags=bags[i],
            code=codes[i],
            area=record.area,
            vertex_count=record.vertex_count,
            face_count=record.face_count,
            sample=unpack_sample(store, model, i, samples[i]) if i in samples else None,
            local_code=words.get(i),
            extents=record.extents,
            measures=measures.get(i),
            views=ShapeViews(views[i], made_by) if i in views else None,
            view_code=view_codes.get(i),
        )
        thumbnail, preview = pictures[i]
        shape = NewShape(
            signature,
            record.name,
            record.object_name,
            thumbnail,
            record.tags,
            placements.get(i, ()),
            preview=preview,
            origin=record.origin,
        )
        key = SourceKey(keys[i].root, keys[i].path)
        shapes.append((i, key if key.path else None, shape))
    return CopyBatch(shapes=tuple(shapes), neighbours=neighbours)


def _by_id(shape_ids: Iterable[int], rows: Iterable[np.ndarray]) -> dict[int, np.ndarray]:
    return {int(shape_id): row for shape_id, row in zip(shape_ids, rows, strict=True)}

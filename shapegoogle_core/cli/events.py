# SPDX-License-Identifier: MIT
"""Events of a running command for the program that has started it, and their form as JSON.

A command that is started with a message pipe (`shapegoogle_core.processes.messages`) sends them there; with
``--events`` they are printed, one JSON object per line.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from shapegoogle_core.indexing.progress.events import FileOutcome, IndexingProgress, IndexSummary
from shapegoogle_core.indexing.reading.notes import LeftOut
from shapegoogle_core.mesh.io.other_formats import SkippedFormat

__all__ = ["CommandError", "Event", "StepProgress", "event_from_json", "event_to_json", "summary_to_json"]


@dataclass(frozen=True)
class StepProgress:
    """Progress of one step of a command that has several, such as training.

    Attributes
    ----------
    step : str
        Such as "reading".
    done : int
    total : int or None
        None if it is not known.
    """

    step: str
    done: int
    total: int | None = None

    def sentence(self) -> str:
        """Describe the progress for people.

        Returns
        -------
        text : str
            Such as "reading: 3 of 12".
        """
        return f"{self.step}: {self.done:,}" + ("" if self.total is None else f" of {self.total:,}")


@dataclass(frozen=True)
class CommandError:
    """Reason why a command ended without doing its work.

    Attributes
    ----------
    reason : str
        A sentence for the user.
    """

    reason: str


Event = FileOutcome | IndexingProgress | IndexSummary | StepProgress | CommandError

_NAMES: dict[type, str] = {
    FileOutcome: "file",
    IndexingProgress: "progress",
    IndexSummary: "summary",
    StepProgress: "step",
    CommandError: "error",
}
_TYPES: dict[str, Any] = {name: event for event, name in _NAMES.items()}


def event_to_json(event: Event) -> dict[str, Any]:
    """Turn an event into what `json.dumps` takes.

    Parameters
    ----------
    event : Event

    Returns
    -------
    record : dict
        "event" says which kind it is.
    """
    if isinstance(event, FileOutcome):
        record = asdict(event) | {"path": str(event.path)}
    elif isinstance(event, IndexSummary):
        record = summary_to_json(event)
    else:
        record = asdict(event)
    return {"event": _NAMES[type(event)], **record}


def event_from_json(record: Mapping[str, Any]) -> Event:
    """Turn the result of `event_to_json` back into the event.

    Parameters
    ----------
    record : mapping

    Returns
    -------
    event : Event
    """
    values = dict(record)
    kind = values.pop("event")
    if kind == "summary":
        return _summary_from_json(values)
    event: Event = _TYPES[kind](**values)
    if isinstance(event, FileOutcome):
        left_out = tuple(LeftOut(**note) for note in record.get("left_out", ()))
        return replace(event, path=Path(event.path), warnings=tuple(event.warnings), left_out=left_out)
    return event


def summary_to_json(summary: IndexSummary) -> dict[str, Any]:
    """Turn a summary into the object that ``index --json`` prints.

    Parameters
    ----------
    summary : IndexSummary

    Returns
    -------
    record : dict
    """
    return {
        "added": summary.added,
        "updated": summary.updated,
        "unchanged": summary.unchanged,
        "removed": list(summary.removed),
        "excluded": list(summary.excluded),
        "skipped": [asdict(skipped) for skipped in summary.skipped],
        "left_out": {note.kind: note.count for note in summary.left_out},
        "new_shapes": summary.added_shapes + summary.updated_shapes + summary.partial_shapes,
        "added_shapes": summary.added_shapes,
        "updated_shapes": summary.updated_shapes,
        "failed": [{"source": source, "error": reason} for source, reason in summary.failed],
        "warnings": [{"source": source, "warning": sentence} for source, sentence in summary.warnings],
        "shapes": summary.library_shapes,
        "seconds": round(summary.seconds, 3),
        "scene": summary.scene,
    }


def _summary_from_json(record: dict[str, Any]) -> IndexSummary:
    described = record["added_shapes"] + record["updated_shapes"]
    return IndexSummary(
        added=record["added"],
        updated=record["updated"],
        unchanged=record["unchanged"],
        added_shapes=record["added_shapes"],
        updated_shapes=record["updated_shapes"],
        partial_shapes=record["new_shapes"] - described,
        failed=tuple((failure["source"], failure["error"]) for failure in record["failed"]),
        warnings=tuple((warning["source"], warning["warning"]) for warning in record["warnings"]),
        removed=tuple(record["removed"]),
        excluded=tuple(record["excluded"]),
        skipped=tuple(SkippedFormat(**skipped) for skipped in record["skipped"]),
        left_out=tuple(LeftOut(kind, count) for kind, count in record["left_out"].items()),
        library_shapes=record["shapes"],
        seconds=record["seconds"],
        scene=record["scene"],
    )

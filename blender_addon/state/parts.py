# SPDX-License-Identifier: GPL-3.0-or-later
"""What each feature keeps in memory while the add-on is switched on."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from concurrent.futures import Future

    from shapegoogle_core import Match, Mesh, ShapeModel, ShapeSignature
    from shapegoogle_core.processes.worker import Worker
    from shapegoogle_core.worker.requests import Answer

    from ..duplicates.background import BackgroundSearch
    from ..duplicates.follow import Found
    from ..duplicates.link_operator import SHAPEGOOGLE_OT_link_duplicates
    from ..duplicates.operators import SHAPEGOOGLE_OT_find_duplicates
    from ..gallery.compare.shown import Shown
    from ..gallery.editor.dragging import Dragged
    from ..gallery.editor.typed_text import TypedText
    from ..jobs import BackgroundRun
    from ..library.scene_source import SceneIndexing
    from ..replacing.operators import Replaces
    from ..search.operators import SHAPEGOOGLE_OT_find_similar
    from ..signature.distance import TimeRange
    from ..signature.results import Key, Known
    from ..transfer.operators import SHAPEGOOGLE_OT_transfer_match

__all__ = [
    "Asked",
    "DuplicatesState",
    "GalleryState",
    "GalleryView",
    "JobsState",
    "LibraryState",
    "NewObjectsState",
    "ReplacingState",
    "SearchState",
    "SignatureState",
    "TransferState",
]


@dataclass
class JobsState:
    """Processes that this Blender has started.

    Attributes
    ----------
    worker : Worker or None
        The worker process; None until the first task.
    runs : list of BackgroundRun
        Commands that run in other processes.
    to_complete : list of Future
        Tasks that the end of Blender waits for.
    """

    worker: Worker | None = None
    runs: list[BackgroundRun] = field(default_factory=list)
    to_complete: list[Future[Any]] = field(default_factory=list)


@dataclass
class LibraryState:
    """State of indexing, training and loading models.

    Attributes
    ----------
    followed : bool
        Whether the library is looked at every now and then.
    shown : str or None
        The library that what is shown belongs to: its path, or the address of its server.
    indexed : Path or None
        The library that the present or last run of indexing fills.
    file : tuple of int or None
        What tells whether its file was replaced or written since the last look; empty if there is no file,
        None before the first look.
    look : Future or None
        The look that another thread takes at the file.
    forget : list of callable
        What the features do when their results no longer belong to the library.
    notice : list of callable
        What the features do when the library has changed.
    indexing : list of BackgroundRun or SceneIndexing
        Runs that fill the library, the present one first.
    training : BackgroundRun or None
        The run that trains a model.
    model : tuple of (str, float, ShapeModel) or None
        The model loaded last, with the path or name and the time of the file it came from.
    unsaved_name : str
        Source that the open file is until it is saved; empty until it is needed.
    unsaved_in : set of Path
        Libraries that have shapes of the open file under that name.
    renamed : list of (Path, str, str)
        Libraries in which a source still has the first name, though its file was saved under the second.
    opened : int
        How many files were opened.
    tokens : dict of str to str
        Tokens by the addresses of servers, as far as they were read.
    service_model : (str, str) or None
        Address of a server, and the file that its model was downloaded to.
    objects : dict of (str, str) to int
        Session numbers of indexed objects of the open file, by source and the name they had then.
    """

    followed: bool = False
    shown: str | None = None
    indexed: Path | None = None
    file: tuple[int, ...] | None = None
    look: Future[tuple[int, ...] | None] | None = None
    forget: list[Callable[[Any, str], None]] = field(default_factory=list)
    notice: list[Callable[[Any], None]] = field(default_factory=list)
    indexing: list[BackgroundRun | SceneIndexing] = field(default_factory=list)
    training: BackgroundRun | None = None
    model: tuple[str, float, ShapeModel] | None = None
    unsaved_name: str = ""
    unsaved_in: set[Path] = field(default_factory=set)
    renamed: list[tuple[Path, str, str]] = field(default_factory=list)
    opened: int = 0
    tokens: dict[str, str] = field(default_factory=dict)
    service_model: tuple[str, str] | None = None
    objects: dict[tuple[str, str], int] = field(default_factory=dict)


@dataclass(frozen=True)
class Asked:
    """What was searched.

    Attributes
    ----------
    meshes : tuple of Mesh
        The first examples, as they were then.
    stored : tuple of int
        Ids of the others, which are shapes of the library.
    notes : tuple of str
        Translated sentences on what of the selection is not part of the query.
    """

    meshes: tuple[Mesh, ...] = ()
    stored: tuple[int, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass
class SearchState:
    """State of the search.

    Attributes
    ----------
    reading : SHAPEGOOGLE_OT_find_similar or None
        The operator that reads the query in time slices.
    waiting : Future or None
        The query that is being answered.
    answer : Answer or None
        The answer that is shown.
    versions : Answer or None
        The versions of one of its matches, if they are shown.
    before : str
        What was said of the answer shown, for a search that is cancelled.
    examples, coming : list of (str, int)
        Names of the shapes of the query that is answered and of the one that waits, with their number where
        they are from the library; else 0.
    unlike : list of (int, str)
        Examples of shapes that were not meant in the last query.
    refine_at : float
        When the present query is to be answered again because a filter has changed; 0 for never.
    searched : frozenset of int
        Session uids of the objects that the last query was made with.
    file_before, file_wanted : str
        Path of the file that is being left, and of the one that a match was opened in.
    asked_with : Asked
        The examples of the query whose answer is shown.
    asking_with : Asked
        Those of the query that is being answered.
    explained : dict of int to Match
        Matches whose surfaces have been compared, by the id of the shape.
    """

    reading: SHAPEGOOGLE_OT_find_similar | None = None
    waiting: Future[Answer] | None = None
    answer: Answer | None = None
    versions: Answer | None = None
    before: str = ""
    examples: list[tuple[str, int]] = field(default_factory=list)
    coming: list[tuple[str, int]] = field(default_factory=list)
    unlike: list[tuple[int, str]] = field(default_factory=list)
    refine_at: float = 0.0
    searched: frozenset[int] = frozenset()
    file_before: str = ""
    file_wanted: str = ""
    asked_with: Asked = Asked()
    asking_with: Asked = Asked()
    explained: dict[int, Match] = field(default_factory=dict)


@dataclass
class GalleryView:
    """What the large gallery shows beside the matches themselves.

    Attributes
    ----------
    scroll : float
        How far it is scrolled, in pixels.
    hovered : int
        Position of the match under the pointer; -1: none.
    typed : TypedText or None
        The text of the search field while it is typed.
    textures : OrderedDict of int to bpy.types.GPUTexture or None
        Pictures on the graphics card by shape id, the most recently seen last; None for shapes without one.
    comparison : Shown or None
        The two surfaces that are shown in place of the pictures.
    used_at : float
        When the last double click was done with, by `time.monotonic`.
    """

    scroll: float = 0.0
    hovered: int = -1
    used_at: float = 0.0
    typed: TypedText | None = None
    textures: OrderedDict[int, Any] = field(default_factory=OrderedDict)
    comparison: Shown | None = None


@dataclass
class GalleryState:
    """State of the gallery.

    Attributes
    ----------
    pictures : bpy.utils.previews.ImagePreviewCollection or None
        Icons of the shapes shown, by their id.
    placed : set of int
        Session uids of the objects that were appended from this answer.
    numbers : tuple of (int, set of int) or None
        Session uid of the scene and those of its objects; None after a change.
    view : GalleryView
        Of the large gallery.
    dragged : Dragged or None
        The match that is being dragged out of it.
    """

    pictures: Any = None
    placed: set[int] = field(default_factory=set)
    numbers: tuple[int, set[int]] | None = None
    view: GalleryView = field(default_factory=GalleryView)
    dragged: Dragged | None = None


@dataclass
class SignatureState:
    """Results of painting; they are dropped when another file is opened.

    Attributes
    ----------
    results : OrderedDict of Key to Known
        Spectra, words and keypoints of objects, the most recently used last.
    times : dict of int to TimeRange
        Range of times of each painted object, by its session uid.
    charts : bpy.utils.previews.ImagePreviewCollection or None
        Bar charts of bags of words.
    charted : OrderedDict of int to str
        Name of each object's chart by its session uid, the latest last.
    restored_views : list of (str, int)
        Screens and areas whose shading an undo has restored, for a redo.
    """

    results: OrderedDict[Key, Known] = field(default_factory=OrderedDict)
    times: dict[int, TimeRange] = field(default_factory=dict)
    charts: Any = None
    charted: OrderedDict[int, str] = field(default_factory=OrderedDict)
    restored_views: list[tuple[str, int]] = field(default_factory=list)


@dataclass
class DuplicatesState:
    """State of the search for duplicates.

    Attributes
    ----------
    search : BackgroundSearch or None
        The search that runs in the worker process.
    linking : SHAPEGOOGLE_OT_link_duplicates or None
        The linking that runs in time slices.
    collecting : SHAPEGOOGLE_OT_find_duplicates or None
        The comparison of meshes that runs in time slices.
    found : list of Found
        The groups that were found in the scene, as they were then.
    """

    search: BackgroundSearch | None = None
    linking: SHAPEGOOGLE_OT_link_duplicates | None = None
    collecting: SHAPEGOOGLE_OT_find_duplicates | None = None
    found: list[Found] = field(default_factory=list)


@dataclass
class TransferState:
    """State of the transfer.

    Attributes
    ----------
    operator : SHAPEGOOGLE_OT_transfer_match or None
        The one transfer that waits for the worker. It is no property of the session: opening a file ends the
        operator, while the session is carried over to the new file.
    """

    operator: SHAPEGOOGLE_OT_transfer_match | None = None


@dataclass
class ReplacingState:
    """State of replacing meshes.

    Attributes
    ----------
    operator : Replaces or None
        The replacement that waits for the worker; see `TransferState`.
    """

    operator: Replaces | None = None


@dataclass
class NewObjectsState:
    """State of the check of new objects.

    Attributes
    ----------
    known : set of int
        Session uids of the objects that were there at the last check, or when the file was opened.
    task : Future or None
        What the worker does for the check that runs.
    signatures : dict of int to ShapeSignature
        Of the objects that are listed, by their session uid.
    """

    known: set[int] = field(default_factory=set)
    task: Future[Any] | None = None
    signatures: dict[int, ShapeSignature] = field(default_factory=dict)

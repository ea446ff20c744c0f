# SPDX-License-Identifier: GPL-3.0-or-later
"""Tell the library where moved folders are, and let it forget folders and files; no file is ever changed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any, ClassVar

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ..preferences import preferences
from ..state import session_of
from ..translation import counted, error_text, marked, tr
from .address import NEEDS_FILE, is_on_server
from .open_file import is_unsaved, open_source
from .present import is_there, refresh

if TYPE_CHECKING:
    from shapegoogle_core import Library
    from shapegoogle_core.library.roots.missing import ForgetReport
    from shapegoogle_core.library.roots.moving import MoveReport

__all__ = ["register", "unregister"]

WIDTH = 560
# Examples in a dialog; all would not fit the window.
MOST_NAMES = 3
_HERE = marked("This folder exists"), "FILE_FOLDER"
_AWAY = marked("This folder does not exist, or its drive is not connected"), "ERROR"


class _Folders:
    """Folders of the library as items of the dialogs' lists; Blender needs them kept in memory."""

    items: ClassVar[list[tuple[str, str, str, str, int]]] = []
    counts: ClassVar[dict[str, tuple[int, int]]] = {}

    @classmethod
    def read(cls, library: Library) -> None:
        """Read them."""
        cls.counts = {}
        for source in library.sources().values():
            files, shapes = cls.counts.get(source.root, (0, 0))
            cls.counts[source.root] = files + 1, shapes + source.shape_count
        roots = library.roots()
        cls.counts = {root.path: cls.counts.get(root.name, (0, 0)) for root in roots}
        cls.items = [
            (
                root.path,
                f"{root.path} ({_counted(*cls.counts[root.path])})",
                *(_HERE if Path(root.path).is_dir() else _AWAY),
                number,
            )
            for number, root in enumerate(roots)
        ]


def _items(_operator: Any, _context: Any) -> list[tuple[str, str, str, str, int]]:
    return _Folders.items


def _counted(files: int, shapes: int) -> str:
    return f"{_files(files)}, {counted('{count:,} shape', '{count:,} shapes', shapes)}"


class _OnLibrary:
    """Base of the operators that change which files the library knows."""

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there is a library and nothing is written to it."""
        if is_on_server(context):
            cls.poll_message_set(tr(NEEDS_FILE))  # type: ignore[attr-defined]
            return False
        if not is_there(context):
            cls.poll_message_set(tr("Index a library first"))  # type: ignore[attr-defined]
            return False
        if session_of(context).indexing:
            cls.poll_message_set(tr("Wait until indexing has ended, or cancel it"))  # type: ignore[attr-defined]
            return False
        return True

    def call(self, context: Any, function: Any, *, read_only: bool = True) -> Any | None:
        """Call a function with the library; None after a report of an error."""
        from shapegoogle_core import Library, LibraryError

        try:
            with Library.open(preferences(context).library_path(), read_only=read_only) as library:
                return function(library)
        except LibraryError as error:
            self.report({"ERROR"}, error_text(error))  # type: ignore[attr-defined]
            return None

    def dialog(self, context: Any, title: str, confirm: str) -> set[str]:
        """Show the dialog that `draw` lays out."""
        answer: set[str] = context.window_manager.invoke_props_dialog(
            self, width=WIDTH, title=title, confirm_text=confirm
        )
        return answer

    def end(self, context: Any, text: str) -> None:
        """Report what was done."""
        session_of(context).summary = text
        self.report({"INFO"}, text)  # type: ignore[attr-defined]
        count = self.call(context, len)
        session_of(context).shape_count = count or 0
        refresh(context)  # matches and examples may be gone

    def choose_folder(self, context: Any, title: str, confirm: str) -> set[str]:
        """Show the dialog with the folders of the library."""
        if self.call(context, lambda library: _Folders.read(library) or True) is None:
            return {"CANCELLED"}
        if not _Folders.items:
            self.report({"INFO"}, tr("The library has no folders yet"))  # type: ignore[attr-defined]
            return {"CANCELLED"}
        return self.dialog(context, title, confirm)


class SHAPEGOOGLE_OT_move_sources(_OnLibrary, bpy.types.Operator):
    """Tell the library that a folder has been moved or renamed."""

    bl_idname = "shape_google.move_sources"
    bl_label = "Move Sources"
    bl_description = (
        "Tell the library where a folder is now that was moved or renamed, or has another drive letter. "
        "Nothing is read again, and no file is changed"
    )

    root: EnumProperty(name="Folder", items=_items, options={"SKIP_SAVE"})
    old: StringProperty(name="Old Folder", subtype="DIR_PATH", options={"SKIP_SAVE"})
    new: StringProperty(name="New Folder", subtype="DIR_PATH", options={"SKIP_SAVE"})

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Ask for the folder, or show what would be found in its new place."""
        if not self.old:
            return self.choose_folder(
                context, tr("Move Sources: which folder was moved?"), tr("Choose New Folder …")
            )
        report = self.call(context, lambda library: library.move(self.old, self.new, dry_run=True))
        if report is None:
            return {"CANCELLED"}
        self._lines = _move_lines(report)
        return self.dialog(context, tr("Move Sources"), tr("Move"))

    def draw(self, _context: Any) -> None:
        """Lay the dialog out."""
        if not self.old:
            self.layout.column(align=True).prop(self, "root", expand=True)
            return
        column = self.layout.column(align=True)
        column.label(text=tr("From {folder}").format(folder=self.old), translate=False, icon="FILE_FOLDER")
        column.label(text=tr("To {folder}").format(folder=self.new), translate=False, icon="FORWARD")
        for line in self._lines:
            column.label(text=line, translate=False)

    def execute(self, context: Any) -> set[str]:
        """Go on to the new folder, or move."""
        if not self.new:
            old = self.old or self.root
            if bpy.app.background:
                self.report({"ERROR"}, tr("Name both folders: old, and new"))
                return {"CANCELLED"}
            bpy.ops.shape_google.choose_new_folder("INVOKE_DEFAULT", old=old)
            return {"FINISHED"}
        old, new = (bpy.path.abspath(path) for path in (self.old, self.new))
        report = self.call(context, lambda library: library.move(old, new), read_only=False)
        if report is None:
            return {"CANCELLED"}
        _follow(context, old, new)
        text = counted(
            "{count:,} file moved to '{folder}'",
            "{count:,} files moved to '{folder}'",
            len(report.sources),
            folder=new,
        )
        self.end(context, text)
        return {"FINISHED"}


class SHAPEGOOGLE_OT_choose_new_folder(bpy.types.Operator):
    """Choose the folder that one of the library was moved to."""

    bl_idname = "shape_google.choose_new_folder"
    bl_label = "It Is Here Now"
    bl_description = "Take this folder as the new place of the moved one"
    bl_options: ClassVar = {"INTERNAL"}

    old: StringProperty(options={"SKIP_SAVE", "HIDDEN"})
    directory: StringProperty(subtype="DIR_PATH", options={"SKIP_SAVE"})
    filter_folder: BoolProperty(default=True, options={"HIDDEN", "SKIP_SAVE"})

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Ask for it."""
        self.directory = str(_nearest(Path(self.old)))
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, _context: Any) -> set[str]:
        """Show what is found there."""
        new = bpy.path.abspath(self.directory)
        bpy.ops.shape_google.move_sources("INVOKE_DEFAULT", old=self.old, new=new)
        return {"FINISHED"}


class SHAPEGOOGLE_OT_forget_folder(_OnLibrary, bpy.types.Operator):
    """Remove the shapes of a folder from the library."""

    bl_idname = "shape_google.forget_folder"
    bl_label = "Forget Folder"
    bl_description = (
        "Remove the shapes of all files in a folder from the library, whether the folder still exists or "
        "not. The files stay as they are"
    )

    root: EnumProperty(name="Folder", items=_items, options={"SKIP_SAVE"})
    folder: StringProperty(name="Folder", subtype="DIR_PATH", options={"SKIP_SAVE"})

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Ask for the folder."""
        return self.choose_folder(context, tr("Forget Folder"), tr("Forget"))

    def draw(self, _context: Any) -> None:
        """Lay the dialog out."""
        self.layout.column(align=True).prop(self, "root", expand=True)
        column = self.layout.column(align=True)
        text = tr("To forget: {content}").format(content=_counted(*_Folders.counts[self.root]))
        column.label(text=text, translate=False, icon="INFO")
        column.label(text="The files stay as they are. This cannot be undone;")
        column.label(text="Index Library reads the folder again.")

    def execute(self, context: Any) -> set[str]:
        """Forget it."""
        folder = bpy.path.abspath(self.folder or self.root)
        report = self.call(context, lambda library: library.forget(folder), read_only=False)
        if report is None:
            return {"CANCELLED"}
        folders = preferences(context).folders
        off = [item for item in folders if item.use and _below(item.path, folder) is not None]
        for item in off:
            item.use = False  # or the next indexing would bring it back
        template = (
            tr("{content} of '{folder}' forgotten; it is switched off below Sources")
            if off
            else tr("{content} of '{folder}' forgotten")
        )
        content = _counted(len(report.forgotten), report.shape_count)
        self.end(context, template.format(content=content, folder=folder))
        return {"FINISHED"}


class SHAPEGOOGLE_OT_forget_missing(_OnLibrary, bpy.types.Operator):
    """Remove the shapes of files that do not exist any more from the library."""

    bl_idname = "shape_google.forget_missing"
    bl_label = "Forget Missing Files"
    bl_description = (
        "Remove the shapes of files that were deleted, and of files that were never saved, from the library. "
        "Folders that are not connected are left alone"
    )

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Show what would be forgotten."""
        report = self.call(context, _missing)
        if report is None:
            return {"CANCELLED"}
        if not report.forgotten and not report.kept:
            self.report({"INFO"}, tr("No file of the library is missing"))
            return {"CANCELLED"}
        self._report = report
        return self.dialog(context, tr("Forget Missing Files"), tr("Forget"))

    def draw(self, _context: Any) -> None:
        """Lay the dialog out."""
        column, report = self.layout.column(align=True), self._report
        count = _counted(len(report.forgotten), report.shape_count)
        text = tr("To forget, since the files do not exist any more: {content}").format(content=count)
        column.label(text=text, translate=False, icon="INFO")
        if report.forgotten:
            names = _listed([PurePath(path).name for path in report.forgotten])
            column.label(text=names, translate=False)
        for folder, files in report.kept:
            text = counted(
                "{count:,} file stays: {folder} is not here, or empty",
                "{count:,} files stay: {folder} is not here, or empty",
                files,
                folder=folder,
            )
            column.label(text=text, translate=False, icon="ERROR")
        if report.kept:
            column.label(text="If that folder was moved, use Move Sources; if it is gone, Forget Folder.")

    def execute(self, context: Any) -> set[str]:
        """Forget them."""
        report = self.call(context, lambda library: _missing(library, dry_run=False), read_only=False)
        if report is None:
            return {"CANCELLED"}
        content = _counted(len(report.forgotten), report.shape_count)
        stay = sum(files for _, files in report.kept)
        text = tr("{content} forgotten").format(content=content)
        if stay:
            text = counted(
                "{content} forgotten; {count:,} file of folders that are not here stays",
                "{content} forgotten; {count:,} files of folders that are not here stay",
                stay,
                content=content,
            )
        self.end(context, text)
        return {"FINISHED"}


def _missing(library: Library, *, dry_run: bool = True) -> ForgetReport:
    """Forget, or list, the files that do not exist any more, and unsaved files that are not open."""
    gone = library.forget(missing=True, dry_run=dry_run)
    closed = [source for source in library.sources() if is_unsaved(source) and source != open_source()]
    if not closed:
        return gone
    unsaved = library.forget(closed, dry_run=dry_run)
    return replace(
        gone,
        forgotten=(*gone.forgotten, *unsaved.forgotten),
        shape_count=gone.shape_count + unsaved.shape_count,
    )


def _move_lines(report: MoveReport) -> list[str]:
    """Sentences about what is found in the new place."""
    lines = [
        tr("Found there: {found:,} of {files}").format(found=report.found, files=_files(len(report.sources)))
    ]
    if report.missing:
        names = _listed([PurePath(path).name for path in report.missing])
        lines.append(tr("Not there: {names}").format(names=names))
    if report.merged:
        lines.append(
            counted(
                "{count:,} file is in the library at both places; its two entries become one.",
                "{count:,} files are in the library at both places; their two entries become one.",
                len(report.merged),
            )
        )
    return lines


def _files(count: int) -> str:
    return counted("{count:,} file", "{count:,} files", count)


def _listed(names: Sequence[str]) -> str:
    listed = ", ".join(names[:MOST_NAMES])
    if len(names) <= MOST_NAMES:
        return listed
    return tr("{names} and {count} more").format(names=listed, count=len(names) - MOST_NAMES)


def _nearest(folder: Path) -> Path:
    """Return the folder, or the nearest above it that exists: a renamed one is in the same place."""
    return next((path for path in (folder, *folder.parents) if path.is_dir()), Path.home())


def _below(path: str, folder: str) -> str | None:
    from shapegoogle_core.library.roots.paths import absolute_path, relative_to

    return relative_to(absolute_path(path), absolute_path(folder))


def _follow(context: Any, old: str, new: str) -> None:
    """Have the chosen folders and the matches that are shown follow a moved folder."""
    from shapegoogle_core.library.roots.paths import joined

    for item in preferences(context).folders:
        below = _below(item.path, old)
        if below is not None:
            item.path = joined(new, below)
            item.name = Path(item.path).name
            context.preferences.is_dirty = True
    session = session_of(context)
    for match in (*session.matches, *session.versions, *session.examples):
        below = None if is_unsaved(match.source) else _below(match.source, old)
        if below is not None:
            match.source = joined(new, below)


register, unregister = bpy.utils.register_classes_factory(
    (
        SHAPEGOOGLE_OT_move_sources,
        SHAPEGOOGLE_OT_choose_new_folder,
        SHAPEGOOGLE_OT_forget_folder,
        SHAPEGOOGLE_OT_forget_missing,
    )
)

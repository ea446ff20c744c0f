# SPDX-License-Identifier: GPL-3.0-or-later
"""Paint without a window: open a .blend file, write attributes onto its meshes, save a copy."""

from __future__ import annotations

import argparse
import time
import traceback
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy

from ..scene.selection import split_evaluated
from . import painting, results
from .bare_file import BareFile
from .choices import CHANNELS, DETECTORS, KINDS, LAPLACIANS, TIMED, Painting
from .distance import distance_text
from .layers import times_of
from .results import Known

if TYPE_CHECKING:
    from shapegoogle_core import ShapeModel

__all__ = ["main"]

ATTRIBUTES = {kind.lower().replace("_", "-"): kind for kind, _, _ in KINDS}

EPILOG = """\
attributes, on the vertices of each object's own mesh, before modifiers; lengths are in world units:
  hks        sg_hks: the heat kernel signature at one time
  hks-times  sg_hks_1, sg_hks_2 …: at several times from the shortest to the longest
  si-hks     sg_sihks_0, sg_sihks_1 …: the scale-invariant signature, one for each frequency
  words      sg_word and sg_weight_<word>: the geometric word, the soft weights of the most frequent ones
  rgb        sg_hks_1 to sg_hks_3: three times, shown as red, green and blue
  heat       sg_heat: the heat kernel from --vertex
  keypoints  sg_keypoint: how much a vertex that --detector finds stands out, 0 at all others
and sg_color, linear colours of the last --attribute. Loose vertices get 0, and no word: -1.

examples:
  blender -b -P scripts/paint_signatures.py -- horse.blend --output painted.blend
  python scripts/paint_signatures.py horse.blend --output painted.blend --attribute words --object Horse

exit codes:
  0    all objects painted
  1    some objects failed (each is named on stderr); the others are painted and saved
  2    nothing can be done: wrong usage, or a file that cannot be opened or written
  130  interrupted, by Ctrl-C or SIGTERM; nothing was saved
"""


def main(arguments: Sequence[str]) -> int:
    """Run the command.

    Parameters
    ----------
    arguments : sequence of str
        Without the program's name.

    Returns
    -------
    exit_code : int
        See `EPILOG`.

    Raises
    ------
    SystemExit
        With code 2 after wrong usage, 0 after `--help`.
    """
    from shapegoogle_core import ShapeGoogleError
    from shapegoogle_core.cli.command import INTERRUPTED, UNUSABLE

    options = _parser().parse_args(arguments)
    try:
        return _run(options)
    except ShapeGoogleError as error:
        if options.verbose:
            traceback.print_exc()
        _say(f"paint_signatures: {error}")
        return UNUSABLE
    except KeyboardInterrupt:
        _say("paint_signatures: interrupted; nothing was saved")
        return INTERRUPTED


def _sentence(item: Any, error: Exception) -> str:
    if isinstance(error, MemoryError):
        return f"{item.name!r} does not fit into memory; simplify it"
    return str(error)


def _run(options: argparse.Namespace) -> int:
    from shapegoogle_core import MeshError
    from shapegoogle_core.api.text import one_line
    from shapegoogle_core.cli.command import DONE, SOME_FAILED, UNUSABLE
    from shapegoogle_core.cli.text import put

    source, output = Path(options.input), Path(options.output)
    reason = _refusal(source, output)
    if reason:
        _say(f"paint_signatures: {reason}")
        return UNUSABLE
    kinds = [ATTRIBUTES[name] for name in options.attribute or ["hks"]]
    model = _model(options) if "WORDS" in kinds else None
    try:
        opened = BareFile(source.resolve())
    except RuntimeError as error:
        _say(f"paint_signatures: '{source}' cannot be opened: {str(error).strip()}")
        return UNUSABLE
    window = _window()
    open_scene, open_layer = window.scene, window.view_layer
    failed: list[str] = []
    number = count = 0
    for number, item in enumerate(_objects(options.object, failed), start=1):
        started = time.monotonic()
        try:
            notes = [_paint(item, _painting(options, kind), model, options) for kind in kinds]
        except (MeshError, MemoryError) as error:
            if options.verbose:
                traceback.print_exc()
            failed.append(_sentence(item, error))
            _say(f"{number}: {item.name}: failed")
            continue
        count += 1
        seconds = time.monotonic() - started
        vertices = len(item.data.vertices)
        _say(f"{number}: {item.name}: {', '.join(notes)}; {vertices:,} vertices, {seconds:.1f} s")
    if count:
        window.scene, window.view_layer = open_scene, open_layer
        try:
            opened.save(output.resolve())
        except RuntimeError as error:
            _say(f"paint_signatures: '{output}' cannot be written: {str(error).strip()}")
            return UNUSABLE
        put(f"{one_line(str(output))}: {count} of {number} objects painted")
    else:
        _say(f"paint_signatures: no object of '{source}' was painted, so '{output}' was not written")
    if failed:
        _say(f"{len(failed)} failed:")
        for reason in failed:
            _say(f"  {reason}")
    return DONE if count and not failed else SOME_FAILED


def _refusal(source: Path, output: Path) -> str:
    """Why these files cannot be used; empty if they can."""
    if not source.is_file():
        return f"there is no file '{source}'"
    for path in (source, output):
        if path.suffix.lower() != ".blend":
            return f"'{path}' is no .blend file; only those hold attributes"
    if output.resolve() == source.resolve() or (output.exists() and output.samefile(source)):
        return f"'{output}' is the file that is read; name another one for --output"
    if output.is_dir() or not output.resolve().parent.is_dir():
        return f"cannot write '{output}'; name a file in a folder that exists"
    return ""


def _model(options: argparse.Namespace) -> ShapeModel:
    from shapegoogle_core import Library, load_model

    if options.library is None:
        return load_model(options.model)
    with Library.open(options.library, read_only=True) as library:
        return library.model


def _window() -> Any:
    """Return the window of the context, by way of its owner.

    Where a script or another add-on has asked Blender 4.2 or 4.3 for ``context.tool_settings``, what the
    context gives belongs to the scene of that time; to set a property of it after another file was opened
    is to write to a scene that is gone.
    """
    return bpy.context.window_manager.windows[0]


def _objects(names: Sequence[str] | None, failed: list[str]) -> Iterator[Any]:
    """Yield the chosen meshes while their scene is open, since their scale is unknown otherwise."""
    missing = dict.fromkeys(names or [])
    seen: set[Any] = set()
    hidden: dict[Any, str] = {}
    window = _window()
    for scene in bpy.data.scenes:
        window.scene = scene
        for layer in scene.view_layers:
            window.view_layer = layer
            for item in layer.objects:
                item.update_tag()  # Blender 4 would leave those of another scene without their scale
            layer.update()
            wanted = [item for item in layer.objects if names is None or item.name in names]
            shown, disabled = split_evaluated(wanted, bpy.context)
            hidden.update((item, item.name) for item in disabled if item.type == "MESH")
            items, refused = painting.targets(shown)
            for item in wanted:
                missing.pop(item.name, None)
                if item.type != "MESH" and names is not None:
                    refused.append(f"{item.name!r} is no mesh")
            failed += [reason for reason in refused if reason not in failed]
            for item in items:
                if item.data not in seen:
                    seen.add(item.data)
                    yield item
    # Another view layer may have shown them, or another object their mesh.
    left_out = [name for item, name in hidden.items() if item.data not in seen]
    if names is not None:
        failed += [f"{name!r} is disabled in viewports; enable it first" for name in left_out]
    elif left_out:
        _say(f"left out, as they are disabled in viewports: {', '.join(left_out)}")
    failed += [f"{name!r} is in no scene of the file" for name in missing]


def _paint(item: Any, chosen: Painting, model: ShapeModel | None, options: argparse.Namespace) -> str:
    """Paint one attribute; return a note on it."""
    key = results.key_of(item, chosen, model)
    entry = results.known(key)
    if entry is None:
        task = results.task_of(item, chosen, model, key)
        entry = results.remember(task, task.function(*task.arguments))
    if chosen.kind == "HEAT" and options.vertex is not None and options.vertex >= len(item.data.vertices):
        from shapegoogle_core import MeshError

        last = len(item.data.vertices) - 1
        raise MeshError(f"{item.name!r} has no vertex {options.vertex}; its last one is {last}")
    painting.apply(item, chosen, entry, color=not options.no_color, keep=True, source=options.vertex)
    return _note(chosen, entry, bpy.context.scene.unit_settings)


def _note(chosen: Painting, entry: Known, units: Any) -> str:
    from shapegoogle_core import VertexSpectrum, VertexWords

    name = chosen.kind.lower().replace("_", "-")
    if isinstance(entry.result, VertexWords):
        return f"{name} of {chosen.channel}"
    if not isinstance(entry.result, VertexSpectrum):
        return f"{len(entry.result)} {name} of {chosen.detector}"
    if chosen.kind not in TIMED:
        return name
    time_taken = times_of(chosen, entry.result.spectrum)[0]
    return f"{name} at t = {time_taken:.4g} ({distance_text(time_taken**0.5, entry.size, units)})"


def _painting(options: argparse.Namespace, kind: str) -> Painting:
    return Painting(
        kind=kind,
        scale=options.scale,
        time=options.time,
        count=options.times,
        frequencies=options.frequencies,
        channel=options.words,
        weights=options.weights,
        detector=options.detector,
        eigenpairs=options.eigenpairs,
        laplacian=options.laplacian,
        budget=options.simplify_above or None,
    )


def _parser() -> argparse.ArgumentParser:
    from shapegoogle_core.cli.arguments import number_from, positive_number, share

    parser = argparse.ArgumentParser(
        prog="paint_signatures",
        description="Write heat kernel signatures, geometric words and keypoints onto the meshes of a .blend "
        "file, in a copy.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("input", metavar="IN.blend", help="file to read; it is never changed, and its scripts do not run")
    add("--output", required=True, metavar="OUT.blend", help="file to write; an existing one is replaced")
    add(
        "--attribute",
        action="append",
        choices=tuple(ATTRIBUTES),
        help="attribute to write (hks); can be given several times",
    )
    add("--object", action="append", metavar="NAME", help="only this object; can be given several times")
    times = parser.add_mutually_exclusive_group()
    times.add_argument(
        "--scale",
        type=share,
        default=0.5,
        metavar="S",
        help="place of the time between the shortest, 0, and the longest meaningful one, 1 (%(default)s)",
    )
    times.add_argument(
        "--time", type=positive_number, metavar="T", help="the time itself, in squared world units"
    )
    add(
        "--times",
        type=number_from(1),
        default=6,
        metavar="N",
        help="how many times for hks-times (%(default)s)",
    )
    add(
        "--frequencies", type=number_from(1), default=6, metavar="N", help="how many for si-hks (%(default)s)"
    )
    add(
        "--vertex",
        type=number_from(0),
        metavar="I",
        help="where heat spreads from (default: the selected vertex)",
    )
    add(
        "--words",
        choices=[channel for channel, _, _ in CHANNELS],
        default="hks",
        help="of which descriptor (%(default)s)",
    )
    add("--weights", type=number_from(0), default=4, metavar="N", help="how many soft weights (%(default)s)")
    add(
        "--detector",
        choices=[name for name, _, _ in DETECTORS],
        default="hks-maxima",
        help="of keypoints (%(default)s)",
    )
    models = parser.add_mutually_exclusive_group()
    models.add_argument("--library", metavar="FILE", help="take the words from the model of this library")
    models.add_argument("--model", metavar="FILE", help="or from this model: a file, 'default' or 'paper'")
    add(
        "--eigenpairs",
        type=number_from(1),
        default=100,
        metavar="N",
        help="size of the spectrum (%(default)s)",
    )
    add("--laplacian", choices=[name for name, _, _ in LAPLACIANS], default="robust", help="(%(default)s)")
    add(
        "--simplify-above",
        type=number_from(0),
        default=20_000,
        metavar="N",
        help="compute meshes of more vertices on a copy simplified to this many; 0: never (%(default)s)",
    )
    add("--no-color", action="store_true", help="write no sg_color")
    add("-v", "--verbose", action="store_true", help="show where in the program an error arose")
    return parser


def _say(text: str) -> None:
    from shapegoogle_core.cli.text import say

    say(text)

# SPDX-License-Identifier: MIT
"""Learn a model from your own shapes.

Training needs at least 8 different shapes, better 100 varied ones, and about a second per version.
Use the model for a new library: shapegoogle index FOLDER --library FILE --model MODEL.npz

--descriptor  the descriptor of each surface point: hks, log-hks or si-hks with the preset's parameters;
              gps, geodesic-histogram or volumetric-hks, which hardly change with the pose either;
              or spin-images, shape-context or mesh-hog, which do change with the pose

for example:
  shapegoogle train ~/models --output mine.npz
  shapegoogle train ~/models --output rigid.npz --descriptor spin-images --descriptor hks
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from shapegoogle_core.api.text import one_line
from shapegoogle_core.cli.arguments import add_flag, add_inputs, add_jobs, add_value, number_from
from shapegoogle_core.cli.command import DONE, SOME_FAILED, Command
from shapegoogle_core.cli.inputs import Failures, find_files, list_failures, skip
from shapegoogle_core.cli.steps import StepReporter
from shapegoogle_core.cli.text import counted, put, say
from shapegoogle_core.errors import MeshError, ModelError

if TYPE_CHECKING:
    from shapegoogle_core.mesh import Mesh

__all__ = ["COMMAND"]


def _add_options(parser: argparse.ArgumentParser) -> None:
    add_inputs(parser)
    parser.add_argument("--output", required=True, metavar="MODEL.npz", help="file to write the model to")
    add_value(parser, "--preset", "NAME", "settings: 'default' or 'paper'", default="default")
    descriptors = "replace the preset's descriptors, see below; may be given more than once"
    parser.add_argument("--descriptor", action="append", metavar="NAME", help=descriptors)
    add_flag(parser, "--poses", "the files of one folder are one shape in several poses")
    versions = "number of transformed versions of each shape to learn from (%(default)s)"
    add_value(parser, "--versions", "N", versions, number_from(1), 10)
    add_value(parser, "--seed", "N", "seed of all random choices (%(default)s)", int, 0)
    add_jobs(parser)


def _run(options: argparse.Namespace) -> int:
    from shapegoogle_core.model import PRESETS
    from shapegoogle_core.model.training import TrainingShape, train_model
    from shapegoogle_core.processes.launching import default_jobs

    if options.preset not in PRESETS:
        raise ModelError(f"there is no preset {options.preset!r}; choose one of {', '.join(sorted(PRESETS))}")
    settings = PRESETS[options.preset]
    if options.descriptor:
        settings = settings.with_descriptors(options.descriptor)
    output = Path(options.output)
    if output.is_dir() or not output.parent.is_dir():
        # Fail now rather than after an hour of training.
        raise ModelError(f"cannot write '{output}': name a file in a folder that exists")
    failed: Failures = []
    meshes = _read_meshes(options, failed)
    model = train_model(
        [TrainingShape(identity, tuple(poses)) for identity, poses in sorted(meshes.items())],
        replace(settings, name=output.stem),
        versions=options.versions,
        jobs=options.jobs or default_jobs(),
        seed=options.seed,
        trained_on=f"{counted(len(meshes), 'shape')} of the user's, seed {options.seed}",
        progress=StepReporter(options.send),
    )
    model.save(output)
    size = output.stat().st_size
    source = f"from {counted(len(meshes), 'shape')}"
    put(f"{one_line(str(output))}: model {model.identifier}, {size:,} bytes, {source}")
    list_failures(failed)
    return SOME_FAILED if failed else DONE


def _read_meshes(options: argparse.Namespace, failed: Failures) -> dict[str, list[Mesh]]:
    """Read the surfaces of all inputs, grouped by shape: with ``--poses`` by folder."""
    from shapegoogle_core.indexing import ShapeReader

    progress = StepReporter(options.send)
    paths = find_files(options, failed)
    meshes: defaultdict[str, list[Mesh]] = defaultdict(list)
    with ShapeReader(options.reader) as reader:
        for path in progress(paths, "reading", len(paths)):
            try:
                found = reader.read(path)
            except MeshError as error:
                skip(path, str(error), failed)
                continue
            failed += [(path, problem) for problem in found.problems]
            for warning in found.warnings:
                say(f"warning: {path}: {warning}")
            for shape in found.shapes:
                if shape.mesh.is_point_cloud:
                    skip(path, f"{path.name!r} has no faces; a model is learnt from surfaces", failed)
                    continue
                identity = path.parent if options.poses else path / shape.object_name
                meshes[str(identity)].append(shape.mesh)
    return meshes


COMMAND = Command("train", str(__doc__), _add_options, _run, reads_files=True)

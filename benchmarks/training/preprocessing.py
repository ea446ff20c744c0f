# SPDX-License-Identifier: MIT
"""Give the shipped default model the preprocessing of its preset, without learning anything anew.

    python -m benchmarks set-preprocessing

Words, metric and codes stay; the bags of a shape change with its preprocessed surface, so the model gets
another identifier. Parts of a model that are made from bags must be learnt again afterwards.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

from benchmarks.training.models import SHIPPED
from shapegoogle_core.model import PRESETS, load_model

__all__ = ["add_options", "run"]


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the subcommand: there are none.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """


def run(_options: argparse.Namespace) -> int:
    """Change the model and save it.

    Parameters
    ----------
    _options : argparse.Namespace
        As from `add_options`.

    Returns
    -------
    exit_code : int
    """
    path = SHIPPED / "default.npz"
    model = load_model(path)
    settings = replace(model.settings, preprocessing=PRESETS["default"].preprocessing)
    changed = replace(model, settings=settings)
    changed.save(path)
    print(f"{path}: {model.identifier} is now {changed.identifier}")
    return 0

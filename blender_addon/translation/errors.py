# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors of the add-on whose messages are translated."""

from __future__ import annotations

__all__ = ["TextError"]


class TextError(Exception):
    """An error of the add-on, for modules that must not import the core when they are registered.

    Parameters
    ----------
    template : str
        One sentence in English; values stand in it as their names in braces.
    **values : object
        Values of the sentence.
    """

    def __init__(self, template: str, **values: object) -> None:
        super().__init__(template.format(**values) if values else template)
        self.template = template
        self.values = values

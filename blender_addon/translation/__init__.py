# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on's texts in other languages, shown by Blender's own translation.

Blender translates by itself what it draws: labels and descriptions of classes and properties, items of enums,
and ``text=``, ``heading=`` and ``placeholder=`` of a layout. All other texts go through `tr`, `counted` or
`error_text`. Sentences with values are templates, which are filled in after they were translated::

    self.report({"INFO"}, tr("Appended {name}").format(name=item.name))
    layout.label(text=counted("{count:,} shape", "{count:,} shapes", count))
    layout.label(text=item.name, translate=False)  # a name may be a word of Blender

A language is a module or package of this folder.
"""

from __future__ import annotations

import importlib
import pkgutil
from typing import TYPE_CHECKING, Any, Protocol

import bpy

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

__all__ = [
    "LANGUAGES",
    "OWN_CONTEXT",
    "countable",
    "counted",
    "error_text",
    "marked",
    "register",
    "tr",
    "unregister",
]


class Language(Protocol):
    """What the module of a language defines.

    Attributes
    ----------
    LOCALE : str
        Blender's name of the language, such as "de", or "pt_BR" where a country matters.
    TEXTS : mapping of str to str
        The translation of each English text.
    OPERATORS : mapping of str to str
        For those texts that are translated otherwise where they are on the button of an operator.
    COUNTED : mapping of str to sequence of str
        For each English text about one thing, the forms of it that the language has for numbers.
    """

    LOCALE: str
    TEXTS: Mapping[str, str]
    OPERATORS: Mapping[str, str]
    COUNTED: Mapping[str, Sequence[str]]

    def form(self, count: int) -> int:
        """Return which of the forms in `COUNTED` belongs to a number."""


LANGUAGES: tuple[Any, ...] = tuple(
    importlib.import_module(f"{__package__}.{found.name}")
    for found in pkgutil.iter_modules(__path__)
    if found.name != "errors"
)

OWN_CONTEXT = "Shape Google"
"""Context for words that Blender itself translates in another sense: ``bl_translation_context``."""

# Contexts of messages: of everything, of buttons, and of the forms for numbers.
_ANYWHERE, _OPERATOR = "*", "Operator"


def tr(text: str) -> str:
    """Translate a text into the language of Blender's interface.

    Parameters
    ----------
    text : str
        English, literally: the names of values stand in it in braces.

    Returns
    -------
    text : str
        In English if it has no translation, or the user does not want the interface translated.
    """
    return str(bpy.app.translations.pgettext_iface(text))


def marked(text: str) -> str:
    """Return a text as it is, to be translated where it is shown: it marks texts in constants.

    Parameters
    ----------
    text : str

    Returns
    -------
    text : str
    """
    return text


def countable(one: str, many: str) -> tuple[str, str]:
    """Return two texts as they are, for `counted`: it marks texts in constants.

    Parameters
    ----------
    one, many : str
        As for `counted`.

    Returns
    -------
    one, many : str
    """
    return one, many


def counted(one: str, many: str, count: int, **values: Any) -> str:
    """Translate a text about a number of things, and fill the number in.

    Parameters
    ----------
    one, many : str
        English, literally: the text for one thing and for any other number; both have the same values in
        braces, and ``{count}`` or ``{count:,}`` where the number is shown.
    count : int
    **values : object
        Other values of the text.

    Returns
    -------
    text : str
    """
    text = one if count == 1 else many
    locale = bpy.app.translations.locale
    for language in LANGUAGES:
        if locale == language.LOCALE or locale.partition("_")[0] == language.LOCALE:
            form = bpy.app.translations.pgettext_iface(one, _form_context(language.form(count)))
            # Blender returns the text itself if the interface is not to be translated.
            text = text if form == one else form
    return text.format(count=count, **values)


def error_text(error: BaseException) -> str:
    """Translate the message of an error.

    Parameters
    ----------
    error : Exception
        The errors of the core and of the add-on that artists meet keep the template and the values of
        their message; all others remain in English.

    Returns
    -------
    text : str
    """
    template = getattr(error, "template", None)
    if template is None:
        return str(error)
    values = {
        name: error_text(value) if isinstance(value, BaseException) else value
        for name, value in getattr(error, "values", {}).items()
    }
    return tr(template).format(**values) if values else tr(template)


def _form_context(form: int) -> str:
    return f"Number {form}"


def _messages(language: Language) -> dict[tuple[str, str], str]:
    """Return the texts of a language in the order of Blender's: by context and English text."""
    messages = {(_ANYWHERE, text): translated for text, translated in language.TEXTS.items()}
    for context in (_OPERATOR, OWN_CONTEXT):
        messages |= {(context, text): translated for text, translated in language.TEXTS.items()}
    messages |= {(_OPERATOR, text): translated for text, translated in language.OPERATORS.items()}
    for text, forms in language.COUNTED.items():
        messages |= {(_form_context(number), text): form for number, form in enumerate(forms)}
    return messages


def register() -> None:
    """Give Blender the texts."""
    bpy.app.translations.register(
        __package__, {language.LOCALE: _messages(language) for language in LANGUAGES}
    )


def unregister() -> None:
    """Take the texts back."""
    bpy.app.translations.unregister(__package__)

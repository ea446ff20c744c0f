# SPDX-License-Identifier: MIT
"""Every text of the add-on is translated, completely and with the same values."""

from __future__ import annotations

import importlib
import re
import string
from collections.abc import Iterator
from types import ModuleType
from typing import Any

import bpy
import pytest

from tests.addon.translation.texts import OPERATOR, find_texts, find_unmarked

# What the classes of add-ons inherit from, and what Blender names itself in each of them.
BASES = ("AddonPreferences", "Menu", "NodeTree", "Operator", "Panel", "PropertyGroup", "UIList")
OWN_PROPERTIES = {"rna_type", "name", "bl_idname"}


@pytest.fixture(scope="module")
def languages(addon: ModuleType) -> Any:
    return importlib.import_module(f"{addon.__name__}.translation").LANGUAGES


def fields(text: str) -> list[tuple[str, str | None, str | None]]:
    """Return the values that a template shows, and how."""
    return sorted(
        (name, spec, conversion)
        for _, name, spec, conversion in string.Formatter().parse(text)
        if name is not None
    )


def test_every_sentence_can_be_translated() -> None:
    unmarked = find_unmarked()
    assert not unmarked, "not translated; see CONTRIBUTING.md:\n" + "\n".join(unmarked)


def test_every_text_has_its_translation(languages: Any) -> None:
    texts = [text for text in find_texts() if text.text]
    for language in languages:
        known = {**language.TEXTS, **language.COUNTED}
        missing = sorted(
            f"    {text.text!r}: '',  # {text.where}" for text in texts if text.text not in known
        )
        assert not missing, f"add to {language.__name__}:\n" + "\n".join(sorted(missing))
        shown = {text.text for text in texts}
        unused = sorted(text for text in known if text not in shown)
        assert not unused, (
            f"remove from {language.__name__}, as the add-on does not show them any more: {unused}"
        )
        buttons = {text.text for text in texts if text.context == OPERATOR}
        assert language.OPERATORS.keys() <= buttons & language.TEXTS.keys()
        one = {text.text for text in texts if text.many}
        assert language.COUNTED.keys() == one


def test_translations_show_the_same_values(languages: Any) -> None:
    many = {text.text: text.many for text in find_texts() if text.many}
    for language in languages:
        for text, translated in [*language.TEXTS.items(), *language.OPERATORS.items()]:
            assert translated.strip() == translated, text
            assert fields(text) == fields(translated), text
            assert text[-1:] not in "….:" or text[-1] == translated[-1], text
            assert text.count("\n") == translated.count("\n"), text
        for text, forms in language.COUNTED.items():
            allowed = (fields(text), fields(many[text]))
            assert all(fields(form) in allowed for form in forms), text
            assert {language.form(count) for count in range(1000)} == set(range(len(forms)))


@pytest.mark.skipif(
    not bpy.app.build_options.international, reason="needs a Blender that speaks other languages"
)
def test_blender_shows_the_translations(addon: ModuleType, languages: Any) -> None:
    translation = importlib.import_module(f"{addon.__name__}.translation")
    view = bpy.context.preferences.view
    before = view.language
    try:
        view.language = "de_DE"
        german = next(language for language in languages if language.LOCALE == "de")
        assert translation.tr("Appended {name}") == german.TEXTS["Appended {name}"]
        one, many = german.COUNTED["{count:,} shape"]
        for count, form in ((1, one), (2000, many)):
            said = translation.counted("{count:,} shape", "{count:,} shapes", count)
            assert said == form.format(count=count)
        view.language = "en_US"
        assert translation.tr("Appended {name}") == "Appended {name}"
        assert translation.counted("{count:,} shape", "{count:,} shapes", 1) == "1 shape"
    finally:
        view.language = before


def own_classes() -> list[Any]:
    """Return the add-on's classes that are registered."""
    classes = [kind for name in BASES for kind in getattr(bpy.types, name).__subclasses__()]
    return [kind for kind in classes if kind.__name__.startswith("SHAPEGOOGLE_") and kind.is_registered]


def registered_texts() -> Iterator[tuple[str, str]]:
    """Return what Blender knows of the add-on's classes, and whose it is."""
    for kind in own_classes():
        rna = kind.bl_rna
        if "_OT_" in kind.__name__:  # its properties are registered under another name
            rna = getattr(bpy.ops.shape_google, kind.bl_idname.partition(".")[2]).get_rna_type()
            yield rna.name, kind.__name__
            if not hasattr(kind, "description"):
                yield rna.description, kind.__name__
        elif hasattr(kind, "bl_label"):
            yield kind.bl_label, kind.__name__
        own = getattr(kind, "__annotations__", {})
        for base in kind.__mro__:
            own = {**own, **getattr(base, "__annotations__", {})}
        for entry in rna.properties:
            name = entry.identifier
            if name not in own or name in OWN_PROPERTIES or name.startswith("bl_"):
                continue
            where = f"{kind.__name__}.{entry.identifier}"
            if entry.name != entry.identifier:
                yield entry.name, where
            yield entry.description, where
            if entry.type == "ENUM":
                for item in entry.enum_items:
                    yield item.name, where
                    yield item.description, where


def test_the_source_has_all_texts_that_blender_knows(addon: ModuleType) -> None:
    """What was found in the source is what Blender shows: none was overlooked."""
    texts = {text.text for text in find_texts()}
    shown = {(text, where) for text, where in registered_texts() if re.search("[A-Za-z]", text)}
    assert len(shown) > 200
    overlooked = sorted(f"{where}: {text!r}" for text, where in shown if text not in texts)
    assert not overlooked, "\n".join(overlooked)

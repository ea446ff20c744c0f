# SPDX-License-Identifier: MIT
"""Find the texts of the add-on in its source: those that are translated, and those that should be."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
ADDON = ROOT / "blender_addon"
CORE = ROOT / "shapegoogle_core"
# What they write is read by programs, or by people on a command line, which is in English.
CONSOLE = ("commands.py", "connections.py", "reading/", "signature/command.py", "translation/")

ANYWHERE, OPERATOR = "*", "Operator"
# Keywords of layouts and properties whose texts Blender translates.
SHOWN = ("text", "heading", "placeholder", "name", "description", "title", "confirm_text", "message")
PROPERTY = re.compile(r"(Bool|Collection|Enum|Float|FloatVector|Int|IntVector|Pointer|String)Property")
# Two words, or a word next to a value: what a person reads, unlike identifiers and separators.
SENTENCE = re.compile(r"[A-Za-z]{2,}[,:;…]? +(\S* )?[A-Za-z(]")
BESIDE_VALUE = re.compile(r"[A-Za-z]{3,}[,:;]? |[ (][A-Za-z]{3,}")
# Names, and identifiers that have spaces.
NO_TEXTS = (
    *("Shape Google", "Unsaved file ", "same kind", "nothing in common"),
    *("not a match", "keep both", "no tag", "Node Editor"),
)


@dataclass(frozen=True)
class Text:
    """A text that is translated.

    Attributes
    ----------
    text : str
    context : str
        Blender's context of messages: that of buttons, or that of everything else.
    where : str
        File and line.
    many : str
        The text for other numbers than one; empty if the text is not about a number.
    """

    text: str
    context: str
    where: str
    many: str = ""


@cache
def find_texts() -> list[Text]:
    """Find all texts that are translated, of the add-on and of the core's errors."""
    found = [text for path in sorted(ADDON.rglob("*.py")) for text in _texts_of(path)]
    for path in sorted(CORE.rglob("*.py")):
        # Few files have such errors; parsing all would take seconds.
        if re.search(r'Error\(\s*"|"\'\{path\}\' ', path.read_text(encoding="utf-8")):
            found += _errors_of(path, with_values=True)
    return found


def find_unmarked() -> list[str]:
    """Find sentences that no translation reaches, each with its place."""
    return [line for path in sorted(ADDON.rglob("*.py")) for line in _unmarked_in(path)]


def _is_console(path: Path) -> bool:
    return path.relative_to(ADDON).as_posix().startswith(CONSOLE)


@cache
def _tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def _place(path: Path, node: ast.AST) -> str:
    return f"{path.relative_to(ROOT).as_posix()}:{getattr(node, 'lineno', 0)}"


def _called(node: ast.Call) -> str:
    """Return the last part of the name of what is called."""
    return getattr(node.func, "attr", "") or getattr(node.func, "id", "")


def _literal(node: ast.AST | None) -> str:
    """Return the text of a literal that has a letter in it; empty for anything else."""
    if not isinstance(node, ast.Constant) or not isinstance(node.value, str):
        return ""
    # The name of a class is an identifier.
    is_text = re.search("[A-Za-z]", node.value) and not node.value.startswith("SHAPEGOOGLE_")
    return node.value if is_text else ""


def _branches(node: ast.AST) -> Iterator[ast.AST]:
    """Return the texts that an expression chooses from."""
    if isinstance(node, ast.IfExp):
        yield from _branches(node.body)
        yield from _branches(node.orelse)
    else:
        yield node


def _texts_of(path: Path) -> Iterator[Text]:
    if _is_console(path):
        return
    tree = _tree(path)
    for line in tree.body:
        if isinstance(line, ast.Assign):
            yield from _item_texts(line.value, path)
    yield from _errors_of(path, with_values=False)
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef):
            yield from _class_texts(node, path)
        elif isinstance(node, ast.Call):
            name = _called(node)
            if name in ("tr", "marked", "counted", "countable") and len(node.args) > name.startswith("count"):
                for branch in _branches(node.args[0]):
                    many = _literal(node.args[1]) if name.startswith("count") else ""
                    yield Text(_literal(branch), ANYWHERE, _place(path, node), many)
            elif PROPERTY.fullmatch(name) or isinstance(node.func, ast.Attribute):
                yield from _keyword_texts(node, path)


def _class_texts(node: ast.ClassDef, path: Path) -> Iterator[Text]:
    is_operator = "_OT_" in node.name
    described = False
    for line in node.body:
        described |= isinstance(line, ast.FunctionDef) and line.name == "description"
        if not isinstance(line, ast.Assign | ast.AnnAssign):
            continue
        target = line.targets[0] if isinstance(line, ast.Assign) else line.target
        if not isinstance(target, ast.Name):
            continue
        if target.id == "bl_label" and (text := _literal(line.value)):
            yield Text(text, OPERATOR if is_operator else ANYWHERE, _place(path, line))
        if target.id == "bl_category" and (text := _literal(line.value)):
            yield Text(text, ANYWHERE, _place(path, line))
        if target.id == "bl_description":
            described = True
            yield Text(_literal(line.value), ANYWHERE, _place(path, line))
    if is_operator and not described:
        yield Text(ast.get_docstring(node) or "", ANYWHERE, _place(path, node))


def _keyword_texts(node: ast.Call, path: Path) -> Iterator[Text]:
    name = _called(node)
    keywords = {keyword.arg: keyword.value for keyword in node.keywords if keyword.arg}
    translate = keywords.get("translate")
    if isinstance(translate, ast.Constant) and translate.value is False:
        return
    context = OPERATOR if name in ("operator", "operator_menu_enum") else ANYWHERE
    for key in SHOWN:
        if key in keywords and (text := _literal(keywords[key])):
            yield Text(text, context, _place(path, node))
    if name == "EnumProperty" and "items" in keywords:
        yield from _item_texts(keywords["items"], path)


def _item_texts(items: ast.AST, path: Path) -> Iterator[Text]:
    """Return the labels and descriptions of the items of an enum, if a literal is a list of them, or one."""
    if not isinstance(items, ast.Tuple | ast.List):
        return
    parts = items.elts[:3]
    if len(parts) == 3 and all(isinstance(part, ast.Constant) for part in parts):
        _, label, description = map(_literal, parts)
        # Other lists of three words, such as `__all__`, have no sentences.
        if label[:1].isupper() and (" " in description or not description):
            yield Text(label, ANYWHERE, _place(path, items))
            if description:
                yield Text(description, ANYWHERE, _place(path, items))
        return
    for item in items.elts:
        yield from _item_texts(item, path)


def _errors_of(path: Path, *, with_values: bool) -> Iterator[Text]:
    """Return the messages of errors that keep their template; in the core only those with values."""
    if with_values:
        # Messages in constants of the core begin with the path of a library.
        for node in ast.walk(_tree(path)):
            if (text := _literal(node)).startswith("'{path}' "):
                yield Text(text, ANYWHERE, _place(path, node))
    for node in ast.walk(_tree(path)):
        if isinstance(node, ast.Call) and _called(node).endswith("Error") and node.args:
            text = _literal(node.args[0])
            if text and (node.keywords or not with_values) and re.search("[a-z]", re.sub("{.*?}", "", text)):
                yield Text(text, ANYWHERE, _place(path, node))


def _unmarked_in(path: Path) -> Iterator[str]:
    if _is_console(path):
        return
    tree = _tree(path)
    translated = {text for each in _texts_of(path) for text in (each.text, each.many)}
    inner: set[int] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            inner.add(id(node.value))  # a docstring
        if isinstance(node, ast.JoinedStr):
            inner |= {id(part) for part in ast.walk(node) if part is not node}
        # Identifiers that have spaces, such as kinds of evidence.
        if isinstance(node, ast.Compare):
            inner |= {id(part) for side in (node.left, *node.comparators) for part in ast.walk(side)}
        if isinstance(node, ast.Dict):
            inner |= {id(key) for key in node.keys}
        if isinstance(node, ast.Subscript):
            inner.add(id(node.slice))
        # Nor is what is replaced in a text shown, or what is printed on the console translated.
        if isinstance(node, ast.Call) and _called(node) in ("replace", "print"):
            inner |= {id(part) for argument in node.args for part in ast.walk(argument)}
        if isinstance(node, ast.Tuple) and len(node.elts) > 2:
            inner.add(id(node.elts[0]))
        if isinstance(node, ast.Call) and _called(node) == "tr" and isinstance(node.args[0], ast.JoinedStr):
            yield f"{_place(path, node)}: tr() needs a literal, and format() after it"
    for node in ast.walk(tree):
        if id(node) in inner:
            continue
        if isinstance(node, ast.JoinedStr):
            words = [part.value for part in node.values if isinstance(part, ast.Constant)]
            if any(BESIDE_VALUE.search(str(part).replace(NO_TEXTS[0], "")) for part in words):
                yield f"{_place(path, node)}: {ast.unparse(node)}"
        elif (text := _literal(node)) and SENTENCE.search(text) and text not in (*NO_TEXTS, *translated):
            yield f"{_place(path, node)}: {text!r}"

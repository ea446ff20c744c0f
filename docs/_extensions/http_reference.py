# SPDX-License-Identifier: MIT
"""The reference of the HTTP interface, written from the description that the service gives of itself."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from generated_reference import heading, literal_safe
from sphinx.application import Sphinx

from shapegoogle_core.service.app import make_app
from shapegoogle_core.service.settings import ServiceSettings

PAGE = Path("reference", "addresses.rst")
# Answers that every address may give; they are described once.
ERRORS = "ErrorAnswer"

Json = dict[str, Any]


def type_text(schema: Json) -> str:
    """Describe a type in a few words; objects are links to their sections."""
    if "$ref" in schema:
        return f"`{schema['$ref'].rpartition('/')[2]}`_"
    if "enum" in schema:
        return ", ".join(f"``{value}``" for value in schema["enum"])
    if "const" in schema:
        return f"``{schema['const']}``"
    if "anyOf" in schema:
        return " or ".join(dict.fromkeys(type_text(part) for part in schema["anyOf"]))
    kind = str(schema.get("type", "anything"))
    if kind == "array":
        return f"list of {type_text(schema.get('items', {}))}"
    if schema.get("format") == "binary" or "contentMediaType" in schema:
        return "file"
    limits = [
        f"{word} {schema[key]:g}" for key, word in (("minimum", "from"), ("maximum", "to")) if key in schema
    ]
    return " ".join([kind, *limits])


def fields(properties: dict[str, Json], required: list[str]) -> str:
    """Write the fields of an object as a list."""
    text = ""
    for name, schema in properties.items():
        notes = [type_text(schema)]
        if name not in required and schema.get("default") not in (None, "", [], {}):
            notes.append(f"default ``{schema['default']}``")
        elif name not in required:
            notes.append("optional")
        explained = literal_safe(" ".join(str(schema.get("description", "")).split()))
        text += f"``{name}`` : {', '.join(notes)}\n   {explained or '..'}\n\n"
    return text


def operation(method: str, path: str, described: Json) -> str:
    """Write the section of one address."""
    text = heading(f"{method.upper()} {path}", "-") + literal_safe(described.get("description", "")) + "\n\n"
    parameters = described.get("parameters", [])
    if parameters:
        shown = {
            each["name"]: {**each["schema"], "description": each.get("description", "")}
            for each in parameters
        }
        text += fields(shown, [each["name"] for each in parameters if each.get("required")])
    for media, content in described.get("requestBody", {}).get("content", {}).items():
        text += f"Takes ``{media}``: {type_text(content['schema'])}.\n\n"
    for status, answer in described["responses"].items():
        for media, content in answer.get("content", {}).items():
            schema = content.get("schema", {})
            if not schema.get("$ref", "").endswith(ERRORS):
                what = f": {type_text(schema)}" if schema else ""
                text += f"Answers {status}, ``{media}``{what}.\n\n"
    return text


def addresses_page() -> str:
    """Write the page of all addresses and objects."""
    app = make_app(ServiceSettings(library="library.sglib", spool="spool"))
    description = app.openapi()
    text = heading("HTTP addresses", "=")
    text += (
        "What each address of a :doc:`served library <http>` takes and answers. A program finds the same in "
        "``/api/openapi.json``.\n\n"
    )
    for path, methods in description["paths"].items():
        for method, described in methods.items():
            text += operation(method, path, described)
    for name, schema in sorted(description["components"]["schemas"].items()):
        summary = literal_safe(" ".join(str(schema.get("description", "")).split()))
        text += f".. _{name}:\n\n" + heading(name, "-") + f"{summary}\n\n"
        text += fields(schema.get("properties", {}), schema.get("required", []))
    return text


def write_page(app: Sphinx) -> None:
    """Write the page before Sphinx looks for sources."""
    target, text = Path(app.srcdir) / PAGE, addresses_page()
    if not target.exists() or target.read_text(encoding="utf-8") != text:
        target.write_text(text, encoding="utf-8")


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect to the start of a build."""
    app.connect("builder-inited", write_page)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

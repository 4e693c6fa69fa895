"""The types of the page's scripts, of the declarations of messages and requests.

Contents: their text. ``python -m tissue_probe.workbench.page_types > \
tissue_probe/workbench/page/told.d.ts``
writes the file that the scripts name; a test compares it.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from pydantic import TypeAdapter

from tissue_probe.workbench.page_messages import Answers, News
from tissue_probe.workbench.request_declarations import REQUESTS

_HEAD = "// Types of what the server tells and takes: written by page_types.py, not by hand.\n"
#: Types of JSON Schema that are called otherwise in TypeScript.
_PLAIN = {
    "boolean": "boolean", "integer": "number", "null": "null", "number": "number",
    "string": "string",
}  # fmt: skip


def write_types() -> str:
    """Return the text of ``told.d.ts``."""
    told: dict[str, Any] = {}
    for kind in (News, Answers):
        schema = TypeAdapter(kind).json_schema()
        told |= {**schema.pop("$defs", {}), kind.__name__: schema}
    asked = {name: _without_number(kind.model_json_schema()) for name, kind in REQUESTS.items()}
    for each in asked.values():
        told |= each.pop("$defs", {})
    parts = [_HEAD, *(f"export interface {name} {_object(told[name])}\n" for name in sorted(told))]
    rows = "\n".join(f"  {name}: {_object(each, '  ')};" for name, each in asked.items())
    parts.append(f"export interface Requests {{\n{rows}\n}}\n")
    return "\n".join(parts)


def _without_number(schema: dict[str, Any]) -> dict[str, Any]:
    """Leave out the number of a request, which the connection gives it."""
    properties = {name: each for name, each in schema["properties"].items() if name != "id"}
    return {**schema, "properties": properties}


def _object(schema: Mapping[str, Any], indent: str = "") -> str:
    properties, needed = schema.get("properties", {}), schema.get("required", ())
    if not properties:
        return "{}"
    rows = (
        f"{indent}  {name}{'' if name in needed else '?'}: {_type(each)};\n"
        for name, each in properties.items()
    )
    return "{\n" + "".join(rows) + indent + "}"


def _type(schema: Mapping[str, Any]) -> str:
    """Return the type of a value."""
    if "$ref" in schema:
        return str(schema["$ref"]).rpartition("/")[2]
    if "anyOf" in schema:
        return " | ".join(dict.fromkeys(_type(each) for each in schema["anyOf"]))
    if "enum" in schema or "const" in schema:
        return " | ".join(json.dumps(each) for each in schema.get("enum", [schema.get("const")]))
    kind = schema.get("type")
    if kind == "array":
        return _array(schema)
    if kind == "object":
        of = schema.get("additionalProperties", True)
        return f"Record<string, {'unknown' if of is True else _type(of)}>"
    return _PLAIN.get(str(kind), "unknown")


def _array(schema: Mapping[str, Any]) -> str:
    if "prefixItems" in schema:
        return f"[{', '.join(map(_type, schema['prefixItems']))}]"
    item = _type(schema.get("items", {}))
    return f"({item})[]" if " | " in item else f"{item}[]"


def main() -> None:
    """Print the types."""
    print(write_types(), end="")


if __name__ == "__main__":
    main()

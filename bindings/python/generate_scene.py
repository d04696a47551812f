"""Writes python/matpoint/scene.py, the typed parts of a scene, from the JSON schema that the Rust types give.

    matpoint schema | python bindings/python/generate_scene.py > bindings/python/python/matpoint/scene.py

`tests/python/test_package.py` fails where the file is not what this prints.
"""

from __future__ import annotations

import json
import keyword
import sys
import textwrap
from typing import Any

Schema = dict[str, Any]

HEAD = '''"""The parts of a scene as typed dicts: for completion in editors, and for type checkers.

Made by bindings/python/generate_scene.py from the types in src/scene; do not edit. All units are SI. A part is a dict:
`Grid(origin=[0.0], size=[1.0], cell=0.1)` is `{"origin": [0.0], "size": [1.0], "cell": 0.1}`, and either may be given to
`matpoint.Scene`, which checks it. Keys that are not Required may be left out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, Required, TypedDict, Union

import numpy as np
from numpy.typing import NDArray

Numbers = Union[Sequence[float], NDArray[np.floating[Any]], NDArray[np.integer[Any]]]
'''


def camel(name: str) -> str:
    return "".join(word.capitalize() for word in name.split("_"))


def doc(text: str, indent: str = "") -> str:
    plain = " ".join(text.replace("\\[", "[").replace("\\]", "]").split())
    lines = textwrap.wrap(plain, 110 - len(indent), break_long_words=False)
    quoted = ('"""' + "\n".join([lines[0], *(indent + line for line in lines[1:])]) + '"""').replace("\\", "\\\\")
    return indent + quoted


class Generator:
    def __init__(self, schema: Schema) -> None:
        self.definitions: Schema = schema["$defs"]
        self.parts: list[str] = []
        self.names: list[str] = []
        for name, definition in self.definitions.items():
            self.define(name, definition)
        self.record("Keys", {**schema, "description": "The keys of a scene, as `matpoint.Scene` takes them."})

    def kind(self, schema: Schema, name: str = "") -> str:
        """The Python type of a value."""
        if "$ref" in schema:
            return f'"{self.alias(schema["$ref"].removeprefix("#/$defs/"))}"'
        if "anyOf" in schema:
            kinds = [self.kind(option) for option in schema["anyOf"]]
            return f"Union[{', '.join(dict.fromkeys(kinds))}]" if len(set(kinds)) > 1 else kinds[0]
        kind = schema.get("type")
        if isinstance(kind, list):
            kinds = [self.kind({**schema, "type": one}, name) for one in kind]
            return f"Union[{', '.join(kinds)}]"
        if kind == "array":
            item = self.kind(schema["items"])
            if item == "float":
                return "Numbers"
            # numbers or formulas, and rows of numbers, are arrays too
            return f"Union[Sequence[{item}], NDArray[np.floating[Any]]]" if item in ('"Expr"', "Numbers") else f"Sequence[{item}]"
        if kind == "object" and "properties" in schema:
            return f'"{self.record(camel(name), schema)}"'
        if kind == "object":
            keys = self.kind(schema["propertyNames"]) if "propertyNames" in schema else "str"
            return f"Mapping[{keys}, {self.kind(schema['additionalProperties'])}]"
        return {"number": "float", "integer": "int", "string": "str", "boolean": "bool", "null": "None"}[str(kind)]

    @staticmethod
    def alias(name: str) -> str:
        return {"OneOrEach2": "WholeOneOrEach"}.get(name, name)

    def define(self, name: str, definition: Schema) -> None:
        name = self.alias(name)
        options = definition.get("oneOf", [])
        if "enum" in definition or any("const" in option for option in options):
            words = [word for option in options for word in option.get("enum", [option.get("const")])] or definition["enum"]
            notes = [f"`{option['const']}`: {option['description']}" for option in options if "const" in option]
            self.value(name, f"Literal[{', '.join(json.dumps(word) for word in words)}]", " ".join([definition.get("description", ""), *notes]))
        elif options:
            variants = []
            for option in options:
                ((key, value),) = option["properties"].items()
                value.setdefault("description", option["description"])
                variants.append(f'"{self.record(name + camel(key), option)}"')
            self.value(name, f"Union[{', '.join(variants)}]", definition["description"])
        elif "anyOf" in definition:
            self.value(name, self.kind(definition), definition["description"])
        else:
            self.record(name, definition)

    def value(self, name: str, kind: str, description: str) -> None:
        self.names.append(name)
        self.parts.append(f"{name} = {kind}\n{doc(description)}\n")

    def record(self, name: str, schema: Schema) -> str:
        """A typed dict; all keys of scenes are Python names."""
        required = schema.get("required", [])
        lines = [f"class {name}(TypedDict, total=False):", doc(schema["description"], "    "), ""]
        for key, value in schema["properties"].items():
            if keyword.iskeyword(key):
                raise ValueError(f"{name}.{key} is a word of Python")
            kind = self.kind(value, key)
            lines.append(f"    {key}: {f'Required[{kind}]' if key in required else kind}")
            if "description" in value and value["description"] != schema.get("description"):
                lines.append(doc(value["description"], "    "))
        self.names.append(name)
        self.parts.append("\n".join(lines) + "\n")
        return name

    def text(self) -> str:
        names = "".join(f'    "{name}",\n' for name in sorted([*self.names, "Numbers"]))
        return "\n\n".join([HEAD, *self.parts, f"__all__ = [\n{names}]\n"])


if __name__ == "__main__":
    sys.stdout.write(Generator(json.load(sys.stdin)).text())

"""How is a configuration described to editors? As a JSON Schema, made from the list of keys."""

from __future__ import annotations

from typing import Any

from . import NAME
from .keys import KEYS
from .kinds import schema_of

URL = (
    "https://raw.githubusercontent.com/usdrender-lint/usdrender-lint/main/"
    "src/usdrender_lint/usdrender-lint.schema.json"
)


def schema() -> dict[str, Any]:
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "$id": URL,
        "title": NAME,
        "type": "object",
        "properties": {name: _property(name) for name in KEYS},
        "additionalProperties": False,
    }


def _property(name: str) -> dict[str, Any]:
    key = KEYS[name]
    default = {} if key.default is None else {"default": key.default}
    return {"description": key.means, **schema_of(key.kind), **default}

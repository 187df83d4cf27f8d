"""What may stand behind a key of a TOML file, and what is said where it may not?"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from ..records import dataclass
from .places import Path
from .wrong import Fault, suggestion

Schema = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Flag:
    """`true` or `false`."""


@dataclass(frozen=True, slots=True)
class Word:
    """A text that means something."""

    what: str
    """With its article, as in 'expected a rule'."""
    fault: Callable[[str], str | None] = lambda _: None
    """What is wrong with a text, if anything is."""
    words: Callable[[], list[str]] = list
    """Those that it may be; none: any text that has no fault."""


@dataclass(frozen=True, slots=True)
class Pair:
    """A list of two texts."""


@dataclass(frozen=True, slots=True)
class ListOf:
    item: Word | Pair
    whats: str
    """The items, in the plural."""


@dataclass(frozen=True, slots=True)
class TableOf:
    name: Word
    value: Word | ListOf
    whats: str


@dataclass(frozen=True, slots=True)
class Table:
    """One that has these keys and no others."""

    keys: Mapping[str, Kind]
    needed: tuple[str, ...] = ()


Kind = Flag | Word | Pair | ListOf | TableOf | Table


def one_of(words: Callable[[], list[str]], what: str) -> Word:
    """One of a few words that stand in no order but their own."""

    def fault(value: str) -> str | None:
        known = words()
        if value in known:
            return None
        return f"'{value}' is not {either(known)}"

    return Word(what, fault, words)


def either(words: list[str]) -> str:
    """`a, b or c`."""
    *others, last = words
    return f"{', '.join(others)} or {last}" if others else last


def expected(kind: Kind) -> str:
    match kind:
        case Flag():
            return "true or false"
        case Word():
            return kind.what
        case ListOf():
            return f"a list of {kind.whats}"
        case TableOf():
            return f"a table of {kind.whats}"
        case Pair():
            return "a list of two texts"
        case Table():
            return "a table"


def faults(kind: Kind, value: Any, path: Path) -> Iterator[Fault]:
    match kind, value:
        case Flag(), bool():
            return
        case Word(), str():
            if message := kind.fault(value):
                yield Fault(path, message)
        case ListOf(item), list():
            for index, one in enumerate(value):
                yield from faults(item, one, (*path, index))
        case TableOf(name, kind_of_value), dict():
            for key, one in value.items():
                if message := name.fault(key):
                    yield Fault((*path, key), message, at_key=True)
                yield from faults(kind_of_value, one, (*path, key))
        case Table(), dict():
            yield from _faults_of_table(kind, value, path)
        case Pair(), [str(), str()]:
            return
        case _:
            yield Fault(path, f"expected {expected(kind)}, not {_said(value)}")


def _faults_of_table(kind: Table, table: dict[str, Any], path: Path) -> Iterator[Fault]:
    for key, value in table.items():
        if key not in kind.keys:
            message = f"unknown key '{key}'{suggestion(key, kind.keys)}"
            yield Fault((*path, key), message, at_key=True)
        else:
            yield from faults(kind.keys[key], value, (*path, key))
    for key in kind.needed:
        if key not in table:
            yield Fault(path, f"the key '{key}' is missing", at_key=True)


def _said(value: Any) -> str:
    match value:
        case bool():
            return str(value).lower()
        case int() | float():
            return "a number"
        case str():
            return "a text"
        case list():
            return "a list"
        case dict():
            return "a table"
        case _:
            return "a date or a time"


def schema_of(kind: Kind) -> Schema:
    """As JSON Schema says it."""
    match kind:
        case Flag():
            return {"type": "boolean"}
        case Word():
            words = kind.words()
            return {"type": "string", "enum": words} if words else {"type": "string"}
        case ListOf(item):
            return {"type": "array", "items": schema_of(item)}
        case TableOf(name, value):
            names = {"propertyNames": {"enum": name.words()}} if name.words() else {}
            return {"type": "object", **names, "additionalProperties": schema_of(value)}
        case Pair():
            return {
                "type": "array",
                "items": {"type": "string"},
                "minItems": 2,
                "maxItems": 2,
            }
        case Table(keys):
            properties = {key: schema_of(value) for key, value in keys.items()}
            return {"type": "object", "properties": properties, "additionalProperties": False}

"""What does a show say of a renderer of its own, and is it one?"""

from __future__ import annotations

import re
from pathlib import Path

from ..lpe import dialects
from ..registry import UnknownRuleError, all_rules
from ..renderers import Own, names
from ..rule import Severity
from .kinds import Flag, ListOf, Pair, Table, TableOf, Word, faults, one_of
from .toml import load
from .wrong import Fault, located


def _expression_fault(value: str) -> str | None:
    try:
        re.compile(value)
    except re.error as error:
        return f"'{value}' is no regular expression: {error}"
    return None


def _extension_fault(value: str) -> str | None:
    if not value:  # none at all: a name without an extension
        return None
    return None if value.startswith(".") else f"'{value}' has no dot: an extension is like '.exr'"


def _rule_fault(value: str) -> str | None:
    return None if value in all_rules() else str(UnknownRuleError(value, all_rules()))


def _levels() -> list[str]:
    return [*map(str, Severity), "off"]


_WORDS = ListOf(Word("a text"), "texts")
_EXTENSIONS = ListOf(Word("an extension", _extension_fault), "extensions")
_EXPRESSIONS = ListOf(Word("a regular expression", _expression_fault), "regular expressions")
_RULE = Word("the id of a rule", _rule_fault, lambda: list(all_rules()))

FILE_OF_RENDERER = Table(
    {
        "title": Word("a text"),
        "product-types": _WORDS,
        "deep-types": _WORDS,
        "deep-extensions": _EXTENSIONS,
        "special-product-names": _WORDS,
        "camera-types": _WORDS,
        "data-types": _WORDS,
        "unsupported-data-types": _WORDS,
        "host-prims": _WORDS,
        "source-name-attributes": _WORDS,
        "unnamed-product": Word("a text"),
        "extensions": _EXTENSIONS,
        "unsupported-extensions": _EXTENSIONS,
        "exact-extension-case": Flag(),
        "multi-channel-extensions": _EXTENSIONS,
        "frame-tokens": _EXPRESSIONS,
        "name-variables": _EXPRESSIONS,
        "namespaces": _WORDS,
        "aov-name-attributes": _WORDS,
        "source-types": _WORDS,
        "source-prefixes": _WORDS,
        "renames-duplicates": Flag(),
        "lpe-dialect": one_of(lambda: list(dialects.DIALECTS), "a dialect"),
        "properties": _WORDS,
        "accepted-types": ListOf(Pair(), "pairs of a property and a type"),
        "severity": TableOf(_RULE, one_of(_levels, "a level"), "rules and levels"),
        "evidence": Table(
            dict.fromkeys(
                (
                    "namespaces",
                    "schemas",
                    "product-types",
                    "camera-types",
                    "prim-names",
                    "layer-data",
                ),
                _WORDS,
            )
        ),
    },
    needed=("title",),
)
"""See `renderers` for what each of them means."""


def own_renderer(file: Path) -> Own:
    """`ConfigError` for a file that is none."""
    text, table = load(file)
    found = [*faults(FILE_OF_RENDERER, table, ())]
    if file.stem in ("auto", *names()):
        said = f"'{file.stem}' is a renderer of usdrender-lint: give the file a name of its own"
        found.insert(0, Fault((), said))
    if found:
        raise located(file, text, found)
    return Own(file.stem, text)

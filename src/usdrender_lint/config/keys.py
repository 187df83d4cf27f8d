"""Which keys does a configuration have? The one list from which it is read, described and checked."""

from __future__ import annotations

import re
from typing import Any

from ..lazily import lazily
from ..patterns import PatternError, check
from ..records import dataclass
from ..registry import UnknownRuleError, all_rules, matching
from ..rule import Severity
from .kinds import Flag, Kind, ListOf, Table, TableOf, Word, one_of

LEVELS = (*(str(s) for s in Severity), "off")
GATES = (*(str(s) for s in Severity), "never")

_PRIM_PATH = lazily(r"(?:/[^\W\d]\w*)+")


def _rule_fault(value: str) -> str | None:
    try:
        matching(value)
    except UnknownRuleError as error:
        return str(error)
    return None


def selectors() -> list[str]:
    """All that may stand for rules."""
    rules = all_rules()
    return ["default", "ALL", *sorted({rule.group for rule in rules.values()}), *rules]


def _pattern_fault(value: str) -> str | None:
    try:
        check(value)
    except PatternError as error:
        return str(error)
    return None


def _entry_fault(name: str) -> str | None:
    """TOML takes a key below the header of a table for an entry of that table."""
    return f"'{name}' is a key: write it above the first table" if name in KEYS else None


def _entry_rule_fault(value: str) -> str | None:
    told = _rule_fault(value)
    return told and (_entry_fault(value) or told)


def _entry_pattern_fault(value: str) -> str | None:
    if told := _entry_fault(value):
        return f"{told}; a folder of that name is '{value}/'"
    return _pattern_fault(value)


def _root_fault(value: str) -> str | None:
    parts = value.replace("\\", "/").split("/")
    if not value.strip():
        return "an empty pattern matches nothing"
    if value.startswith(("/", "~")) or ".." in parts or re.match(r"[A-Za-z]:", value):
        return "roots stand below the folder of this file: write the path from there"
    return None


def _scope_fault(value: str) -> str | None:
    if _PRIM_PATH.fullmatch(value):
        return None
    return f"'{value}' is no path of a prim, such as '/Render'"


def _file_fault(value: str) -> str | None:
    return None if value.strip() else "an empty path names no file"


def _version_fault(value: str) -> str | None:
    # It costs more to import than the whole configuration to read.
    from packaging.specifiers import InvalidSpecifier, SpecifierSet

    try:
        SpecifierSet(value)
    except InvalidSpecifier:
        return f"'{value}' is no requirement of a version, such as '>=0.1'"
    return None


RULE = Word("a rule", _rule_fault, selectors)
RULES = ListOf(RULE, "rules")
PATTERN = Word("a pattern of paths", _pattern_fault)
ENTRY_RULE = Word("a rule", _entry_rule_fault, selectors)
ENTRY_PATTERN = Word("a pattern of paths", _entry_pattern_fault)
PATTERNS = ListOf(PATTERN, "patterns of paths")
FILE = Word("the path of a file", _file_fault)


@dataclass(frozen=True, slots=True)
class Key:
    """One key: what it may hold, what holds without it, and what it means."""

    name: str
    kind: Kind
    default: Any
    """None: nothing."""
    means: str
    example: str
    """As it stands in a file."""
    option: str | None = None
    """Of the command line, which stands above it."""


KEYS = {
    key.name: key
    for key in (
        Key(
            "extend",
            FILE,
            None,
            "A file whose keys hold where this one is silent; its path counts from this file.",
            '"../usdrender-lint.toml"',
        ),
        Key(
            "required-version",
            Word("a requirement of a version", _version_fault),
            None,
            "The versions of usdrender-lint that may lint here (PEP 440); any other refuses to.",
            '">=0.1"',
        ),
        Key(
            "select",
            RULES,
            ["default"],
            "Rules to run: ids, subjects such as `camera`, `default` or `ALL`.",
            '["default", "animation"]',
            "--select",
        ),
        Key(
            "extend-select",
            RULES,
            [],
            "Rules to run beside those of `select`.",
            '["default-resolution"]',
            "--extend-select",
        ),
        Key(
            "ignore",
            RULES,
            [],
            "Rules not to report.",
            '["many-material-purposes"]',
            "--ignore",
        ),
        Key(
            "severity",
            TableOf(ENTRY_RULE, one_of(lambda: list(LEVELS), "a level"), "rules and levels"),
            {},
            "Rules or subjects to report as `error`, `warning` or `note`, or not at all: `off`. "
            "An id stands above its subject.",
            '{ default-settings-unset = "error", animation = "off" }',
            "--severity",
        ),
        Key(
            "per-file-ignores",
            TableOf(ENTRY_PATTERN, RULES, "patterns of paths and lists of rules"),
            {},
            "Rules not to report of the layers that a pattern matches.",
            '{ "assets/**" = ["default-settings-unset"] }',
        ),
        Key(
            "fail-on",
            one_of(lambda: list(GATES), "a severity or 'never'"),
            "warning",
            "The least severity that makes the exit code 1: "
            "`error`, `warning`, `note`, or `never` for none.",
            '"error"',
            "--fail-on",
        ),
        Key(
            "renderer",
            Word("the name of a renderer"),
            "auto",
            "The renderer to judge by; `auto` goes by what the stage holds for one.",
            '"karma"',
            "--renderer",
        ),
        Key(
            "renderers",
            ListOf(FILE, "files"),
            [],
            "Files of renderers of your own, called like the file; the paths count from this file.",
            '["tools/our_renderer.toml"]',
        ),
        Key(
            "variants",
            Flag(),
            False,
            "Lint every variant of the variant sets that reach the render spec.",
            "true",
            "--variants",
        ),
        Key(
            "scene",
            Flag(),
            False,
            "Run the rules that need the whole stage, too: slow on large ones.",
            "true",
            "--scene",
        ),
        Key(
            "scopes",
            ListOf(Word("the path of a prim", _scope_fault), "paths of prims"),
            ["/Render"],
            "Where render prims belong in this show.",
            '["/Render", "/RenderTests"]',
        ),
        Key(
            "exclude",
            PATTERNS,
            [],
            "Files and folders not to lint, named or found.",
            '["cache/", "*_old.usda"]',
            "--exclude",
        ),
        Key(
            "extend-exclude",
            PATTERNS,
            [],
            "Files and folders not to lint beside those of `exclude`.",
            '["/shots/test/"]',
        ),
        Key(
            "baseline",
            FILE,
            None,
            "Hide the findings that this file holds; its path counts from this file.",
            '"usdrender-lint-baseline.json"',
            "--baseline",
        ),
        Key(
            "roots",
            ListOf(Word("a pattern of paths", _root_fault), "patterns of paths"),
            [],
            "Stages through which the layers that they use are linted; "
            "`*` is any name, `**` any folders.",
            '["shots/*/*.usda"]',
        ),
    )
}

FILE_OF_KEYS = Table({key.name: key.kind for key in KEYS.values()})

"""Which rules are there? By subject for a person, as data for a script."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import groupby

from ..rule import AnyRule
from . import NAME, page_url, to_json

Json = dict[str, object]

VERSION = 1
"""As that of the JSON report: grows when a key changes its meaning or goes."""


def render(rules: Iterable[AnyRule]) -> str:
    listed = sorted(rules, key=lambda rule: (rule.group, rule.id))
    wide = max((len(rule.id) for rule in listed), default=0)
    lines: list[str] = []
    for group, found in groupby(listed, lambda rule: rule.group):
        lines.append(group)
        for rule in found:
            lines.append(f"  {rule.id:{wide}}  {rule.severity:7}  {rule.summary}{_when(rule)}")
        lines.append("")
    lines.append(f"{len(listed)} rules. --explain RULE shows the page of one.")
    return "\n".join(lines) + "\n"


def _when(rule: AnyRule) -> str:
    whose = f"only for {' and '.join(rule.renderers)}" if rule.renderers else ""
    told = ", ".join(filter(None, (rule.only_when, whose)))
    return f"  ({told})" if told else ""


def listed(rules: Iterable[AnyRule], version: str) -> str:
    """All rules as JSON."""
    return _document({"rules": [_facts(rule) for rule in rules]}, version)


def explained(rule: AnyRule, page: str, version: str) -> str:
    """One rule as JSON, with the Markdown of its page."""
    return _document({"rule": {**_facts(rule), "page": page}}, version)


def _document(content: Json, version: str) -> str:
    return to_json({"version": VERSION, "tool": {"name": NAME, "version": version}, **content})


def _facts(rule: AnyRule) -> Json:
    return {
        "id": rule.id,
        "group": rule.group,
        "severity": rule.severity.value,
        "default": rule.default,
        "needsScene": rule.needs_scene,
        "renderers": list(rule.renderers),
        "summary": rule.summary,
        "url": page_url(rule.id),
    }

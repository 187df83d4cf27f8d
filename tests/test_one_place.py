"""No two findings say something of one and the same place, but where it has two faults indeed."""

from __future__ import annotations

from collections import defaultdict
from functools import cache
from pathlib import Path

import pytest

from conftest import ROOT
from usdrender_lint.lint import lint
from usdrender_lint.results import Located

FIXTURES = ROOT / "fixtures"
SCENES = sorted(
    file
    for kind in ("bad", "seed")
    for file in (*(FIXTURES / kind).glob("*.usd*"), *(FIXTURES / kind).glob("*/shot.usda"))
)

PARTS = {"unknown-command-variable": "a command has several variables"}
"""Rules that speak of parts of a value, which share its place."""

VIEWS = "what all products share is no longer one, whether or not the value that differs is right"
TWICE_WRONG = {
    ("dead-target", "per-product-view"): VIEWS,
    ("empty-data-window", "per-product-view"): VIEWS,
    ("invalid-pixel-aspect-ratio", "per-product-view"): VIEWS,
    ("default-purpose-omitted", "proxy-with-render"): "one purpose is too many, another is missing",
    (
        "instanced-member",
        "visible-but-pruned",
    ): "one part of the pass misses it, another removes it",
    (
        "matte-not-visible",
        "pattern-without-descendants",
    ): "what it leads to, and what it leaves out",
}


def place(finding: Located) -> tuple[object, ...] | None:
    """What is missing stands at the name of its prim, and so is told apart by its property."""
    at = finding.location
    about = finding.prim_path, finding.property, finding.target
    return (at.path, at.member, at.span, *about) if at.span else None


@cache
def shared_places(file: Path) -> dict[tuple[object, ...], list[str]]:
    """The rules that speak of each place of which more than one finding speaks."""
    found: defaultdict[tuple[object, ...], list[str]] = defaultdict(list)
    for finding in lint([str(file)], cwd=ROOT).findings:
        if where := place(finding):
            found[where].append(finding.rule.id)
    return {where: sorted(rules) for where, rules in found.items() if len(rules) > 1}


@pytest.mark.parametrize("file", SCENES, ids=[f.relative_to(FIXTURES).as_posix() for f in SCENES])
def test_one_finding_a_place(file: Path) -> None:
    for where, rules in shared_places(file).items():
        alone = len(set(rules)) == 1
        assert rules[0] in PARTS if alone else tuple(rules) in TWICE_WRONG, (where, rules)


def test_every_reason_is_needed() -> None:
    shared = [rules for file in SCENES for rules in shared_places(file).values()]
    assert TWICE_WRONG.keys() == {tuple(rules) for rules in shared if len(set(rules)) > 1}
    assert PARTS.keys() == {rules[0] for rules in shared if len(set(rules)) == 1}

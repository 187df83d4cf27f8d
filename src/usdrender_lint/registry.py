"""Which rules are there, and which of them run?"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from . import rules as built_in
from .model import Suppressions
from .records import dataclass
from .results import Skipped
from .rule import AnyRule, Rule


class UnknownRuleError(Exception):
    """A selector names no rule and no group."""

    def __init__(self, name: str, known: Iterable[str]) -> None:
        from .likeness import closest

        meant = closest(name, known)
        hint = f": did you mean {meant!r}?" if meant else "; --list-rules shows them all"
        super().__init__(f"unknown rule {name!r}{hint}")


@cache
def all_rules() -> dict[str, AnyRule]:
    """Every rule by id, from all modules of the package `rules`."""
    found: dict[str, AnyRule] = {}
    for info in sorted(iter_modules(built_in.__path__), key=lambda i: i.name):
        if info.name.startswith("_"):
            continue
        module = import_module(f"{built_in.__name__}.{info.name}")
        for value in vars(module).values():
            if isinstance(value, Rule):
                found[value.id] = replace(value, group=value.group or module.GROUP)
    return dict(sorted(found.items()))


def matching(selector: str) -> set[str]:
    """Ids that a selector stands for: an id, a group, `default` or `ALL`."""
    rules = all_rules()
    if selector == "ALL":
        return set(rules)
    if selector == "default":
        return {r.id for r in rules.values() if r.default}
    if selector in rules:
        return {selector}
    group = {r.id for r in rules.values() if r.group == selector}
    if not group:
        raise UnknownRuleError(
            selector, [*rules, *(r.group for r in rules.values()), "ALL", "default"]
        )
    return group


@dataclass(frozen=True, slots=True)
class Selection:
    """The rules whose findings are told, and those that run with them because one of their findings
    would explain a told one away."""

    told: frozenset[str]
    run: tuple[AnyRule, ...]
    skipped: tuple[Skipped, ...] = ()
    needs_scene: bool = False
    """One of those that run needs the whole stage."""
    judges_suppressions: bool = False
    """One of those that are told is about suppressions."""


def select(
    select: Iterable[str] = ("default",), ignore: Iterable[str] = (), *, scene: bool = False
) -> Selection:
    """Silencing the stronger of two rules does not bring the weaker back: so what supersedes a
    selected rule runs, selected or not.

    A rule that needs the whole stage runs when it is named, or with `scene`, never for a group's sake.
    """
    rules = all_rules()
    whole = {r.id for r in rules.values() if r.needs_scene}
    chosen = list(select)
    told = set[str]().union(*(matching(s) for s in chosen))
    if scene:
        told |= whole
    named = whole.intersection(chosen)
    refused = told.intersection(whole) - named if not scene else set[str]()
    left_out = set[str]().union(*(matching(s) for s in ignore))
    told -= refused | left_out
    running = set(told)
    # A rule that is off by itself must not take findings away from those that are on.
    usual = {r.id: r.supersedes for r in rules.values() if r.default and r.id not in whole}
    while more := {i for i, below in usual.items() if running.intersection(below)} - running:
        running |= more
    reason = "needs the whole stage: --scene, or select it by name"
    return Selection(
        frozenset(told),
        tuple(rules[i] for i in sorted(running)),
        tuple(Skipped(i, reason) for i in sorted(refused - left_out)),
        not whole.isdisjoint(running),
        any(rules[i].on is Suppressions for i in told),
    )

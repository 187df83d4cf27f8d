"""Which rules there are, and which of them run and speak?"""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib import import_module

import pytest

from usdrender_lint.registry import Selection, UnknownRuleError, all_rules, matching, select
from usdrender_lint.rule import AnyRule
from usdrender_lint.testing import lint_files

RULES = all_rules()
IDS = sorted(RULES)
RELATIVE = {
    "main.usda": """#usda 1.0
def Scope "Render"
{
    def RenderSettings "S"
    {
    }
    def RenderPass "A"
    {
        rel renderSource = <Render/S>
    }
}
"""
}


def superseding() -> Iterator[tuple[AnyRule, AnyRule]]:
    """The stronger and the weaker of every pair."""
    for rule in RULES.values():
        yield from ((rule, RULES[other]) for other in rule.supersedes)


def ids(selection: Selection) -> set[str]:
    return {r.id for r in selection.run}


@pytest.mark.parametrize("rule_id", IDS)
def test_a_rule_states_its_facts(rule_id: str) -> None:
    rule = RULES[rule_id]
    assert rule.id == rule_id
    assert re.fullmatch(r"[a-z]+(-[a-z]+)+", rule_id), "kebab-case, at least two words"
    assert rule.summary.endswith("."), "the docstring's first line is a sentence"
    assert rule.group
    assert rule.since


def test_ids_are_sorted_and_no_group_is_called_like_a_rule() -> None:
    assert list(RULES) == IDS
    assert not {r.group for r in RULES.values()} & {*IDS, "ALL", "default"}


@pytest.mark.parametrize("rule_id", IDS)
def test_a_rule_supersedes_only_rules_that_exist(rule_id: str) -> None:
    assert set(RULES[rule_id].supersedes) <= set(RULES) - {rule_id}


def test_no_two_rules_supersede_each_other() -> None:
    pairs = {(a.id, b.id) for a, b in superseding()}
    assert not {(a, b) for a, b in pairs if (b, a) in pairs}


def test_two_modules_never_define_one_id() -> None:
    modules = {r.check.__module__ for r in RULES.values()}
    named = [
        value.id
        for module in modules
        for value in vars(import_module(module)).values()
        if hasattr(value, "supersedes")
    ]
    assert sorted(named) == IDS


class TestMatching:
    def test_an_id(self) -> None:
        assert matching("missing-camera") == {"missing-camera"}

    def test_a_group(self) -> None:
        assert matching("camera") == {r.id for r in RULES.values() if r.group == "camera"}
        assert {"missing-camera", "multiple-cameras"} <= matching("camera")

    def test_all_and_default(self) -> None:
        assert matching("ALL") == set(IDS)
        assert matching("default") == {r.id for r in RULES.values() if r.default}
        assert "no-all-purpose-fallback" not in matching("default")

    @pytest.mark.parametrize(
        ("name", "hint"),
        [
            ("missing-camra", "did you mean 'missing-camera'?"),
            ("camra", "did you mean 'camera'?"),
            ("Default", "did you mean 'default'?"),
            ("all", "did you mean 'ALL'?"),
            ("MISSING-CAMERA", "did you mean 'missing-camera'?"),
            ("no-such-rule-at-all-xyz", "--list-rules shows them all"),
            ("", "--list-rules shows them all"),
        ],
    )
    def test_nothing_of_that_name(self, name: str, hint: str) -> None:
        with pytest.raises(UnknownRuleError, match=re.escape(f"unknown rule {name!r}")) as raised:
            matching(name)
        assert hint in str(raised.value)


class TestSelect:
    def test_default_rules_speak_without_being_asked(self) -> None:
        assert select().told <= matching("default")
        assert select().told >= {"missing-camera", "unresolved-target"}

    def test_an_ignored_rule_does_not_speak(self) -> None:
        assert "missing-camera" not in select(ignore=["missing-camera"]).told
        assert not select(ignore=["camera"]).told & matching("camera")

    def test_ignoring_stands_above_selecting(self) -> None:
        assert select(["missing-camera"], ["camera"]).told == frozenset()
        assert select(["missing-camera"], ["ALL"]).run == ()

    def test_several_selectors_add_up(self) -> None:
        found = select(["missing-camera", "syntax-error"])
        assert found.told == {"missing-camera", "syntax-error"}

    def test_an_unknown_name_is_refused_wherever_it_stands(self) -> None:
        for given in ((["nope-nope"], []), (["default"], ["nope-nope"])):
            with pytest.raises(UnknownRuleError):
                select(*given)

    def test_every_rule_that_speaks_runs_in_the_order_of_ids(self) -> None:
        found = select()
        assert found.told <= ids(found)
        assert [r.id for r in found.run] == sorted(ids(found))

    @pytest.mark.parametrize(
        ("stronger", "weaker"),
        [p for p in superseding() if p[0].default and not p[0].needs_scene],
        ids=lambda r: r.id,
    )
    def test_what_supersedes_runs_unselected_and_does_not_speak(
        self, stronger: AnyRule, weaker: AnyRule
    ) -> None:
        found = select([weaker.id])
        assert stronger.id in ids(found)
        assert found.told == {weaker.id}
        assert stronger.id in ids(select(ignore=[stronger.id])) or not weaker.default

    def test_a_rule_that_is_off_takes_nothing_from_those_that_are_on(self) -> None:
        assert "default-settings-unresolved" in select().told
        assert "instanceable-render-scope" not in ids(select())
        assert "instanceable-render-scope" in ids(select(["default", "instanceable-render-scope"]))

    def test_what_is_superseded_does_not_run_for_that(self) -> None:
        assert "unresolved-target" not in ids(select(["relative-target"]))


class TestSilence:
    @pytest.mark.parametrize(
        ("selected", "ignored", "found"),
        [
            (["relative-target", "unresolved-target"], [], ["relative-target"]),
            (["relative-target"], [], ["relative-target"]),
            (["unresolved-target"], [], []),
            (["relative-target", "unresolved-target"], ["relative-target"], []),
            (["relative-target", "unresolved-target"], ["unresolved-target"], ["relative-target"]),
        ],
    )
    def test_silencing_the_stronger_does_not_bring_the_weaker_back(
        self, selected: list[str], ignored: list[str], found: list[str]
    ) -> None:
        rules = sorted(set(selected) - set(ignored))
        _, marks = lint_files(RELATIVE, rules=rules)
        assert [m.rule for m in marks] == found


class TestWholeStage:
    """Rules that need all of the stage."""

    WHOLE = sorted(r.id for r in RULES.values() if r.needs_scene)

    @pytest.mark.parametrize("selector", ["default", "ALL"])
    def test_no_group_brings_them_in(self, selector: str) -> None:
        found = select([selector])
        assert not found.needs_scene
        assert {s.rule for s in found.skipped} == matching(selector).intersection(self.WHOLE)

    @pytest.mark.parametrize("rule_id", WHOLE)
    def test_by_name_they_run(self, rule_id: str) -> None:
        found = select([rule_id])
        assert found.told == {rule_id}
        assert found.needs_scene
        assert found.skipped == ()

    def test_a_flag_brings_them_all_in(self) -> None:
        found = select(scene=True)
        assert found.told >= set(self.WHOLE)
        assert found.skipped == ()

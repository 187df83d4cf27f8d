"""Does one fault give one finding?"""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from usdrender_lint.model import Layer, Site
from usdrender_lint.rule import AnyRule, Context, Finding, Severity, rule
from usdrender_lint.run import Told
from usdrender_lint.settle import settle, unique


def a_rule(id: str, *supersedes: str) -> AnyRule:
    @rule(id, on=Layer, severity=Severity.ERROR, since="0.1", supersedes=supersedes)
    def check(layer: Layer, context: Context) -> Iterator[Finding]:
        yield from ()

    return check


CAUSE, EFFECT, OTHER = a_rule("cause", "effect"), a_rule("effect"), a_rule("other")


def told(rule: AnyRule, at: Site, message: str = "x") -> Told:
    return Told(rule, Finding(at, message))


def left(*given: Told) -> list[str]:
    return [t.rule.id for t in settle(unique(given))]


@pytest.mark.parametrize(
    ("cause", "effect", "superseded"),
    [
        # at a prim: itself, what is below, what leads there
        (Site("/R"), Site("/R"), True),
        (Site("/R"), Site("/R/S"), True),
        (Site("/R"), Site("/R.camera"), True),
        (Site("/R"), Site("/R/S.camera", "targetPaths", "/C"), True),
        (Site("/R"), Site("/", "renderSettingsPrimPath", "/R/S"), True),
        (Site("/R"), Site("/X.camera", "targetPaths", "/R"), True),
        (Site("/R"), Site("/X.camera", "targetPaths", "/R.cam"), True),
        (Site("/R", "typeName"), Site("/R", "active"), True),
        (Site("/R"), Site("/Rx"), False),
        (Site("/R"), Site("/Rx.camera", "targetPaths", "/Rx/C"), False),
        (Site("/R/S"), Site("/R"), False),
        (Site("/R"), Site("/"), False),
        # at a property: the same one
        (Site("/R.camera"), Site("/R.camera"), True),
        (Site("/R.camera", "targetPaths"), Site("/R.camera", "targetPaths", "/C"), True),
        (Site("/R.camera", "targetPaths", "/C"), Site("/R.camera"), True),
        (Site("/R.camera", "targetPaths", "/C"), Site("/R.camera", "targetPaths", "/C"), True),
        (Site("/R.camera", "targetPaths", "/C"), Site("/R.camera", "targetPaths", "/D"), False),
        (Site("/R.camera"), Site("/R.products"), False),
        (Site("/R.camera"), Site("/R"), False),
        (Site("/R.camera"), Site("/S.camera"), False),
        # at the layer: everything
        (Site("/", "renderSettingsPrimPath"), Site("/R.camera"), True),
        (Site("/", "customLayerData:x", layer="b.usda"), Site("/", "x", layer="a.usda"), True),
        # one layer's opinion about an object of the stage is about that object
        (Site("/R.camera", layer="b.usda", spec="/X.camera"), Site("/R.camera"), True),
        (Site("/R.camera", layer="b.usda", spec="/X.camera"), Site("/X.camera"), False),
    ],
    ids=str,
)
def test_place_decides(cause: Site, effect: Site, superseded: bool) -> None:
    expected = ["cause"] if superseded else ["cause", "effect"]
    assert left(told(CAUSE, cause), told(EFFECT, effect)) == expected
    assert left(told(EFFECT, effect), told(CAUSE, cause)) == sorted(expected, reverse=True)


def test_only_what_a_rule_names_is_superseded() -> None:
    site = Site("/R.camera")
    assert left(told(CAUSE, site), told(OTHER, site), told(EFFECT, site)) == ["cause", "other"]


def test_nothing_supersedes_without_having_found() -> None:
    assert left(told(EFFECT, Site("/R"))) == ["effect"]


def test_what_is_superseded_still_supersedes() -> None:
    """A chain ends at its cause, whatever stands between."""
    first = a_rule("first", "cause")
    site = Site("/R")
    assert left(told(first, site), told(CAUSE, site), told(EFFECT, site)) == ["first"]


def test_a_finding_that_is_told_twice_is_one() -> None:
    twice = [told(EFFECT, Site("/R.a")), told(EFFECT, Site("/R.a"))]
    assert left(*twice) == ["effect"]


def test_what_is_related_to_either_is_related_to_the_one() -> None:
    a, b = (Site("/A"), "is one"), (Site("/B"), "is another")
    twice = [
        Told(EFFECT, Finding(Site("/R.a"), "x", related=related)) for related in ((a,), (b, a))
    ]
    (one,) = unique(twice)
    assert one.finding.related == (a, b)


@pytest.mark.parametrize(
    "other",
    [
        told(EFFECT, Site("/R.a"), "y"),
        told(EFFECT, Site("/R.b")),
        told(EFFECT, Site("/R.a", "default")),
        told(EFFECT, Site("/R.a", layer="b.usda")),
        told(OTHER, Site("/R.a")),
    ],
)
def test_what_differs_in_rule_place_or_message_is_two(other: Told) -> None:
    assert len(unique([told(EFFECT, Site("/R.a")), other])) == 2


def test_order_is_kept() -> None:
    given = [told(EFFECT, Site(f"/{n}")) for n in "cab"]
    assert settle(given) == given

"""Do the suppressions of a layer silence what they were written for?"""

from __future__ import annotations

from collections.abc import Iterator

from ..model import Extent, Flaw, Suppression, Suppressions
from ..rule import Context, Finding, Severity, rule
from ._words import nearest

GROUP = "suppression"

_HOW = "write ignore[rule-id] and the reason"
_HOW_IN_METADATA = 'write dictionary usdrenderLint = { string[] ignore = ["rule-id"] }'

_WORDS = ("ignore", "ignore-file")


@rule("bare-suppression", on=Suppressions, severity=Severity.WARNING, since="0.1")
def bare_suppression(suppressions: Suppressions, context: Context) -> Iterator[Finding]:
    """A suppression names no rule, and so silences none."""
    for one in suppressions.said:
        if one.flaw is Flaw.NO_RULE:
            yield Finding(
                one.site,
                "this suppression names no rule: nothing is ignored",
                label="which rule?",
                help=_HOW if one.in_comment else _HOW_IN_METADATA,
            )


@rule("misspelled-suppression", on=Suppressions, severity=Severity.WARNING, since="0.1")
def misspelled_suppression(suppressions: Suppressions, context: Context) -> Iterator[Finding]:
    """A suppression is misspelled, or names a rule that does not exist."""
    for one in suppressions.said:
        match one.flaw:
            case Flaw.UNKNOWN_RULE:
                said = f"there is no rule '{one.rule}': nothing is ignored"
                meant = nearest(one.rule, suppressions.rules)
                todo = f"did you mean '{meant}'?" if meant else "--list-rules shows them all"
                yield Finding(one.site, said, label="no such rule", help=todo)
            case Flaw.GROUP:
                said = f"'{one.rule}' stands for several rules: nothing is ignored"
                todo = "name the rule that is meant; --list-rules shows them all"
                yield Finding(one.site, said, label="no rule", help=todo)
            case Flaw.UNKNOWN_WORD:
                said = f"'{one.rule}' is no word for a suppression: nothing is ignored"
                yield Finding(one.site, said, label="unknown word", help=_meant(one))
            case Flaw.NOT_CLOSED:
                said = "the list of rules has no end: nothing is ignored"
                yield Finding(one.site, said, label="no ] follows", help=_HOW)
            case Flaw.NO_LIST:
                said = "this is no list of rules: nothing is ignored"
                yield Finding(one.site, said, label="no list of strings", help=_HOW_IN_METADATA)


def _meant(one: Suppression) -> str:
    meant = nearest(one.rule, _WORDS if one.in_comment else _WORDS[:1], 0.6)
    if meant:
        return f"did you mean '{meant}'?"
    return _HOW if one.in_comment else _HOW_IN_METADATA


@rule("unused-suppression", on=Suppressions, severity=Severity.WARNING, since="0.1")
def unused_suppression(suppressions: Suppressions, context: Context) -> Iterator[Finding]:
    """A suppression silences nothing."""
    for one in suppressions.said:
        if one.idle:
            yield Finding(
                one.site,
                f"'{one.rule}' is ignored {_where(one)}, but finds nothing there",
                label="silences nothing",
                help=f"take '{one.rule}' out, lest it hides the next mistake",
            )


def _where(one: Suppression) -> str:
    match one.extent:
        case Extent.LINE:
            return "on this line"
        case Extent.NEXT_LINE:
            return "on the line below"
        case Extent.LAYER:
            return "in this layer"
        case Extent.PRIM:
            return f"on <{one.site.path}> and below"
        case Extent.PROPERTY:
            return f"on <{one.site.path}>"

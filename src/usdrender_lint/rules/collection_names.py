"""Do the collections of a pass name what is there, in a form that USD can evaluate?"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

from ..likeness import likeness
from ..model import (
    Collection,
    Member,
    Pass,
    Pattern,
    Predicate,
    PredicateState,
    State,
)
from ..rule import Context, Finding, Severity, Sign, rule
from ._collections import UNSEEN
from ._handful import handful
from ._words import SIMILAR, joined, paths

GROUP = "collection"


@rule(
    "pattern-without-descendants",
    on=Pass,
    severity=Severity.WARNING,
    since="0.1",
    about=(Sign.COLLECTION,),
)
def pattern_without_descendants(render_pass: Pass, context: Context) -> Iterator[Finding]:
    """A pattern names a group, and not what is in it."""
    for found in render_pass.collections:
        if found.name in UNSEEN:
            yield from _cut_by_patterns(found)
            yield from _cut_by_rule(found)


def _cut_by_patterns(found: Collection) -> Iterator[Finding]:
    cut = [p for p in found.patterns if p.cut or p.names_groups]
    if cut:
        groups = dict.fromkeys(path for p in cut for path in p.cut)
        texts = [p.text for p in cut]
        yield Finding(
            cut[0],
            f"{joined([repr(text) for text in texts])} of '{found.name}' {'names' if len(cut) == 1 else 'name'} "
            f"only {paths(groups) or 'groups'}: what is below {UNSEEN[found.name]}",
            label="without what is below",
            help=f"write '{' '.join(f'{text}//' for text in texts)}'",
        )


def _cut_by_rule(found: Collection) -> Iterator[Finding]:
    """Includes that are not expanded name as little as patterns do."""
    if found.expansion_rule.value != "explicitOnly" or found.expression_counts:
        return
    groups = [m for m in found.members if m.is_group and m.live and m.path not in found.reached]
    if groups:
        yield Finding(
            groups[0],
            f"'{found.name}' includes only {paths(m.path for m in groups)}, by its expansionRule 'explicitOnly': what is below {UNSEEN[found.name]}",
            label="without what is below",
            help="leave the expansionRule out for 'expandPrims'",
            related=((found.expansion_rule, "says so"),),
        )


@rule(
    "unresolved-member",
    on=Pass,
    severity=Severity.WARNING,
    since="0.1",
    supersedes=("invalid-collection",),
    about=(Sign.COLLECTION,),
)
def unresolved_member(render_pass: Pass, context: Context) -> Iterator[Finding]:
    """A collection names a prim that does not exist."""
    for found in render_pass.collections:
        if found.lost:
            yield _lost(found)
        missing = [
            (member, said)
            for member, said in _named(found)
            if member.state in (State.MISSING, State.OVER)
        ]
        missing.sort(key=lambda pair: _topmost(pair[0]))
        groups = groupby(missing, key=lambda pair: _topmost(pair[0]))
        told = (_missing(list(group), top, render_pass) for top, group in groups)
        yield from handful(told, f"members of '{found.name}'")


def _named(found: Collection) -> Iterator[tuple[Member, str]]:
    """What a collection names literally, each with the words for it."""
    for verb, rel in (("includes", found.includes), ("excludes", found.excludes)):
        for target in rel.targets:
            if isinstance(target, Member) and ".collection:" not in target.path:
                yield target, f"'{found.name}' {verb} <{target.path}>"
    for pattern in found.patterns:
        said = f"'{found.name}' names <{pattern.start.path}>"
        if pattern.below or not pattern.names_all:
            said = f"'{pattern.text}' of '{found.name}' needs <{pattern.start.path}>"
        yield pattern.start, said


def _topmost(member: Member) -> str:
    """The first prim on the way to it that is not there."""
    if member.state is not State.MISSING or not member.nearest:
        return member.path
    above = member.nearest.rstrip("/")
    return f"{above}/{member.path[len(above) + 1 :].partition('/')[0]}"


def _missing(group: list[tuple[Member, str]], top: str, render_pass: Pass) -> Finding:
    member, said = group[0]
    why, label = "which does not exist", "no prim here"
    if member.state is State.OVER:
        why, label = "which is only an 'over' that no layer defines", "only an 'over'"
    elif member.is_property and not member.nearest:
        why, label = "which is no property of that prim", "no such property"
    others = len(group) - 1
    if others:
        why += f"; nor do{'es' if others == 1 else ''} {others} other{'s' if others > 1 else ''} below <{top}>"
    return Finding(
        member,
        f"{said}, {why}",
        label=label,
        help=_candidate(member, top, render_pass),
        related=tuple((m, "is missing, too") for m, _ in group[1:4]),
    )


def _candidate(member: Member, top: str, render_pass: Pass) -> str:
    if member.as_written and not member.as_written.startswith("."):
        return (
            f"write </{member.as_written}>: without the '/' it is relative to <{render_pass.path}>"
        )
    if member.state is State.OVER or not member.candidates:
        return "correct the path, or remove it"
    best = member.candidates[0].path
    if likeness(best.rpartition("/")[2], top.rpartition("/")[2]) >= SIMILAR:
        return f"did you mean <{best}>?"
    return f"prims that are there: {paths(c.path for c in member.candidates)}"


def _lost(found: Collection) -> Finding:
    first = found.lost[0]
    lost = [_spelt(one.path) for one in found.lost]
    shown = joined(lost) if len(lost) < 5 else f"{', '.join(lost[:4])} and {len(lost) - 4} more"
    lead = "which leads" if len(lost) == 1 else "which lead"
    return Finding(
        first,
        f"'{found.name}' loses {shown}, {lead} out of what <{first.arc_prim}> brings in: USD drops {'it' if len(lost) == 1 else 'them'}",
        label="dropped",
        help="write the collection in the layer that references, or sublayer this one",
        related=tuple((one, "is dropped, too") for one in found.lost[1:4]),
        severity=Severity.ERROR,
    )


def _spelt(path: str) -> str:
    """A path in angle brackets, a pattern in quotes."""
    return f"'{path}'" if any(c in path for c in "*?[{") or "//" in path else f"<{path}>"


@rule(
    "relative-pattern",
    on=Pass,
    severity=Severity.WARNING,
    since="0.1",
    supersedes=("unresolved-member",),
    about=(Sign.COLLECTION,),
)
def relative_pattern(render_pass: Pass, context: Context) -> Iterator[Finding]:
    """A pattern does not begin at the root, and so leads to something below the pass."""
    for found in render_pass.collections:
        for pattern in found.patterns:
            leads = pattern.start.path != render_pass.path and pattern.start.state is State.LIVE
            if pattern.relative and not leads:
                yield Finding(
                    pattern,
                    f"'{pattern.relative}' of '{found.name}' is relative to <{render_pass.path}>: "
                    f"it means '{pattern.text}', and nothing is there",
                    label="does not begin with '/'",
                    help="write the whole path, such as '/World/geo//'",
                )


@rule("unknown-predicate", on=Pass, severity=Severity.ERROR, since="0.1", about=(Sign.COLLECTION,))
def unknown_predicate(render_pass: Pass, context: Context) -> Iterator[Finding]:
    """USD does not know a predicate of an expression, or it can match nothing."""
    for found in render_pass.collections:
        for pattern in found.patterns:
            for predicate in pattern.predicates:
                if predicate.state is not PredicateState.KNOWN:
                    yield _unknown(pattern, predicate, found)


_ARGUMENTS = {
    "kind": (
        "names no kind that is registered here",
        "there are component, subcomponent, assembly, group, and what the studio registers",
    ),
    "specifier": ("names no specifier", "there are def, over and class"),
    "variant": ("does not name a variant set", 'write {variant(set="selection")}'),
}
"""What is wrong where a predicate refuses its arguments, and what it takes."""


def _unknown(pattern: Pattern, predicate: Predicate, found: Collection) -> Finding:
    name, text = predicate.name, f"{{{predicate.text}}}"
    meant = f"did you mean '{{{predicate.meant}}}'?" if predicate.meant else ""
    match predicate.state:
        case PredicateState.UNKNOWN:
            said = f"USD knows no predicate '{name}': '{found.name}' cannot be evaluated"
            todo = meant or "there are isa, hasAPI, kind, model, group, variant, specifier ..."
            severity, label = None, "no such predicate"
        case PredicateState.HYDRA:
            said = f"only Hydra knows the predicate '{name}': USD itself cannot evaluate '{found.name}'"
            todo = "write paths, or a predicate of USD such as isa"
            severity, label = Severity.WARNING, "not of USD"
        case PredicateState.NO_SUCH_TYPE:
            said = f"'{text}' matches nothing: there is no such type"
            todo, severity, label = meant, Severity.WARNING, "no such type"
        case _:
            why, todo = _ARGUMENTS.get(
                name, ("is not how it is asked", "see the predicates of USD")
            )
            said = f"'{text}' {why}: '{found.name}' cannot be evaluated"
            # A kind may be registered where the file is rendered.
            severity = Severity.WARNING if name == "kind" and ":" in text else None
            label = "not evaluated"
    return Finding(pattern, said, label=label, help=todo, severity=severity)

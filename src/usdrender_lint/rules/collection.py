"""Are the collections of a pass written so that USD makes of them what was meant?"""

from __future__ import annotations

from collections.abc import Iterator

from ..model import Collection, HasSite, Pass, Target, ValueState
from ..rule import Context, Finding, Severity, Sign, rule
from ._collections import VISIBILITY, includes_all, is_written
from ._handful import handful
from ._words import one_of

GROUP = "collection"

EXPANSION_RULES = ("explicitOnly", "expandPrims", "expandPrimsAndProperties")


@rule("ignored-membership", on=Pass, severity=Severity.ERROR, since="0.1", about=(Sign.COLLECTION,))
def ignored_membership(render_pass: Pass, context: Context) -> Iterator[Finding]:
    """A collection is written in two styles, and one of them is ignored."""
    for found in render_pass.collections:
        if is_written(found) and not found.expression_counts:
            reason, todo = _why_ignored(found)
            yield Finding(
                found.expression,
                f"the membershipExpression of '{found.name}' is ignored: {reason}",
                label="not evaluated",
                help=todo,
            )
        elif found.mode.value == "expression":
            for rel in (found.includes, found.excludes):
                if rel.targets:
                    yield Finding(
                        rel,
                        f"{rel.name.rpartition(':')[2]} of '{found.name}' are ignored: its mode is 'expression'",
                        label="not evaluated",
                        help="put them into the membershipExpression, or leave mode out",
                        related=((found.mode, "says so"),),
                    )


def _why_ignored(found: Collection) -> tuple[str, str]:
    prefix = f"collection:{found.name}"
    if found.mode.value == "relationship":
        return "its mode is 'relationship'", f"remove {prefix}:mode"
    listed = [r.name.rpartition(":")[2] for r in (found.includes, found.excludes) if r.targets]
    if listed:
        return (
            f"{' and '.join(listed)} are there too, and relationships win",
            f"remove the {' and '.join(listed)}, or put them into the expression",
        )
    if found.include_root.state is ValueState.AUTHORED:
        return "includeRoot is true, so everything is included", f"set {prefix}:includeRoot = false"
    return (
        "includeRoot falls back to true here, so everything is included",
        f"write uniform bool {prefix}:includeRoot = false",
    )


@rule("redundant-includes", on=Pass, severity=Severity.ERROR, since="0.1", about=(Sign.COLLECTION,))
def redundant_includes(render_pass: Pass, context: Context) -> Iterator[Finding]:
    """Includes are listed in a collection that includes everything already."""
    for found in render_pass.collections:
        if not includes_all(found) or is_written(found) or not found.includes.targets:
            continue
        # Another collection brings its excludes along.
        if found.others or _reincludes(found):
            continue
        authored = found.include_root.state is ValueState.AUTHORED
        why = "includeRoot is true" if authored else "includeRoot falls back to true here"
        yield Finding(
            found.includes,
            f"the includes of '{found.name}' change nothing: {why}, so everything is included",
            label="everything is, already",
            help=f"write uniform bool collection:{found.name}:includeRoot = false",
            related=((found.include_root, "says so"),) if authored else (),
            severity=Severity.WARNING if authored else None,
        )


def _reincludes(found: Collection) -> bool:
    """Some include brings back what an exclude took away."""
    return any(
        i.path == e.path or i.path.startswith(e.path + "/")
        for i in found.includes.targets
        for e in found.excludes.targets
    )


@rule(
    "excludes-without-includes",
    on=Pass,
    severity=Severity.ERROR,
    since="0.1",
    about=(Sign.COLLECTION,),
)
def excludes_without_includes(render_pass: Pass, context: Context) -> Iterator[Finding]:
    """A collection takes out of nothing."""
    for found in render_pass.collections:
        if includes_all(found) or found.includes.named or not found.excludes.targets:
            continue
        if found.expression.authored or found.mode.value == "expression":
            continue
        prefix = f"collection:{found.name}"
        if found.name in VISIBILITY:
            why, severity = "includeRoot is false", None
            todo = f"remove {prefix}:includeRoot to have everything but these"
        else:
            why, severity = "includeRoot falls back to false here", Severity.WARNING
            todo = f"write uniform bool {prefix}:includeRoot = true to have everything but these"
        if found.expansion_rule.value == "explicitOnly":
            why, todo = "nothing is expanded by its expansionRule", "list what it is to hold"
        yield Finding(
            found.excludes,
            f"'{found.name}' has excludes and no includes, and {why}: it holds nothing",
            label="taken out of nothing",
            help=todo,
            related=((found.include_root, "says so"),) if found.include_root.authored else (),
            severity=severity,
        )


@rule("empty-visibility", on=Pass, severity=Severity.WARNING, since="0.1", about=(Sign.COLLECTION,))
def empty_visibility(render_pass: Pass, context: Context) -> Iterator[Finding]:
    """Nothing is visible by the visibility of a pass, which renderers understand differently."""
    for found in render_pass.collections:
        if found.name not in VISIBILITY or includes_all(found) or found.lost:
            continue
        named = found.includes.named or found.excludes.named or found.patterns or found.others
        if named or found.expression.state is ValueState.MISTYPED:
            continue
        at = _why_empty(found)
        yield Finding(
            at,
            f"'{found.name}' of <{render_pass.path}> holds nothing: some renderers draw nothing, RenderMan draws everything",
            label="nothing else is said",
            help="list what is to be seen, or leave includeRoot true",
        )


def _why_empty(found: Collection) -> HasSite:
    whys: tuple[tuple[bool, HasSite], ...] = (
        (found.expression.authored, found.expression),
        (found.include_root.authored and not found.include_root.value, found.include_root),
        (found.mode.authored, found.mode),
        (found.expansion_rule.authored, found.expansion_rule),
    )
    return next((at for here, at in whys if here), found.include_root)


@rule(
    "invalid-collection",
    on=Pass,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=("disallowed-token",),
    about=(Sign.COLLECTION,),
)
def invalid_collection(render_pass: Pass, context: Context) -> Iterator[Finding]:
    """USD refuses a collection, or a part of it has no effect."""
    circular = [c for c in render_pass.collections if "circular" in (c.problem or "")]
    for found in circular[:1]:
        yield _circular(found)
    for found in render_pass.collections:
        rule_token = found.expansion_rule
        if rule_token.authored and rule_token.value not in EXPANSION_RULES:
            yield Finding(
                rule_token,
                f"expansionRule '{rule_token.value}' of '{found.name}' is not {one_of(EXPANSION_RULES)}: USD refuses the collection",
                label="no such rule",
                help="leave it out for 'expandPrims'",
            )
            continue
        if found.problem is not None and found not in circular:
            yield from _refused(found)
        for target in found.excludes.targets:
            if _is_collection(target):
                yield Finding(
                    target,
                    f"'{found.name}' excludes the collection <{target.path}>, which takes nothing out: only prims can be excluded",
                    label="excludes nothing",
                    help="list the prims that the collection holds",
                )
        for pattern in found.patterns:
            if pattern.crashes:
                yield Finding(
                    pattern,
                    f"'{pattern.text}' can crash USD: its condition stands behind '//' and before another name",
                    label="crashes USD",
                    help=f"write '{pattern.text.replace('//{', '//*{')}'",
                )


def _is_collection(target: Target) -> bool:
    return ".collection:" in target.path


def _circular(found: Collection) -> Finding:
    return Finding(
        found.others[0] if found.others else found,
        f"'{found.name}' takes in itself, by way of the collections that it takes in: USD refuses it",
        label="leads back",
        help="break the circle: list the prims instead",
    )


def _refused(found: Collection) -> Iterator[Finding]:
    included = [t.path for t in found.includes.targets]
    stray = [
        target
        for target in found.excludes.targets
        if not any(target.path == i or target.path.startswith(i + "/") for i in included)
    ]
    if any(map(_is_collection, stray)):
        return  # that excluding a collection has no effect is said anyway
    if stray and not found.others:
        told = (
            Finding(
                target,
                f"'{found.name}' excludes <{target.path}>, which nothing includes: USD refuses the collection",
                label="not included",
                help="remove it, or include a prim above it",
            )
            for target in stray
        )
        yield from handful(told, "excludes")
    else:
        yield Finding(
            found.excludes,
            f"'{found.name}' excludes more than it includes: USD refuses the collection",
            label="partly outside",
            help="exclude only prims below those that are included",
        )


@rule(
    "collection-mode-portability",
    on=Pass,
    severity=Severity.NOTE,
    since="0.1",
    default=False,
    about=(Sign.COLLECTION,),
)
def collection_mode_portability(render_pass: Pass, context: Context) -> Iterator[Finding]:
    """A collection's mode is written, which older versions of USD do not know."""
    for found in render_pass.collections:
        if found.mode.authored and found.mode.value != "automatic":
            yield Finding(
                found.mode,
                f"mode '{found.mode.value}' of '{found.name}' is new in USD 26: older versions decide by what else is written",
                label="not known before",
                help="write the other style away instead, and includeRoot = false for an expression",
            )

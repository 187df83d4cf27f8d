"""Do the relationships of the render spec lead to what they need?"""

from __future__ import annotations

import re
from collections.abc import Iterator
from fnmatch import fnmatchcase

from ..model import EXPECTED, Pass, Property, Rel, RenderPrim, RenderScope, Site, State, Target
from ..rule import Context, Finding, Renderer, Severity, Sign, rule
from ._chains import start_of, why_not_live
from ._handful import LACKING
from ._words import a_or_an, did_you_mean, meant_instead, nearest, probably_meant

GROUP = "property"

_WORDS = {
    "camera": ("camera", "cameras"),
    "products": ("product", "RenderProducts"),
    "orderedVars": ("var", "RenderVars"),
    "renderSource": ("render source", "RenderSettings"),
    "inputPasses": ("input pass", "RenderPasses"),
}
_WANTED = {name: (one, EXPECTED[name], several) for name, (one, several) in _WORDS.items()}
_ONLY_FIRST = ("camera", "renderSource")
_DEAD = {
    State.INACTIVE: "is inactive",
    State.OVER: "is only an 'over', which no layer defines",
    State.ABSTRACT: "is a class, or stands below one",
}
_SHOWN = 3
"""Further targets that a finding names."""


def _judged(prim: RenderPrim) -> Iterator[tuple[Rel, Target]]:
    """Targets that a renderer follows. A pass of an external application may point anywhere; and where
    only the first target counts, nothing depends on the others: that they are there is the fault."""
    for rel in prim.rels:
        if rel.name == "renderSource" and isinstance(prim, Pass) and prim.file_name.authored:
            continue
        for target in rel.targets[: 1 if rel.name in _ONLY_FIRST else None]:
            yield rel, target


def _is_host_prim(target: Target, renderer: Renderer) -> bool:
    return any(fnmatchcase(target.path, pattern) for pattern in renderer.host_prims)


def _is_relative(target: Target) -> bool:
    """Written without the leading slash, where the path from the root was meant."""
    if target.state is not State.MISSING or target.via or target.meant is None:
        return False
    written = target.as_written
    return target.probably_relative or (written is not None and not written.startswith("."))


@rule(
    "relative-target",
    on=RenderPrim,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=("unresolved-target", "missing-camera"),
    about=(Sign.ODD_TARGET,),
)
def relative_target(prim: RenderPrim, context: Context) -> Iterator[Finding]:
    """A target is written without a leading `/` and leads nowhere."""
    for _, target in _judged(prim):
        if not _is_relative(target):
            continue
        written = target.as_written or (target.meant or "")[1:]
        said = f"<{written}> is relative to <{prim.path}>: it leads to <{target.path}>, which does not exist"
        if not target.as_written:
            said = f"<{target.path}> does not exist: it was probably written as <{written}>, which is relative to <{prim.path}>"
        yield Finding(
            target,
            said,
            label="no leading '/'",
            help=f"write <{target.meant or '/' + written}>",
        )


@rule(
    "unresolved-target",
    on=RenderPrim,
    severity=Severity.ERROR,
    since="0.1",
    about=(Sign.ODD_TARGET,),
)
def unresolved_target(prim: RenderPrim, context: Context) -> Iterator[Finding]:
    """A camera, product, var, render source or input pass does not exist."""
    for rel, target in _judged(prim):
        what, kind, plural = _WANTED[rel.name]
        if target.state is State.UNKNOWN:
            if meant := probably_meant(target):
                yield Finding(
                    target.written,
                    f"{what} <{target.path}> is nowhere in what could be opened, and <{meant.path}> is there",
                    label="perhaps misspelt",
                    help=meant_instead(target, meant),
                    related=(*start_of(target), (meant.site, f"is {a_or_an(meant.type_name)}")),
                    severity=Severity.NOTE,
                )
            continue
        if target.state is not State.MISSING or _is_host_prim(target, context.renderer):
            continue
        if target.perhaps_elsewhere and not target.only_in:
            yield Finding(
                target.written,
                f"{what} <{target.path}> is not here: this layer holds render prims only",
                label="not in this layer",
                help="lint the shot that brings both in, to see whether it is there",
                related=tuple(start_of(target)),
                severity=Severity.NOTE,
            )
            continue
        if target.only_in:
            yield Finding(
                target.written,
                f"{what} <{target.path}> does not exist: it is only in {target.only_in}, which is not selected",
                label="in another variant",
                help="select that variant, or point at a prim that all variants have",
                related=tuple(start_of(target)),
            )
            continue
        why = f": <{target.as_written}> is relative to <{prim.path}>" if target.as_written else ""
        yield Finding(
            target.written,
            f"{what} <{target.path}> does not exist{why}",
            label="no such property" if target.is_property else "no prim here",
            help=did_you_mean(target, kind, plural),
            related=(
                *start_of(target),
                *((c.site, f"is {a_or_an(c.type_name)}") for c in target.candidates[:1]),
            ),
        )


@rule(
    "wrong-target-type",
    on=RenderPrim,
    severity=Severity.ERROR,
    since="0.1",
    about=(Sign.ODD_TARGET,),
)
def wrong_target_type(prim: RenderPrim, context: Context) -> Iterator[Finding]:
    """A target exists and is of the wrong type."""
    for rel, target in _judged(prim):
        what, kind, plural = _WANTED[rel.name]
        if target.state in (State.MISSING, State.UNKNOWN) or not _is_wrong(target, kind, context):
            continue
        if target.is_property:
            if isinstance(prim, Pass) and prim.command.value:
                continue  # a node of the application that the command starts
            found = "a property"
        elif meant := _misspelt_type(target, kind):
            yield Finding(
                Site(target.path, "typeName"),
                f"{what} <{target.path}> is {a_or_an(target.type_name)}, which is no type of USD: nobody takes it for {a_or_an(kind)}",
                label="no such type",
                help=f"did you mean {meant}?",
                related=((target.written, "leads there"),),
            )
            continue
        else:
            found = a_or_an(target.type_name) if target.type_name else "a prim without a type"
        yield Finding(
            target.written,
            f"{what} <{target.path}> is {found}, not {a_or_an(kind)}",
            label=found,
            help=did_you_mean(target, kind, plural),
            related=(*start_of(target), (Site(target.path), f"is {found}")),
        )


def _misspelt_type(target: Target, kind: str) -> str | None:
    """Types of render prims have a rule of their own, which looks at all of them."""
    if target.type_known or kind != "Camera":
        return None
    bare = re.sub("^Usd(Geom)?", "", target.type_name)
    return kind if bare == "Cam" else nearest(bare, [kind])


def _is_wrong(target: Target, kind: str, context: Context) -> bool:
    if target.is_property:
        return True
    if kind in target.isa:
        return False
    if kind == "Camera" and context.renderer.accepts_camera(target.type_name):
        return False
    if not target.type_name:
        return target.state is State.LIVE
    return target.type_known or _misspelt_type(target, kind) is not None


@rule(
    "dead-target",
    on=RenderScope,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=("dangling-over",),
    about=(Sign.ODD_TARGET,),
)
def dead_target(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A target is inactive, only an `over`, or abstract."""
    leading: dict[str, list[tuple[Rel, Target]]] = {}
    for prim in scope.prims():
        for rel, target in _judged(prim) if prim.live else ():
            if _is_dead(rel, target, context):
                leading.setdefault(target.path, []).append((rel, target))
    for found in leading.values():
        # The one that costs most tells for all: to bring the prim to life mends every one of them.
        (rel, target), *others = sorted(found, key=_is_one_of_several)
        said = _DEAD[target.state]
        if target.because:
            said = f"is inactive, as <{target.because}> is"
        yield Finding(
            target.written,
            f"{_WANTED[rel.name][0]} <{target.path}> {said}: renderers drop it",
            label="not live",
            help="remove the target, or bring the prim to life",
            related=(
                *start_of(target),
                why_not_live(target),
                *((other.written, "leads there, too") for _, other in others[:_SHOWN]),
            ),
            severity=Severity.WARNING if _is_one_of_several((rel, target)) else None,
            explains=(Site(target.path),),
        )


def _is_dead(rel: Rel, target: Target, context: Context) -> bool:
    if target.state not in _DEAD or _is_host_prim(target, context.renderer):
        return False
    return not (target.type_name and _is_wrong(target, _WANTED[rel.name][1], context))


def _is_one_of_several(found: tuple[Rel, Target]) -> bool:
    rel, _ = found
    return any(t.live for t in rel.targets) and rel.name not in _ONLY_FIRST


@rule(
    "target-outside-reference",
    on=RenderPrim,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=("unresolved-target", "missing-camera", "product-without-vars"),
    about=(Sign.ODD_TARGET,),
)
def target_outside_reference(prim: RenderPrim, context: Context) -> Iterator[Finding]:
    """A target leads out of the layer that is referenced, and USD drops it."""
    for rel in prim.rels:
        if rel.name in _ONLY_FIRST and rel.targets:
            continue  # a stronger layer names it anew
        for lost in rel.lost:
            what = _WANTED[rel.name][0]
            yield Finding(
                lost.site,
                f"{what} <{lost.path}> stands outside what <{lost.arc_prim}> brings in, so USD drops it",
                label="dropped",
                help="write the relationship again in the layer that references, or sublayer this one",
                related=((Site(lost.arc_prim, lost.arc_field), "brings the layer in"),),
            )


@rule(
    "kind-mismatch",
    on=RenderPrim,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=(*LACKING, "unresolved-target"),
    by_itself=True,
    about=(Sign.ODD_PROPERTY,),
)
def kind_mismatch(prim: RenderPrim, context: Context) -> Iterator[Finding]:
    """A relationship is authored as an attribute, or an attribute as a relationship."""
    for found in prim.properties:
        if not found.is_schema or found.is_relationship == found.schema_is_relationship:
            continue
        yield Finding(
            found,
            f"'{found.name}' is {_kind(found.schema_is_relationship)}, but is authored as "
            f"{_kind(found.is_relationship)}: it has no effect",
            label=f"not {_kind(found.schema_is_relationship)}",
            help=_right_form(found),
        )


def _kind(is_relationship: bool) -> str:
    return "a relationship" if is_relationship else "an attribute"


def _right_form(found: Property) -> str:
    if found.schema_is_relationship:
        return f"write rel {found.name} = </path>"
    return f"write {found.schema_type} {found.name} = ..."


@rule(
    "forwarded-target",
    on=RenderPrim,
    severity=Severity.NOTE,
    since="0.1",
    default=False,
    about=(Sign.ODD_TARGET,),
)
def forwarded_target(prim: RenderPrim, context: Context) -> Iterator[Finding]:
    """A target leads to its prim by way of another relationship, which some renderers do not follow."""
    for rel, target in _judged(prim):
        what, kind, _ = _WANTED[rel.name]
        if target.via and target.live and kind in target.isa:
            yield Finding(
                target,
                f"{what} <{target.path}> is reached by way of <{target.via}>: husk, Arnold and usdrecord do not follow it",
                label="forwards",
                help=f"write <{target.path}>",
            )

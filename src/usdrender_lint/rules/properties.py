"""Are the render prims and their properties what their schemas call them?"""

from __future__ import annotations

from collections.abc import Iterator

from ..likeness import likeness
from ..model import (
    RENDER_TYPES,
    Described,
    OtherPrim,
    Property,
    RenderPrim,
    RenderScope,
    Settings,
    Site,
    State,
)
from ..rule import Context, Finding, Severity, Sign, rule
from ._handful import LACKING
from ._words import a_or_an, joined, nearest, one_of

GROUP = "property"


@rule(
    "misspelled-property",
    on=Described,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=LACKING,
    by_itself=True,
    about=(Sign.ODD_PROPERTY,),
)
def misspelled_property(prim: Described, context: Context) -> Iterator[Finding]:
    """A property is nearly, but not quite, one of the schema's."""
    for found in prim.properties:
        if found.is_schema or ":" in found.name or found.belongs_to or not found.has_value:
            continue
        if found.name in context.renderer.properties:
            continue
        meant = nearest(found.name, prim.built_in)
        if meant is not None:
            yield Finding(
                Site(f"{prim.path}.{found.name}"),
                f"'{found.name}' is no property of {a_or_an(prim.type_name)}: nobody reads it",
                label="nobody reads this",
                help=f"did you mean '{meant}'?",
                explains=(
                    Site(f"{prim.path}.{meant}"),
                    *(Site(f"{path}.{meant}") for path in _taking_from(prim)),
                ),
            )


def _taking_from(prim: Described) -> Iterator[str]:
    """The products of settings, which take from them what they do not say themselves."""
    if isinstance(prim, Settings):
        yield from (t.path for t in prim.products.targets)


@rule(
    "misplaced-property",
    on=RenderPrim,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=(
        "empty-product-name",
        "empty-source-name",
        "input-pass-without-output",
        "product-without-vars",
    ),
    by_itself=True,
    about=(Sign.ODD_PROPERTY,),
)
def misplaced_property(prim: RenderPrim, context: Context) -> Iterator[Finding]:
    """A property stands on the wrong kind of render prim."""
    for found in prim.properties:
        if found.is_schema or not found.belongs_to or not found.has_value:
            continue
        # Some studios' tools read a camera on the pass.
        tolerated = found.name == "camera" and prim.type_name == "RenderPass"
        yield Finding(
            Site(f"{prim.path}.{found.name}"),
            f"'{found.name}' has no effect on {a_or_an(prim.type_name)}",
            label="nobody reads this here",
            help=f"it belongs on {joined([a_or_an(t) for t in found.belongs_to]).replace(' and ', ' or ')}",
            severity=Severity.WARNING if tolerated else None,
            explains=tuple(_left_without(prim, found)),
        )


def _left_without(prim: RenderPrim, found: Property) -> Iterator[Site]:
    """The property where it was probably meant: on the only prim that this one leads to and that may
    have it. Of several, the others would still lack it."""
    owners = {t.path for rel in prim.rels for kind in found.belongs_to for t in rel.of_type(kind)}
    if len(owners) == 1:
        yield Site(f"{owners.pop()}.{found.name}")
    else:
        yield found.site


@rule(
    "type-mismatch",
    on=Described,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=(
        "empty-product-name",
        "empty-source-name",
        "input-pass-without-output",
        "variability-mismatch",
    ),
    by_itself=True,
    about=(Sign.ODD_PROPERTY,),
)
def type_mismatch(prim: Described, context: Context) -> Iterator[Finding]:
    """A schema attribute is authored with another type, so renderers do not read it."""
    for found in prim.properties:
        if found.type_fits or found.is_relationship or not found.has_value:
            continue
        if (found.name, found.type_name) in context.renderer.accepted_types:
            continue
        yield Finding(
            found,
            f"'{found.name}' is authored as {found.type_name}, but its type is {found.schema_type}: renderers do not read it",
            label=f"not {found.schema_type}",
            help=f"write {'uniform ' if found.schema_uniform else ''}{found.schema_type} {found.name}",
        )


@rule(
    "unknown-prim-type",
    on=RenderScope,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=("default-settings-wrong-type", "wrong-target-type"),
    about=(Sign.OTHER_PRIM,),
)
def unknown_prim_type(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A prim's type is nearly, but not quite, one of the render types."""
    for prim in scope.others:
        if prim.type_known or not (meant := _meant_type(prim.type_name)):
            continue
        yield Finding(
            Site(prim.path, "typeName"),
            f"'{prim.type_name}' is no type of USD: nobody takes <{prim.path}> for {a_or_an(meant)}",
            label="no such type",
            help=f"did you mean {meant}?",
        )


def _meant_type(name: str) -> str | None:
    bare = name[3:] if name.lower().startswith("usd") else name
    best = max(RENDER_TYPES, key=lambda t: likeness(bare, t))
    if bare != best and bare.endswith(best):
        return None  # a plug-in's own, such as PxrRenderSettings
    return best if likeness(bare, best) >= 0.87 else None


@rule(
    "untyped-render-prim",
    on=RenderScope,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=("default-settings-wrong-type", "wrong-target-type"),
    about=(Sign.OTHER_PRIM,),
)
def untyped_render_prim(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A prim has the properties of a render prim and no type."""
    rels = [rel for prim in scope.prims() for rel in prim.rels]
    forwarding = {by for rel in rels for by in rel.forwarding}
    for prim in scope.others:
        if prim.type_name or prim.state is not State.LIVE or prim.behind_failed_arc:
            continue
        names = [p.name for p in prim.properties if p.belongs_to]
        if all(f"{prim.path}.{name}" in forwarding for name in names):
            continue  # nothing of a render prim, or a hub that others' targets pass through
        meant = _types_with(prim)
        quoted = joined([f"'{n}'" for n in names[:4]])
        yield Finding(
            prim,
            f"<{prim.path}> has {quoted} but no type: nobody takes it for a render prim",
            label="no type",
            help=f'write def {meant[0]} "{prim.name}"'
            if len(meant) == 1
            else f"give it a type: {one_of(meant or RENDER_TYPES)}",
        )


def _types_with(prim: OtherPrim) -> list[str]:
    """The render types that have all of its properties."""
    owners = [set(p.belongs_to) for p in prim.properties if p.belongs_to]
    return [t for t in RENDER_TYPES if all(t in o for o in owners)]

"""Does composition give the render prims what their layers meant?"""

from __future__ import annotations

from collections.abc import Iterator

from ..model import Product, RenderPrim, RenderScope, Site, ValueState
from ..rule import Context, Finding, Severity, Sign, rule
from ._words import nearest, one_of, paths, spelt

GROUP = "layer"


@rule(
    "missing-variant",
    on=RenderScope,
    severity=Severity.WARNING,
    since="0.1",
    about=(Sign.MISSING_VARIANT,),
)
def missing_variant(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A prim of the render scope selects a variant that does not exist."""
    for choice in scope.missing_variants:
        meant = nearest(choice.selection, choice.choices, 0.6)
        if meant:
            todo = f"did you mean '{meant}'?"
        elif choice.choices:
            todo = f"choose {one_of(choice.choices)}"
        else:
            todo = f"no layer has a variant set '{choice.variant_set}' with variants here"
        yield Finding(
            choice.site,
            f"<{choice.prim}> selects the variant '{choice.selection}' of '{choice.variant_set}', which does not exist: nothing of it is composed",
            label="no such variant",
            help=todo,
        )


@rule(
    "clobbered-targets",
    on=RenderPrim,
    severity=Severity.NOTE,
    since="0.1",
    about=(Sign.ODD_TARGET,),
)
def clobbered_targets(prim: RenderPrim, context: Context) -> Iterator[Finding]:
    """A stronger layer's list replaces a weaker layer's products or vars."""
    for rel in prim.rels:
        if rel.name not in ("products", "orderedVars") or not rel.clobbered or not rel.authored:
            continue
        dropped = dict.fromkeys(c.path for c in rel.clobbered)
        yield Finding(
            rel,
            f"this list of {rel.name} replaces that of a weaker layer, and drops {paths(dropped)}",
            label="replaces a weaker list",
            help=f"write prepend rel {rel.name} to add to it, if that was meant",
            related=tuple((c.site, "is dropped") for c in rel.clobbered[:3]),
        )


@rule(
    "conflicting-prim-type",
    on=RenderPrim,
    severity=Severity.WARNING,
    since="0.1",
    supersedes=(
        "default-settings-wrong-type",
        "misplaced-property",
        "product-without-vars",
        "settings-without-products",
        "wrong-target-type",
    ),
    about=(Sign.OTHER_TYPE,),
)
def conflicting_prim_type(prim: RenderPrim, context: Context) -> Iterator[Finding]:
    """Layers disagree on the type of a render prim."""
    for other in prim.other_types[:1]:
        yield Finding(
            Site(prim.path, "typeName"),
            f"<{prim.path}> is a {prim.type_name} here and a {other.type_name} in a weaker layer, whose properties do not fit it",
            label=f"a {prim.type_name}",
            help="rename one of the two",
            related=((other.site, f"makes it a {other.type_name}"),),
        )


@rule("blocked-value", on=RenderPrim, severity=Severity.WARNING, since="0.1", about=(Sign.BLOCKED,))
def blocked_value(prim: RenderPrim, context: Context) -> Iterator[Finding]:
    """A value is blocked, which kills the fallback, too."""
    for attr in prim.attrs():
        if attr.state is not ValueState.BLOCKED:
            continue
        inherits = isinstance(prim, Product) and attr.name in _shared()
        refused = attr.name in ("dataType", "sourceType")
        if inherits:
            said = f"'{attr.name}' is blocked: the product takes the settings' value, but frame readers the fallback"
        else:
            said = f"'{attr.name}' is blocked, which kills its fallback, too: it reads as {_empty(attr.value)}"
        yield Finding(
            attr,
            said,
            label="= None",
            help="remove the line for the fallback, or write the value",
            severity=Severity.NOTE if inherits else Severity.ERROR if refused else None,
        )


def _shared() -> set[str]:
    """Attributes that a product may take from its settings."""
    return {
        "resolution",
        "pixelAspectRatio",
        "aspectRatioConformPolicy",
        "dataWindowNDC",
        "disableMotionBlur",
        "disableDepthOfField",
        "instantaneousShutter",
    }


def _empty(value: object) -> str:
    return "empty" if value in ("", ()) else spelt(value)

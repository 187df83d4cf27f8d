"""Does a collection exist, and do the others that it takes in give it anything?"""

from __future__ import annotations

from collections.abc import Iterator

from ..model import Gives, OtherCollection, Pass, Property, RenderPrim
from ..rule import Context, Finding, Severity, Sign, rule
from ._collections import is_written
from ._words import nearest, one_of

GROUP = "collection"

PROPERTIES = (
    "excludes",
    "expansionRule",
    "includeRoot",
    "includes",
    "membershipExpression",
    "mode",
)


@rule(
    "unknown-collection",
    on=RenderPrim,
    severity=Severity.WARNING,
    since="0.1",
    about=(Sign.COLLECTION_PROPERTY,),
)
def unknown_collection(prim: RenderPrim, context: Context) -> Iterator[Finding]:
    """A property belongs to a collection that the prim does not have."""
    told: set[str] = set()
    for prop in prim.properties:
        name, _, last = prop.name.removeprefix("collection:").rpartition(":")
        if not prop.name.startswith("collection:") or not name or name in told:
            continue
        if name not in prim.collections_applied:
            told.add(name)
            yield _not_applied(prim, prop, name)
        elif last not in PROPERTIES and (meant := nearest(last, PROPERTIES)):
            yield Finding(
                prop,
                f"collections have no '{last}': USD ignores '{prop.name}'",
                label="no such property",
                help=f"did you mean '{meant}'?",
            )


def _not_applied(prim: RenderPrim, prop: Property, name: str) -> Finding:
    meant = nearest(name, prim.collections_applied, 0.7)
    todo = (
        f"did you mean '{meant}'?"
        if meant
        else f'apply it: prepend apiSchemas = ["CollectionAPI:{name}"]'
    )
    return Finding(
        prop,
        f"<{prim.path}> has no collection '{name}': USD ignores '{prop.name}'",
        label="no such collection",
        help=todo,
    )


@rule(
    "missing-included-collection",
    on=Pass,
    severity=Severity.ERROR,
    since="0.1",
    about=(Sign.COLLECTION,),
)
def missing_included_collection(render_pass: Pass, context: Context) -> Iterator[Finding]:
    """A collection takes in another one that does not exist, or that gives it nothing."""
    for found in render_pass.collections:
        for other in found.others:
            by_reference = other.as_written.startswith("%")
            if by_reference != found.expression_counts and is_written(found):
                continue  # that side is ignored
            match other.gives:
                case Gives.NO_PRIM:
                    said = f"<{other.path}> does not exist"
                    todo = "correct the path, or list the prims"
                case Gives.NO_COLLECTION:
                    said = f"<{other.path}> has no collection '{other.name}'"
                    todo = _which(other)
                case Gives.WRONG_MODE:
                    said, todo = _wrong_mode(other)
                case _:
                    continue
            shown = f"'{other.as_written}'" if by_reference else f"<{other.as_written}>"
            yield Finding(
                other,
                f"'{found.name}' gets nothing from {shown}: {said}",
                label="gives nothing",
                help=todo,
            )


def _which(other: OtherCollection) -> str:
    if other.has_opinions:
        return f'apply it: prepend apiSchemas = ["CollectionAPI:{other.name}"] on <{other.path}>'
    if meant := nearest(other.name, other.applied, 0.7):
        return f"did you mean '{meant}'?"
    if other.applied:
        return f"it has {one_of(sorted(other.applied))}"
    return "list the prims, or make the collection"


def _wrong_mode(other: OtherCollection) -> tuple[str, str]:
    if other.as_written.startswith("%"):
        return (
            "an expression takes nothing from a collection of includes",
            f"include it: <{other.path}.collection:{other.name}>",
        )
    return (
        "it is made of an expression, of which includes take nothing",
        f"refer to it in an expression: %{other.path}:{other.name}",
    )

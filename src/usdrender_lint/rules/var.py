"""Does each var say what to output, in a form that exists?"""

from __future__ import annotations

from collections.abc import Iterator
from fnmatch import fnmatchcase

from ..model import RenderScope, ValueState, Var
from ..rule import Context, Finding, Severity, Sign, rule
from ._handful import handful
from ._used import used
from ._words import nearest, one_of

GROUP = "var"

SOURCE_TYPES = ("raw", "primvar", "lpe", "intrinsic")


@rule(
    "empty-source-name",
    on=RenderScope,
    severity=Severity.WARNING,
    since="0.1",
    supersedes=("blocked-value",),
    about=("orderedVars", Sign.ODD_PROPERTY),
)
def empty_source_name(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A var that a product lists does not name its source."""
    for var in used(scope, context) if scope.products else ():
        if var.source_name.value.strip() or var.maybe_more:
            continue
        if var.source_name.state is ValueState.MISTYPED or _named_otherwise(var, context):
            continue
        yield _without_source(var)


def _named_otherwise(var: Var, context: Context) -> bool:
    patterns = context.renderer.source_name_attributes
    if var.source_type.value in ("lpe", "primvar"):
        # The name of the channel says neither the expression nor the primvar.
        patterns = patterns.difference(context.renderer.aov_name_attributes)
    return any(fnmatchcase(p.name, pattern) for p in var.properties for pattern in patterns)


def _without_source(var: Var) -> Finding:
    match var.source_type.value:
        case "lpe":
            needs, example = "the light path expression", "C.*"
        case "primvar":
            needs, example = "the primvar", "st"
        case _:
            needs, example = "", var.name
    lacks = f": '{var.source_type.value}' needs {needs} here" if needs else ""
    return Finding(
        var.source_name,
        f"<{var.path}> has no sourceName{lacks or ': what is it to hold?'}",
        label="no source",
        help=f'name it: uniform string sourceName = "{example}"',
        severity=Severity.ERROR if needs else None,
    )


@rule(
    "unknown-source-type",
    on=Var,
    severity=Severity.ERROR,
    since="0.1",
    by_itself=True,
    about=("sourceType",),
)
def unknown_source_type(var: Var, context: Context) -> Iterator[Finding]:
    """`sourceType` is none of the schema's."""
    kind = var.source_type
    if kind.spoiled or kind.value in SOURCE_TYPES:
        return
    known = (*SOURCE_TYPES, *sorted(context.renderer.source_types))
    if kind.value in known:
        return
    meant = nearest(kind.value, known, 0.7)
    yield Finding(
        kind,
        f"sourceType '{kind.value}' is not {one_of(known)}",
        label="no such source type",
        help=f"did you mean '{meant}'?" if meant else "'raw' names a channel of the renderer",
    )


@rule(
    "intrinsic-source-type",
    on=RenderScope,
    severity=Severity.WARNING,
    since="0.1",
    about=("sourceType",),
)
def intrinsic_source_type(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """`sourceType` is one that the schema names and nobody implements."""
    found = (
        Finding(
            var.source_type,
            f"sourceType 'intrinsic' is in the schema, but is not implemented: {_what(var)} gets no data",
            label="not implemented",
            help="use 'raw', and the name that your renderer knows the quantity by",
        )
        for var in used(scope, context)
        if var.source_type.value == "intrinsic" and "intrinsic" not in context.renderer.source_types
    )
    yield from handful(found, "vars")


def _what(var: Var) -> str:
    return f"'{var.source_name.value}'" if var.source_name.value else f"<{var.path}>"

"""Does each light path expression say what was meant, to the renderers that read it?"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ..lpe import (
    ALL,
    DIALECTS,
    Dialect,
    Expression,
    Extension,
    Problem,
    Suspicion,
    extensions,
    has_variable,
    looks_like_lpe,
    mended,
    read,
    strip_prefix,
    suspicions_in,
)
from ..lpe.dialects import titles
from ..model import Var
from ..rule import Context, Finding, Renderer, Severity, rule
from ._names import quoted
from ._words import joined

GROUP = "var"

_LONG = 60
"""An expression is cut there in a message; columns count in the whole of it."""


def _expression(var: Var) -> str | None:
    """What the var names as its source, if that is an expression and can be judged."""
    text = var.source_name.value
    if var.source_type.value != "lpe" or has_variable(text):
        return None
    return strip_prefix(text) or None


def _dialects(renderer: Renderer) -> tuple[Dialect, ...]:
    known = DIALECTS.get(renderer.lpe_dialect or "")
    return (known,) if known else ALL


def _quoted(var: Var) -> str:
    text = var.source_name.value
    return quoted(text if len(text) <= _LONG else f"{text[:_LONG]}...")


def _column(var: Var, found: Problem | Suspicion | Extension) -> int:
    """In the sourceName as it is written."""
    text = var.source_name.value
    return found.column + len(text) - len(strip_prefix(text))


@rule("invalid-lpe", on=Var, severity=Severity.ERROR, since="0.1", about=("sourceType",))
def invalid_lpe(var: Var, context: Context) -> Iterator[Finding]:
    """A light path expression cannot be read."""
    if not (text := _expression(var)):
        return
    dialects = _dialects(context.renderer)
    problem = read(text, dialects)
    if isinstance(problem, Problem):
        column = _column(var, problem)
        who = dialects[0].title if len(dialects) == 1 else "no known renderer"
        reads = "does not read" if len(dialects) == 1 else "reads"
        yield Finding(
            var.source_name,
            f"{who} {reads} {_quoted(var)}: {problem.message} (column {column})",
            label=f"wrong at column {column}",
            help="mend the expression: without it the AOV is black, or the render stops",
        )


@rule(
    "suspicious-lpe",
    on=Var,
    severity=Severity.WARNING,
    since="0.1",
    supersedes=("nonportable-lpe",),
    about=("sourceType",),
)
def suspicious_lpe(var: Var, context: Context) -> Iterator[Finding]:
    """A light path expression matches nothing, or something else than was meant."""
    if not (text := _expression(var)):
        return
    dialects = _dialects(context.renderer)
    expression = read(text, dialects)
    if isinstance(expression, Problem) or not (odd := suspicions_in(text, dialects)):
        return
    yield Finding(
        var.source_name,
        f"{_quoted(var)} is not what it seems: {_listed(var, odd)}",
        label=f"suspect at column {_column(var, odd[0])}",
        help=_meant(expression),
    )


def _listed(var: Var, odd: Sequence[Suspicion]) -> str:
    said = [f"{s.message} (column {_column(var, s)})" for s in odd[:2]]
    more = [f"{len(odd) - 2} more"] if len(odd) > 2 else []
    return "; ".join([*said, *more])


def _meant(expression: Expression) -> str:
    meant = mended(expression)
    return (
        f"did you mean {meant}?"
        if meant
        else "write the path as it runs from the camera to the light"
    )


@rule("nonportable-lpe", on=Var, severity=Severity.NOTE, since="0.1", about=("sourceType",))
def nonportable_lpe(var: Var, context: Context) -> Iterator[Finding]:
    """A light path expression needs what only some renderers have."""
    # Where the renderer is known, its own language is no fault.
    if context.renderer.lpe_dialect or not (text := _expression(var)):
        return
    if isinstance(read(text), Problem) or not (own := extensions(text)):
        return
    said = [f"{e.what} at column {_column(var, e)} is {titles(e.dialects)}'s" for e in own[:2]]
    more = [f"{len(own) - 2} more"] if len(own) > 2 else []
    yield Finding(
        var.source_name,
        f"{_quoted(var)} is not for every renderer: {joined([*said, *more])}",
        label="one renderer's language",
        help="keep to Open Shading Language if other renderers are to read this",
    )


@rule(
    "lpe-without-source-type", on=Var, severity=Severity.WARNING, since="0.1", about=("sourceName",)
)
def lpe_without_source_type(var: Var, context: Context) -> Iterator[Finding]:
    """A source name is a light path expression, and the source type does not say so."""
    kind, name = var.source_type, var.source_name.value
    if kind.value != "raw" or not looks_like_lpe(name):
        return
    if any(name.startswith(prefix) for prefix in context.renderer.source_prefixes):
        return
    said = "is 'raw'" if kind.authored else "is not set, so 'raw'"
    yield Finding(
        var.source_name,
        f"{quoted(name)} is a light path expression, but sourceType {said}: renderers look for an AOV of that name",
        label="an expression",
        help=f'write uniform token sourceType = "lpe"{_without_prefix(name)}',
    )


def _without_prefix(name: str) -> str:
    plain = strip_prefix(name)
    return f' and sourceName = "{plain}"' if plain != name else ""

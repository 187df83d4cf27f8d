"""Does the stage open, and does it say which frames it has?"""

from __future__ import annotations

from collections.abc import Iterator

from ..lazily import lazily
from ..model import ArcError, Layer, RenderScope, Site, State, Target
from ..rule import Context, Finding, Severity, Sign, rule
from ._words import joined

GROUP = "stage"
_FRAME_TOKEN = lazily(r"\$F\d*|<F\d*>|#+|%0?\d*d|\{frame\}|@Frame")
_CYCLES = ("cycle", "sublayer-cycle")
_ARCS = {
    "references": "references",
    "payload": "payloads",
    "inheritPaths": "inherits",
    "specializes": "specializes",
}
_NETWORK = ("http://", "https://", "omniverse://", "s3://")


@rule("syntax-error", on=Layer, severity=Severity.ERROR, since="0.1")
def syntax_error(layer: Layer, context: Context) -> Iterator[Finding]:
    """A layer does not parse."""
    if layer.problem is not None:
        yield Finding(
            layer,
            layer.problem,
            related=((layer.asked, "brings the layer in"),) if layer.asked else (),
            help="mend it: at worst the whole stage does not open, at best it reads as empty"
            if layer.site.target
            else "nothing in this layer takes part in the render until it parses",
        )


@rule(
    "composition-error",
    on=RenderScope,
    severity=Severity.ERROR,
    since="0.1",
    about=(Sign.ARC_ERROR,),
)
def composition_error(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A sublayer, reference or payload of the render spec cannot be composed."""
    hidden = _hidden(scope)
    for error in scope.errors:
        behind = hidden.get(error.asset or f"<{error.prim}>", [])
        times = f" ({error.count} times)" if error.count > 1 else ""
        yield Finding(
            error.site,
            f"{_what_failed(error)}{times}",
            label="leads back" if error.kind in _CYCLES else "not composed",
            help=_what_to_do(error),
            severity=_how_bad(error, scope),
            related=(
                *_further(error),
                *((t, f"leads to <{t.path}>, which may be in it") for t in behind[:3]),
            ),
        )


def _further(error: ArcError) -> Iterator[tuple[Site, str]]:
    said = "is on the way" if error.kind in _CYCLES else "asks for it, too"
    yield from ((site, said) for site in error.further[:3])
    yield from ((site, "is what the variable says") for site in error.variables[:2])


def _how_bad(error: ArcError, scope: RenderScope) -> Severity | None:
    if error.kind in ("foreign-format", "foreign-resolver"):
        return Severity.NOTE  # a plug-in of the studio or the host application may bring it
    # Without a render spec nothing is lost for certain.
    prims = any(p.state is not State.ABSTRACT for p in scope.prims())
    has_spec = prims or scope.scopes or scope.default.opinion
    # What defines schemas asks for those of USD, which only its own tools look for.
    if not has_spec and error.kind == "missing-asset" and error.asset.endswith("/schema.usda"):
        return Severity.NOTE
    return None if error.touches_spec and has_spec else Severity.WARNING


def _what_failed(error: ArcError) -> str:
    into = f" on <{error.prims[0]}>" if error.prims and error.prims[0] != "/" else ""
    match error.kind:
        case "foreign-format":
            return f"the {error.arc} @{error.asset}@{into} needs a plug-in of USD: it was not looked at"
        case "foreign-resolver" if error.asset.startswith(_NETWORK):
            return f"the {error.arc} @{error.asset}@{into} is on the network: it was not looked at"
        case "missing-asset" if error.said:
            return f"the {error.arc} @{error.asset}@{into} comes to '{error.said}', which leads to no file"
        case "foreign-resolver":
            return f"the {error.arc} @{error.asset}@{into} needs a resolver that is not here: it was not looked at"
        case "missing-asset":
            return f"the {error.arc} @{error.asset}@{into} leads to no file"
        case "folder":
            return f"the {error.arc} @{error.asset}@{into} leads to a folder"
        case "relocation":
            why = error.said[:1].lower() + error.said[1:]
            return f"the relocation of <{error.prim}> is ignored: {why}"
        case "bad-expression":
            problem = error.said[:1].lower() + error.said[1:]
            is_asset = error.arc != "variant selection"
            written = f"@{error.asset}@" if is_asset else f"'{error.asset}'"
            return (
                f"the {error.arc} {written}{into} is no expression that USD can evaluate: {problem}"
            )
        case "missing-prim" if error.asset:
            return f"@{error.asset}@ has no prim <{error.prim}> for the {error.arc}{into}"
        case "missing-prim":
            return f"the {error.arc}{into} leads to <{error.prim}>, which does not exist"
        case "no-default-prim":
            return (
                f"the {error.arc} @{error.asset}@{into} names no prim, and the layer no defaultPrim"
            )
        case "cycle":
            fields = {site.field for site in (*error.further, error.site)}
            arcs = [arc for field, arc in _ARCS.items() if field in fields] or [*_ARCS.values()]
            return f"the {joined(arcs)}{into} lead back to themselves"
        case "sublayer-cycle":
            return "the sublayers lead back to themselves"
        case _:
            words = "".join(f" {c.lower()}" if c.isupper() else c for c in error.kind)
            return f"composition failed{into}:{words.removeprefix(' error')}"


def _what_to_do(error: ArcError) -> str:
    match error.kind:
        case "foreign-format" | "foreign-resolver":
            return "what it holds is unknown here, not missing"
        case "missing-asset" | "bad-expression" if error.unset:
            return f"write {joined(error.unset)} in the expressionVariables of the root layer"
        case "missing-asset":
            return "correct the path, or bring the file; what it holds is missing from the render"
        case "folder":
            return "name the file in it that is meant; what it holds is missing from the render"
        case "relocation":
            return "correct the entry, or take it away: the prim stays where it is"
        case "missing-prim":
            return "correct the prim's path, or leave it out to take the layer's defaultPrim"
        case "no-default-prim":
            return f"write the prim after the asset, or a defaultPrim in @{error.asset}@"
        case "bad-expression":
            return (
                "correct the expression: its strings stand in double quotes, its variables in ${ }"
            )
        case "cycle" | "sublayer-cycle":
            return "take one of them away" if error.further else "take it away"
        case _:
            return ""


def _hidden(scope: RenderScope) -> dict[str, list[Target]]:
    """Targets that may stand behind an asset or a missing prim: unknown, not missing."""
    found: dict[str, dict[str, Target]] = {}
    for prim in scope.prims():
        for rel in prim.rels:
            for target in rel.targets:
                if target.unknown and target.because is not None:
                    found.setdefault(target.because, {}).setdefault(target.path, target)
    return {hiding: list(targets.values()) for hiding, targets in found.items()}


@rule(
    "missing-frame-range",
    on=RenderScope,
    severity=Severity.NOTE,
    since="0.1",
    default=False,
    about=("productName",),
)
def missing_frame_range(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """Products are meant for a sequence, and the stage says no frames."""
    if scope.frames.start is not None and scope.frames.end is not None:
        return
    for product in scope.products:
        name = product.first_name
        if not product.live or not (
            len(product.product_name.samples) > 1 or _FRAME_TOKEN.search(name)
        ):
            continue
        yield Finding(
            scope.frames,
            f"<{product.path}> is named for a sequence ('{name}'), and the stage has no startTimeCode and endTimeCode: usdrecord renders one frame",
            label="no frame range",
            help="write startTimeCode and endTimeCode in the metadata of the root layer",
            related=((product.product_name, "is named for a sequence"),),
        )
        return

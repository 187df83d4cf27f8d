"""Does the stage open, and does it say which RenderSettings is the default?"""

from __future__ import annotations

from collections.abc import Iterator

from ..lazily import lazily
from ..model import ArcError, Layer, MetadataOpinion, RenderScope, Settings, Site, State, Target
from ..rule import Context, Finding, Severity, Sign, rule
from ._chains import why_not_live
from ._words import a_or_an, did_you_mean, joined, paths

GROUP = "stage"
KEY = "renderSettingsPrimPath"
_FRAME_TOKEN = lazily(r"\$F\d*|<F\d*>|#+|%0?\d*d|\{frame\}|@Frame")
_CYCLES = ("cycle", "sublayer-cycle")
_ARCS = {
    "references": "references",
    "payload": "payloads",
    "inheritPaths": "inherits",
    "specializes": "specializes",
}
_NETWORK = ("http://", "https://", "omniverse://", "s3://")


def _live(scope: RenderScope) -> list[Settings]:
    return [s for s in scope.settings if s.live]


def _author(settings: list[Settings]) -> str:
    if len(settings) == 1:
        return f'write {KEY} = "{settings[0].path}" in the metadata of the root layer'
    return (
        f"write {KEY} in the metadata of the root layer: one of {paths(s.path for s in settings)}"
    )


@rule("default-settings-unset", on=RenderScope, severity=Severity.WARNING, since="0.1")
def default_settings_unset(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """The stage has RenderSettings and does not say which is the default."""
    settings = _live(scope)
    opinion = scope.default.opinion
    if not settings or (opinion is not None and opinion.value):
        return
    if len(settings) == 1:
        said = f"no {KEY}: usdrecord and Hydra hosts will render without <{settings[0].path}>"
    else:
        said = f"no {KEY}: each renderer chooses among {paths(s.path for s in settings)} by itself"
    yield Finding(scope.default, said, help=_author(settings))


@rule(
    "default-settings-unresolved",
    on=RenderScope,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=("no-render-settings",),
    about=(Sign.ODD_DEFAULT,),
)
def default_settings_unresolved(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """The default settings path leads to no prim."""
    target = scope.default.target
    if target is None or target.state is not State.MISSING:
        return
    if scope.only_overrides:
        yield from _defined_elsewhere(scope, target, "do not exist here")
        return
    only = f": they are only in {target.only_in}, which is not selected" if target.only_in else ""
    yield Finding(
        target,
        f"the default render settings <{target.path}> do not exist{only}",
        label="in another variant" if only else "no prim here",
        help="select that variant, or name settings that all variants have"
        if only
        else did_you_mean(target, "RenderSettings", "RenderSettings"),
        related=_first_candidate(target),
    )


def _defined_elsewhere(scope: RenderScope, target: Target, state: str) -> Iterator[Finding]:
    """An override layer leaves its settings to a weaker one. Where it brings a scene, it may also be
    the shot itself."""
    if not scope.is_part:
        yield Finding(
            target,
            f"the default render settings <{target.path}> {state}, where the render scope is only overridden",
            label="not defined here",
            help="right in a layer that stands above the one that defines them",
            related=(why_not_live(target),) if target.state is State.OVER else (),
            severity=Severity.NOTE,
        )


def _first_candidate(target: Target) -> tuple[tuple[Site, str], ...]:
    return tuple((c.site, f"is {a_or_an(c.type_name)}") for c in target.candidates[:1])


@rule(
    "default-settings-bad-path",
    on=RenderScope,
    severity=Severity.ERROR,
    since="0.1",
    about=(Sign.ODD_DEFAULT,),
)
def default_settings_bad_path(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """The default settings path is not an absolute prim path."""
    default = scope.default
    if default.problem is None or default.opinion is None:
        return
    value = default.opinion.value
    tidied = "/" + value.strip().strip("<>").strip().strip("/")
    settings = _live(scope)
    if any(s.path == tidied for s in settings):
        todo = f'write {KEY} = "{tidied}"'
    elif settings:
        todo = _author(settings)
    else:
        todo = f"{KEY} takes the absolute path of a RenderSettings prim, as a string"
    yield Finding(
        default.opinion,
        f"'{value}' is not the absolute path of a prim: {default.problem}",
        label="USD finds no settings by this",
        help=todo,
    )


@rule(
    "default-settings-wrong-type",
    on=RenderScope,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=("no-render-settings",),
    about=(Sign.ODD_DEFAULT,),
)
def default_settings_wrong_type(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """The default settings path leads to a prim that is not a RenderSettings."""
    target = scope.default.target
    if target is None or target.state in (State.MISSING, State.UNKNOWN) or scope.only_overrides:
        return
    if "RenderSettings" in target.isa or (target.state is State.OVER and not target.type_name):
        return
    if not target.type_known:
        yield Finding(
            target,
            f"the default render settings <{target.path}> are of the unknown type '{target.type_name}'",
            label="a plug-in's type, or a typo",
            help="what a plug-in makes of it is unknown here, and was not looked at",
            severity=Severity.NOTE,
        )
        return
    kind = a_or_an(target.type_name) if target.type_name else "a prim without a type"
    yield Finding(
        target,
        f"the default render settings <{target.path}> are {kind}, not a RenderSettings",
        label=f"{kind}",
        help=did_you_mean(target, "RenderSettings", "RenderSettings"),
    )


@rule(
    "default-settings-not-live",
    on=RenderScope,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=("dangling-over", "dead-target"),
    about=(Sign.ODD_DEFAULT,),
)
def default_settings_not_live(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """The default settings are inactive, only an `over`, or abstract."""
    target = scope.default.target
    if target is None:
        return
    if scope.only_overrides:
        if target.state is State.OVER:
            yield from _defined_elsewhere(scope, target, "are only an 'over'")
        return
    why = {
        State.INACTIVE: "are inactive",
        State.OVER: "are only an 'over': no layer defines them",
        State.ABSTRACT: "are a class, or stand below one",
    }.get(target.state)
    if why is None or (target.type_name and "RenderSettings" not in target.isa):
        return
    if target.because:
        why = f"are inactive, as <{target.because}> is"
    yield Finding(
        target,
        f"the default render settings <{target.path}> {why}: no renderer meets them",
        label="not live",
        help="name settings that are live, or bring these to life",
        related=(why_not_live(target),),
        explains=(Site(target.path),),
    )


@rule(
    "default-settings-in-sublayer",
    on=RenderScope,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=("default-settings-unset",),
    about=(Sign.ODD_DEFAULT,),
)
def default_settings_in_sublayer(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A sublayer sets the default settings, where USD does not look."""
    used = scope.default.opinion
    if used is None or not used.value:
        told = [o for o in scope.default.sublayers if o.value]
        yield from _only_in_sublayers(told, scope)
        return
    for opinion in scope.default.sublayers:
        if used.value != opinion.value:
            yield Finding(
                opinion,
                f"{KEY} has no effect in a sublayer: the root layer says '{used.value}'",
                label="not read",
                help="remove it, or change the root layer's",
                severity=Severity.NOTE,
                related=((used, "is the value that counts"),),
            )


def _only_in_sublayers(opinions: list[MetadataOpinion], scope: RenderScope) -> Iterator[Finding]:
    """What the root layer lacks it lacks once, in however many sublayers it stands."""
    settings = _live(scope)
    for opinion in opinions[:1]:
        leads = any(s.path == opinion.value for s in settings)
        nowhere = "" if leads else f", and no RenderSettings stand at '{opinion.value}'"
        if leads:
            todo = f'write {KEY} = "{opinion.value}" in the metadata of the root layer'
        else:
            todo = _author(settings) if settings else "remove it"
        yield Finding(
            opinion,
            f"{KEY} has no effect in a sublayer: the stage has no default render settings{nowhere}",
            label="not read",
            help=todo,
            related=tuple((o, f"says '{o.value}', and is not read either") for o in opinions[1:]),
            severity=None if leads else Severity.WARNING if settings else Severity.NOTE,
        )


@rule(
    "default-settings-misspelled",
    on=RenderScope,
    severity=Severity.WARNING,
    since="0.1",
    supersedes=("default-settings-unset",),
    about=(Sign.ODD_DEFAULT,),
)
def default_settings_misspelled(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A metadata key looks like `renderSettingsPrimPath` and is not."""
    if scope.default.opinion is not None and scope.default.opinion.value:
        return
    for opinion in scope.default.misspelled:
        if opinion.in_custom_data:
            said = f"'{opinion.key}' in customLayerData is not read: it is metadata of the layer itself"
        else:
            said = f"'{opinion.key}' is no metadata that USD reads"
        yield Finding(
            opinion,
            said,
            label=f"not {KEY}",
            help=f'write {KEY} = "{opinion.value or "/path/of/the/settings"}" in the metadata of the root layer',
        )


@rule("no-render-settings", on=RenderScope, severity=Severity.WARNING, since="0.1")
def no_render_settings(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """There are products or vars and no RenderSettings that could use them."""
    # A pass says itself that its render source is missing.
    if scope.settings:
        return
    prims = [p for p in (*scope.products, *scope.vars) if p.live]
    if not prims or _may_be_settings(scope):
        return
    if scope.passes and all(p.file_name.value for p in scope.passes):
        return  # the files of other applications say how to render
    first = min(prims, key=lambda p: p.path)
    kinds = sorted({p.type_name for p in prims})
    above = next((s for s in scope.scopes if first.path.startswith(s.path + "/")), None)
    if scope.is_part and above is None:
        return  # under a name of its own it is there for shots to reference
    parent = first.path.rpartition("/")[0]
    yield Finding(
        above or Site(parent or first.path),
        f"{' and '.join(kinds)} prims, but no RenderSettings: no renderer reaches them",
        label="no RenderSettings here",
        help="right in a layer that a shot with RenderSettings brings in"
        if scope.is_part
        else "add a RenderSettings that lists the products, and name it as the default",
        severity=Severity.NOTE if scope.is_part else None,
    )


def _may_be_settings(scope: RenderScope) -> bool:
    """Something is meant as settings, or could be if its reference opened."""
    default = scope.default.target
    return (
        any(
            o.behind_failed_arc
            or "settings" in o.type_name.lower()
            or any(p.name == "products" for p in o.properties)
            for o in scope.others
        )
        or any(e.arc == "sublayer" for e in scope.errors)
        or (default is not None and default.unknown)
    )


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

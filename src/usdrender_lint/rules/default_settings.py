"""Does a renderer find the RenderSettings to begin with?"""

from __future__ import annotations

from collections.abc import Iterator

from ..model import MetadataOpinion, RenderScope, Settings, Site, State, Target
from ..rule import Context, Finding, Severity, Sign, rule
from ._chains import why_not_live
from ._words import a_or_an, did_you_mean, meant_instead, paths, probably_meant

GROUP = "stage"
KEY = "renderSettingsPrimPath"


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
    if target is not None and target.state is State.UNKNOWN and (meant := probably_meant(target)):
        yield Finding(
            target,
            f"the default render settings <{target.path}> are nowhere in what could be opened, and <{meant.path}> is there",
            label="perhaps misspelt",
            help=meant_instead(target, meant),
            related=_first_candidate(target),
            severity=Severity.NOTE,
        )
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
    said_right = scope.default.opinion.value if scope.default.opinion is not None else ""
    for opinion in scope.default.misspelled:
        if said_right and said_right == opinion.value:
            continue  # a copy, for whatever reads it
        if opinion.in_custom_data:
            said = f"'{opinion.key}' in customLayerData is not read: it is metadata of the layer itself"
        else:
            said = f"'{opinion.key}' is no metadata that USD reads"
        yield Finding(
            opinion,
            said,
            label=f"not {KEY}",
            help=f"{KEY} says <{said_right}>: remove this one"
            if said_right
            else f'write {KEY} = "{opinion.value or "/path/of/the/settings"}" in the metadata of the root layer',
            severity=Severity.NOTE if said_right else None,
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

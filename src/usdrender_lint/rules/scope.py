"""Do the render prims stand where renderers look for them?"""

from __future__ import annotations

from collections.abc import Iterator

from ..likeness import likeness
from ..model import RenderScope, ScopePrim, Site, State, Stray
from ..rule import Context, Finding, Severity, Sign, rule
from ._words import a_or_an, nearest, paths

GROUP = "scope"


def _misnames(root: str, scope: str) -> bool:
    """`/render`, `/Renders`, `/Rendering` for `/Render`: another case, number or form of the name."""
    name, wanted = root.strip("/"), scope.strip("/")
    if "/" in name or name == wanted:
        return False
    lower, want = name.lower(), wanted.lower()
    return lower == want or (lower.startswith(want[:5]) and likeness(name, wanted) >= 0.8)


def _misnamed_root(scope: RenderScope, stray: Stray) -> str | None:
    """The prim above a stray that was probably meant as the render scope."""
    root = stray.root_site.path
    if root == stray.path:
        return None
    if any(_misnames(root, home) for home in scope.homes):
        return root
    second = "/".join(stray.path.split("/")[:3])
    if second != stray.path and f"/{second.rpartition('/')[2]}" in scope.homes:
        return second
    return None


def _homes(scope: RenderScope) -> str:
    """`/Render`, or where the show has its render prims."""
    *others, last = scope.homes
    return f"{', '.join(others)} or {last}" if others else last


def _where(scope: RenderScope) -> str:
    above = scope.homes[0].rpartition("/")[0]
    return f"below <{above}>" if above else "at the root"


def _top(scope: RenderScope) -> str:
    first = scope.homes[0].strip("/")
    return f"<{scope.homes[0]}>" if "/" in first else f"a root prim named '{first}'"


@rule(
    "outside-render-scope",
    on=RenderScope,
    severity=Severity.WARNING,
    since="0.1",
    supersedes=(
        "no-render-settings",
        "orphan-product",
        "orphan-var",
        "shared-product",
        "unused-settings",
    ),
    about=(Sign.STRAY,),
)
def outside_render_scope(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A render prim does not stand below `/Render`."""
    if scope.is_library:
        return  # it stands where its library has it, until a reference brings it in
    groups: dict[str, list[Stray]] = {}
    for stray in scope.strays:
        if stray.state is not State.ABSTRACT:  # a class instantiates nothing
            groups.setdefault(stray.root_site.path, []).append(stray)
    for strays in groups.values():
        first, others = strays[0], strays[1:]
        nor = "nor does" if len(others) == 1 else "nor do"
        more = f", {nor} {paths(s.path for s in others)}" if others else ""
        yield Finding(
            first,
            f"the {first.type_name} <{first.path}> does not stand below {_homes(scope)}{more}",
            label=f"renderers look below {_homes(scope)}",
            help=f"move {'them' if others else 'it'} below {_top(scope)}",
            explains=(first.root_site, *strays),
        )


@rule(
    "misnamed-render-scope",
    on=RenderScope,
    severity=Severity.WARNING,
    since="0.1",
    supersedes=("outside-render-scope", "no-render-settings"),
    about=(Sign.STRAY,),
)
def misnamed_render_scope(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """The prim that groups the render prims is not called `/Render`."""
    roots: dict[str, Stray] = {}
    for stray in scope.strays:
        root = _misnamed_root(scope, stray)
        if root is not None and stray.state is not State.ABSTRACT:
            roots.setdefault(root, stray)
    for root, stray in roots.items():
        yield Finding(
            Site(root),
            f"<{root}> holds render prims, but renderers look below {_homes(scope)}",
            label=f"not {_homes(scope)}",
            help=f"name it '{scope.homes[0].rpartition('/')[2]}', let it stand {_where(scope)}, and mend the paths that lead to it",
            related=((stray, f"is {a_or_an(stray.type_name)}"),),
        )


@rule(
    "render-scope-not-live",
    on=RenderScope,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=(
        "dead-target",
        "default-settings-not-live",
        "default-settings-unresolved",
        "default-settings-wrong-type",
        "no-render-settings",
        "product-without-vars",
        "settings-without-products",
        "unresolved-target",
    ),
    about=(Sign.ODD_SCOPE,),
)
def render_scope_not_live(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """`/Render`, or a group in it, is inactive, only an `over`, or a `class`."""
    if scope.only_overrides:
        return
    dead: list[str] = []
    for prim in scope.scopes:
        if prim.state is State.LIVE or not prim.holds_render_prims or prim.because is not None:
            continue
        if any(prim.path.startswith(above + "/") for above in dead):
            continue
        dead.append(prim.path)
        yield Finding(
            prim.state_site,
            f"<{prim.path}> is {_why(prim)}: no renderer meets the render prims below it",
            label="not live",
            help=_mend(prim),
        )


def _why(prim: ScopePrim) -> str:
    return {
        State.INACTIVE: "inactive",
        State.OVER: "only an 'over', which no layer defines",
        State.ABSTRACT: "a 'class'",
    }.get(prim.state, str(prim.state))


def _mend(prim: ScopePrim) -> str:
    if prim.state is State.INACTIVE:
        return "remove 'active = false'"
    return f'write def Scope "{prim.path.rpartition("/")[2]}"'


@rule(
    "dangling-over",
    on=RenderScope,
    severity=Severity.WARNING,
    since="0.1",
    about=(Sign.ODD_SCOPE, Sign.OVER),
)
def dangling_over(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """An `over` in the render scope overrides nothing."""
    if scope.only_overrides:
        return
    states = {s.path: s.state for s in scope.scopes} | {p.path: p.state for p in scope.prims()}
    overs = sorted(
        [s.path for s in scope.scopes if s.state is State.OVER and s.because is None]
        + [p.path for p in scope.prims() if p.state is State.OVER]
    )
    for path in overs:
        parent = path.rpartition("/")[0]
        if states.get(parent) is not State.LIVE or any(s.path == path for s in scope.strays):
            continue  # the topmost tells for all below it
        siblings = [
            p.rpartition("/")[2]
            for p, state in states.items()
            if p.rpartition("/")[0] == parent and state is State.LIVE
        ]
        name = path.rpartition("/")[2]
        meant = nearest(name, siblings, 0.6)
        yield Finding(
            Site(path, "specifier"),
            f"<{path}> is only an 'over': no layer defines it, so nobody reads it",
            label="overrides nothing",
            help=f"did you mean '{meant}'?" if meant else "define it, or remove the over",
        )


@rule(
    "render-scope-type",
    on=RenderScope,
    severity=Severity.NOTE,
    since="0.1",
    about=(Sign.ODD_SCOPE,),
)
def render_scope_type(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """`/Render` is not a Scope."""
    for prim in scope.scopes:
        if prim.path not in scope.homes:
            continue
        if prim.state is not State.LIVE or prim.type_name == "Scope" or not prim.holds_render_prims:
            continue
        kind = a_or_an(prim.type_name) if prim.type_name else "untyped"
        moves = prim.type_name == "Xform"
        cost = ", which brings a transform where nothing is to be moved" if moves else ""
        yield Finding(
            Site(prim.path, "typeName"),
            f"<{prim.path}> is {kind}{cost}: the convention is a Scope",
            label="not a Scope",
            help=f'write def Scope "{prim.path.rpartition("/")[2]}"',
        )


@rule(
    "scene-content-in-render-scope",
    on=RenderScope,
    severity=Severity.NOTE,
    since="0.1",
    about=(Sign.OTHER_PRIM,),
)
def scene_content_in_render_scope(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """Geometry or lights stand among the render prims."""
    found = [o for o in scope.others if o.content and o.state is State.LIVE]
    if not found:
        return
    more = f", and {len(found) - 1} more" if len(found) > 1 else ""
    yield Finding(
        found[0],
        f"<{found[0].path}> is {found[0].content} in the render scope{more}: the scope is no longer cheap to open alone",
        label=found[0].content,
        help="move it to the scene",
    )


@rule(
    "instanceable-render-scope",
    on=RenderScope,
    severity=Severity.WARNING,
    since="0.1",
    default=False,
    supersedes=("default-settings-unresolved", "no-render-settings"),
)
def instanceable_render_scope(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A prim of the render scope is an instance, so what it holds can neither be edited nor found."""
    for site in scope.instances:
        yield Finding(
            Site(site.path, "instanceable"),
            f"<{site.path}> is an instance: stage traversal passes its render prims by, and nobody can override them",
            label="an instance",
            help="remove 'instanceable = true'",
        )


@rule(
    "render-scope-behind-payload",
    on=RenderScope,
    severity=Severity.NOTE,
    since="0.1",
    default=False,
)
def render_scope_behind_payload(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """Render prims come in by a payload, which tools that open without payloads do not see."""
    for site in scope.payloads:
        yield Finding(
            Site(site.path, "payload"),
            f"<{site.path}> comes in by a payload: opened without payloads, the stage has no such render prims",
            label="a payload",
            help="bring it in by a reference or a sublayer",
        )

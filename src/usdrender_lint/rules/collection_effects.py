"""Do the members of a pass's collections come to be seen, and does the pass keep what it needs?"""

from __future__ import annotations

from collections.abc import Iterator

from ..model import Collection, Gives, HasSite, Member, Pass, RenderScope, Settings, State, Target
from ..rule import Context, Finding, Severity, Sign, rule
from ._collections import UNSEEN, VISIBILITY, includes_all
from ._handful import handful

GROUP = "collection"


@rule("instanced-member", on=Pass, severity=Severity.WARNING, since="0.1", about=(Sign.COLLECTION,))
def instanced_member(render_pass: Pass, context: Context) -> Iterator[Finding]:
    """A pass is to show an instance, into which its visibility does not reach."""
    for found in render_pass.collections:
        if found.name in UNSEEN and not includes_all(found):
            instanced = [m for m in found.members if m.instance and m.live]
            yield from handful((_instanced(m, found) for m in instanced), "instances")


def _instanced(member: Member, found: Collection) -> Finding:
    what = (
        "an instance"
        if member.instance == member.path
        else f"which stands in the instance <{member.instance}>"
    )
    return Finding(
        member,
        f"'{found.name}' names <{member.path}>, {what}: Storm and RenderMan do not look into instances, so it {UNSEEN[found.name]}",
        label="instance",
        help=f"write instanceable = false on <{member.instance}> in a layer of this render",
    )


@rule(
    "prune-removes-camera",
    on=RenderScope,
    severity=Severity.ERROR,
    since="0.1",
    about=(Sign.COLLECTION,),
)
def prune_removes_camera(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A pass prunes the camera that it renders through, or its own settings."""
    settings = {s.path: s for s in scope.settings if s.live}
    for one in scope.passes:
        prune = one.collection("prune")
        source = next(iter(one.render_source.targets), None)
        if not one.live or one.file_name.value or prune is None or source is None:
            continue
        if prune.lost or prune.problem:  # what is left was not meant
            continue
        render = settings.get(source.path)
        if render is None and not source.live and len(settings) == 1:
            (render,) = settings.values()  # whatever the broken target meant, it is this one
        for what, path in _needed(render, scope) if render is not None else ():
            if top := prune.holding(path):
                along = "" if top == path else f" along with <{top}>"
                yield Finding(
                    _reason(prune, top),
                    f"'prune' of <{one.path}> removes the {what} <{path}>{along}: the pass cannot be rendered",
                    label=f"removes the {what}",
                    help=_keep(path, prune),
                )
                break


def _needed(settings: Settings, scope: RenderScope) -> Iterator[tuple[str, str]]:
    rels = [settings.camera, *(o.camera for o in settings.outputs if o.product.live)]
    named = [t for r in rels for t in r.targets[:1] if t.live and "Camera" in t.isa]
    # Where all that is named is broken, it is what was probably meant.
    for path in dict.fromkeys(one.path for one in named or scope.cameras):
        yield "camera", path
    yield "settings", settings.path


def _keep(path: str, prune: Collection) -> str:
    if path in (prune.held or ()):
        return f"leave <{path}> out of it"
    return "what is below a pruned prim goes with it, excluded or not: prune what is beside it"


def _reason(found: Collection, top: str) -> HasSite:
    """What makes the topmost member one."""
    if found.expression_counts:
        named = (p for p in found.patterns if p.adds and p.names_all and p.start.path == top)
        return next(named, found.expression)
    include: Target | None = next((t for t in found.includes.targets if t.path == top), None)
    if include is not None:
        return include
    return found.include_root if found.include_root.value else found.includes


@rule(
    "matte-not-visible", on=Pass, severity=Severity.WARNING, since="0.1", about=(Sign.COLLECTION,)
)
def matte_not_visible(render_pass: Pass, context: Context) -> Iterator[Finding]:
    """A matte, or what the camera is to see, is hidden by the pass."""
    visible = render_pass.collection("renderVisibility")
    if visible is None or visible.held is None or _is_broken(visible):
        return
    for name in ("matte", "cameraVisibility"):
        found = render_pass.collection(name)
        if found is None or includes_all(found):
            continue
        hidden = [
            m
            for m in found.members
            if m.live and m.path not in visible.held and m.path not in visible.reached
        ]
        yield from handful(
            (
                Finding(
                    m,
                    f"<{m.path}> is in '{name}', but not in 'renderVisibility' of <{render_pass.path}>: it has no effect",
                    label="not rendered",
                    help="add it to renderVisibility, too, or remove it here",
                    related=((_side(visible), "decides what is rendered"),),
                )
                for m in hidden
            ),
            "members",
        )


def _is_broken(found: Collection) -> bool:
    """Something that it names is not there, or it names nothing."""
    starts = [*found.members, *(p.start for p in found.patterns if p.adds)]
    return (
        bool(found.lost)
        or not (starts or found.others or includes_all(found))
        or any(m.state in (State.MISSING, State.UNKNOWN) for m in starts)
        or any(o.gives is not Gives.MEMBERS for o in found.others)
    )


def _side(found: Collection) -> HasSite:
    if found.expression_counts:
        return found.expression
    return found.includes if found.includes.targets else found.excludes


@rule("visible-but-pruned", on=Pass, severity=Severity.NOTE, since="0.1", about=(Sign.COLLECTION,))
def visible_but_pruned(render_pass: Pass, context: Context) -> Iterator[Finding]:
    """A pass includes a prim in what is seen, and prunes it."""
    prune = render_pass.collection("prune")
    if prune is None or prune.lost:
        return
    for found in (c for c in render_pass.collections if c.name in VISIBILITY):
        for member in (m for m in found.members if m.live):
            if top := prune.holding(member.path):
                along = "" if top == member.path else f" along with <{top}>"
                yield Finding(
                    member,
                    f"'{found.name}' of <{render_pass.path}> names <{member.path}>, which 'prune' removes{along}",
                    label="pruned",
                    help="remove it here, or from prune",
                    related=((_reason(prune, top), "removes it"),),
                )


@rule(
    "invisible-member",
    on=Pass,
    severity=Severity.NOTE,
    since="0.1",
    default=False,
    about=(Sign.COLLECTION,),
)
def invisible_member(render_pass: Pass, context: Context) -> Iterator[Finding]:
    """A pass includes a prim that is invisible by itself."""
    for found in (c for c in render_pass.collections if c.name in VISIBILITY):
        for member in found.members:
            if member.invisible and member.live:
                by = "" if member.invisible == member.path else f", as <{member.invisible}> is"
                yield Finding(
                    member,
                    f"'{found.name}' names <{member.path}>, which is invisible{by}: that it is included does not show it",
                    label="invisible",
                    help="make it visible in a layer of this render, or remove it here",
                )

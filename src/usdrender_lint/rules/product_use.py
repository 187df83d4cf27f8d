"""Is each product rendered, once, and can the products of one render be rendered together?"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import groupby

from ..model import Attr, Output, Product, Rel, RenderPrim, RenderScope, Settings, Site, ValueState
from ..rule import Context, Finding, Severity, rule
from ._handful import handful
from ._used import listed
from ._views import are_alike, overrides, views
from ._words import joined, paths

GROUP = "product"


@rule(
    "shared-product",
    on=RenderScope,
    severity=Severity.NOTE,
    since="0.1",
    supersedes=("unused-settings",),
    about=("products",),
)
def shared_product(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """Several RenderSettings render the same product."""
    first: dict[str, Settings] = {}
    if len(scope.settings) < 2:
        return
    rendered = _rendered_by_passes(scope)
    for settings in scope.settings:
        if not settings.live:
            continue
        shared = [t for t in settings.products.targets if t.path in first and t.live]
        others = dict.fromkeys(first[t.path].path for t in shared)
        # That passes overwrite each other's files is a fault of the passes.
        if shared and len(rendered.intersection([settings.path, *others])) < 2:
            yield Finding(
                settings,
                f"<{settings.path}> renders {paths(t.path for t in shared)} as {paths(others)} does: "
                "whichever is rendered last overwrites the file",
                label="shares a product",
                help="give each settings prim products of its own, unless only one of them is ever rendered",
                related=((shared[0], "is rendered by both"),),
                explains=(settings, *(Site(path) for path in others)),
            )
        for target in settings.products.targets:
            first.setdefault(target.path, settings)


def _rendered_by_passes(scope: RenderScope) -> set[str]:
    return {t.path for p in scope.passes if p.live for t in p.render_source.targets[:1]}


@rule("orphan-product", on=RenderScope, severity=Severity.NOTE, since="0.1", about=("products",))
def orphan_product(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """No RenderSettings list a product, so nothing renders it."""
    rels = [s.products for s in scope.settings]
    # Where nobody lists a product, that is one fault, and not one of the products.
    if not any(r.named for r in rels) or _unclear(rels, scope, "products"):
        return
    meant = listed(rels) | _perhaps_meant(rels)
    orphans = [p for p in scope.products if _is_unlisted(p, meant)]
    settings = [s.path for s in scope.settings if s.live]
    yield from handful((_orphan_product(p, settings) for p in orphans), "products")


def _orphan_product(product: Product, settings: list[str]) -> Finding:
    where = f"products of <{settings[0]}>" if len(settings) == 1 else "the products of a settings"
    return Finding(
        product,
        f"no RenderSettings lists <{product.path}>: it is never rendered",
        label="not listed",
        help=f"add it to {where}, or deactivate it",
    )


@rule("orphan-var", on=RenderScope, severity=Severity.NOTE, since="0.1", about=("orderedVars",))
def orphan_var(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """No product lists a var, so nothing writes it."""
    rels = [p.ordered_vars for p in scope.products]
    if not all(p.ordered_vars.named for p in scope.products if p.live):
        return  # what is not listed is perhaps what a product without a list should list
    if not any(r.named for r in rels) or _unclear(rels, scope, "orderedVars"):
        return
    meant = listed(rels) | _perhaps_meant(rels)
    orphans = [v.path for v in scope.vars if _is_unlisted(v, meant)]
    for _, found in groupby(orphans, lambda path: path.rpartition("/")[0]):
        group = list(found)
        it, are = ("it", "it is") if len(group) == 1 else ("them", "they are")
        yield Finding(
            Site(group[0]),
            f"no product lists {paths(group)}: {are} never written",
            label="not listed",
            help=f"add {it} to a product's orderedVars, or leave {it} for those who need {it}",
            related=tuple((Site(path), "is not listed either") for path in group[1:4]),
        )


def _is_unlisted(prim: RenderPrim, meant: set[str]) -> bool:
    """Of instances it is enough that one is listed: the others come with the prototype."""
    return prim.live and not prim.prototype and prim.path not in meant


def _unclear(rels: Iterable[Rel], scope: RenderScope, name: str) -> bool:
    """Some list was lost, and what it held is not to be called an orphan."""
    lost = any(r.written_as_attribute or r.lost or r.maybe_more for r in rels)
    return lost or any(p.name == name for other in scope.others for p in other.properties)


def _perhaps_meant(rels: Iterable[Rel]) -> set[str]:
    """By broken targets, however unlike: what one of them may have meant is no orphan for certain."""
    broken = (t for rel in rels for t in rel.targets if not t.live)
    return {c.path for target in broken for c in target.candidates[:1]}


@rule("per-product-view", on=RenderScope, severity=Severity.NOTE, since="0.1", about=("products",))
def per_product_view(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """Products of one render differ in camera, resolution, data window or pixel aspect."""
    told: set[Site] = set()
    for settings in scope.settings:
        finding = _differing_views(settings) if settings.live else None
        if finding and finding.at.site not in told:  # a product that two settings share, once
            told.add(finding.at.site)
            yield finding


def _differing_views(settings: Settings) -> Finding | None:
    outputs = [o for o in settings.outputs if o.product.live]
    if are_alike(outputs):
        return None
    differing = [what for what, seen in views(outputs).items() if len(seen) > 1]
    own = (at for o in outputs for what, at in overrides(settings, o) if what in differing)
    at = next(own, None)
    if at is None:
        return None
    return Finding(
        at,
        f"the products of <{settings.path}> differ in {joined(differing)}: "
        "some renderers start over for each, some render all alike",
        label="differs",
        help="if your renderer takes one view a render, give each view settings of its own",
    )


@rule(
    "mixed-blur-settings",
    on=RenderScope,
    severity=Severity.NOTE,
    since="0.1",
    about=("disableMotionBlur", "disableDepthOfField"),
)
def mixed_blur_settings(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """Products of one render disagree on motion blur or depth of field."""
    told: set[Site] = set()
    for settings in scope.settings:
        for finding in _mixed(settings) if settings.live else ():
            if finding.at.site not in told:
                told.add(finding.at.site)
                yield finding


def _mixed(settings: Settings) -> Iterator[Finding]:
    outputs = [o for o in settings.outputs if o.product.live]
    for what in ("motion blur", "depth of field"):
        without = [o.product.path for o in outputs if _switch(o, what).value]
        own = [a for o in outputs if (a := _switch(o.product, what)).state is ValueState.AUTHORED]
        if not without or len(without) == len(outputs) or not own:
            continue
        is_ = "is" if len(without) == 1 else "are"
        yield Finding(
            own[0],
            f"{paths(without)} {is_} without {what}, other products of <{settings.path}> are not: "
            "where they share a render, one kind loses",
            label="differs",
            help="if your renderer takes all products in one go, give each kind settings of its own",
        )


def _switch(one: Output | Product, what: str) -> Attr[bool]:
    return one.disable_motion_blur if what == "motion blur" else one.disable_depth_of_field

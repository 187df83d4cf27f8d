"""What do the settings render, and what do products say over them?"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..model import (
    Attr,
    HasSite,
    Product,
    RenderScope,
    Settings,
    Site,
    ValueState,
)
from ..rule import Context, Finding, Severity, Sign, rule
from ._chains import dead_ends
from ._rendered import named_settings, outputs_of
from ._words import paths, spelt

GROUP = "settings"

_OVERRIDES = (
    "resolution",
    "pixel_aspect_ratio",
    "aspect_ratio_conform_policy",
    "data_window_ndc",
    "disable_motion_blur",
    "disable_depth_of_field",
)
"""Attributes that a product may take from its settings, as the model calls them."""


@rule(
    "sampled-override",
    on=RenderScope,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=("animated-uniform",),
    about=(Sign.VARYING,),
)
def sampled_override(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A product's sampled value puts the schema's fallback over the settings' value."""
    for settings, output in outputs_of(scope):
        for name in _OVERRIDES:
            own: Attr[Any] = getattr(output.product, name)
            shared: Attr[Any] = getattr(settings, name)
            if own.state is not ValueState.SAMPLED or own.value == shared.value:
                continue
            samples = "a spline" if own.varying == "spline" else "time samples"
            yield Finding(
                own,
                f"{own.name} of <{output.product.path}> has {samples} and no default: the schema's"
                f" {spelt(own.value)} takes the place of the settings' {spelt(shared.value)}",
                label="no default value",
                help="write one value without times, or remove it to inherit the settings'",
                related=((shared, "is not inherited"),) if shared.authored else (),
            )


@rule(
    "redundant-override",
    on=RenderScope,
    severity=Severity.NOTE,
    since="0.1",
    default=False,
    about=("products",),
)
def redundant_override(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A product repeats a value of its settings, and will not follow when that changes."""
    for product in scope.products:
        users = [s for s, output in outputs_of(scope) if output.product.path == product.path]
        if not users:
            continue
        for name in _OVERRIDES:
            own: Attr[Any] = getattr(product, name)
            shared: list[Attr[Any]] = [getattr(s, name) for s in users]
            repeats = all(a.value == own.value and a.varying is None for a in shared)
            if own.state is ValueState.AUTHORED and own.varying is None and repeats:
                yield _repeated(own, own.name, spelt(own.value), product, users)
        cameras = [t.path for t in product.camera.targets[:1]]
        if cameras and all([t.path for t in s.camera.targets[:1]] == cameras for s in users):
            target = product.camera.targets[0]
            yield _repeated(target, "camera", f"<{target.path}>", product, users)


def _repeated(
    at: HasSite, name: str, value: str, product: Product, users: list[Settings]
) -> Finding:
    return Finding(
        at,
        f"{name} of <{product.path}> is {value} as in {paths(s.path for s in users)}:"
        " it will not follow when that changes",
        label="the same as the settings'",
        help="remove it to inherit",
    )


@rule(
    "settings-without-products",
    on=RenderScope,
    severity=Severity.NOTE,
    since="0.1",
)
def settings_without_products(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """RenderSettings list no products: a renderer makes its default image, or none."""
    for settings in scope.settings:
        if not settings.live or settings.products.named:
            continue
        users = [
            p.path
            for p in scope.passes
            if p.live and any(t.path == settings.path for t in p.render_source.targets)
        ]
        needed = f", though {paths(users)} renders with it" if users else ""
        yield Finding(
            Site(f"{settings.path}.products"),
            f"<{settings.path}> lists no products{needed}: a renderer makes its default image, or none",
            label="no products",
            help="list the files to write: rel products = </Render/Products/beauty>",
            severity=Severity.WARNING if users else None,
            related=dead_ends(settings.products),
        )


@rule("unused-settings", on=RenderScope, severity=Severity.NOTE, since="0.1")
def unused_settings(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """RenderSettings are neither the default nor the source of a pass."""
    named = named_settings(scope)
    strays = {s.path for s in scope.strays}
    for settings in scope.settings:
        if not named or not settings.live or settings.path in named or settings.path in strays:
            continue
        yield Finding(
            settings,
            f"<{settings.path}> is neither the default nor the renderSource of a pass:"
            " it renders only where somebody asks for it by name",
            label="not used by itself",
            help="remove it if it is left over",
        )

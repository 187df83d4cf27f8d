"""Has the image pixels, and of the right number?"""

from __future__ import annotations

from collections.abc import Iterator

from ..model import (
    Camera,
    RenderScope,
    Settings,
    SettingsBase,
    Site,
    ValueState,
    View,
)
from ..rule import Context, Finding, Severity, rule
from ._rendered import live
from ._words import paths, spelt

GROUP = "settings"

_HUGE, _TINY = 16384, 16


@rule(
    "invalid-resolution",
    on=SettingsBase,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=("blocked-value",),
    by_itself=True,
    about=("resolution",),
)
def invalid_resolution(prim: SettingsBase, context: Context) -> Iterator[Finding]:
    """The resolution has no pixels."""
    attr = prim.resolution
    # On a product a block inherits the settings' value; on the settings it kills the fallback.
    blocked = attr.state is ValueState.BLOCKED and isinstance(prim, Settings)
    if not blocked and not (attr.authored and min(attr.value) <= 0):
        return
    width, height = attr.value
    why = "is blocked, which reads as" if blocked else "is"
    yield Finding(
        attr,
        f"resolution of <{prim.path}> {why} {width} x {height}: there are no pixels to render",
        label="no pixels",
        help="both numbers must be above 0, such as (1920, 1080)",
    )


@rule(
    "suspicious-resolution",
    on=RenderScope,
    severity=Severity.NOTE,
    since="0.1",
    default=False,
    about=("resolution",),
)
def suspicious_resolution(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """The resolution is very large, very small, or turned against the camera."""
    for prim in live(scope):
        width, height = prim.resolution.value
        if prim.resolution.state is not ValueState.AUTHORED or min(width, height) <= 0:
            continue
        if max(width, height) > _HUGE or min(width, height) < _TINY:
            kind = "very large" if max(width, height) > _HUGE else "very small"
            yield Finding(
                prim.resolution,
                f"resolution of <{prim.path}> is {width} x {height}, which is {kind}",
                label=kind,
                help="is there a digit too many or too few?",
            )
    for camera in scope.cameras:
        for view in camera.views:
            yield from _turned(camera, view)


def _turned(camera: Camera, view: View) -> Iterator[Finding]:
    """Portrait against landscape."""
    width, height = view.resolution.value
    across, up = camera.horizontal_aperture.value, camera.vertical_aperture.value
    if view.resolution.state is not ValueState.AUTHORED or min(width, height, across, up) <= 0:
        return
    image = view.pixel_aspect_ratio.value * width / height
    if image <= 0 or (image - 1) * (across / up - 1) >= 0:
        return
    yield Finding(
        view.resolution,
        f"{width} x {height} is {_format_of(image)}, and the aperture of its camera <{camera.path}>"
        f" {_format_of(across / up)}: {across:g} x {up:g}",
        label=_format_of(image),
        help="are width and height swapped?",
        related=((camera.horizontal_aperture, "is the aperture's width"),),
    )


def _format_of(ratio: float) -> str:
    return "landscape" if ratio > 1 else "portrait"


@rule(
    "default-resolution",
    on=Settings,
    severity=Severity.NOTE,
    since="0.1",
    default=False,
    about=("products",),
)
def default_resolution(settings: Settings, context: Context) -> Iterator[Finding]:
    """No resolution is authored, so every renderer takes its own."""
    without = [
        o.product.path
        for o in settings.outputs
        if o.product.live and o.resolution.state is ValueState.FALLBACK
    ]
    if without:
        yield Finding(
            Site(f"{settings.path}.resolution"),
            f"<{settings.path}> has no resolution for {paths(without)}:"
            f" Hydra takes {spelt(settings.resolution.value)}, other renderers their own default",
            label="no resolution",
            help="write the size: uniform int2 resolution = (1920, 1080)",
        )

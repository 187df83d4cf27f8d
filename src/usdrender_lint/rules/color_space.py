"""Does the renderer know the space that it is to work in?"""

from __future__ import annotations

from collections.abc import Iterator

from ..model import (
    ColorSpace,
    Settings,
    ValueState,
)
from ..rule import Context, Finding, Severity, rule
from ._words import nearest

GROUP = "settings"

_MEANT_SPACES = {
    "aces2065-1": "lin_ap0_scene",
    "aces": "lin_ap0_scene",
    "acescg": "lin_ap1_scene",
    "lin_srgb": "lin_rec709_scene",
    "srgb": "lin_rec709_scene",
    "rec709": "lin_rec709_scene",
}
"""By lower case. Rendering is linear: who writes sRGB wants its primaries."""


@rule(
    "unknown-rendering-color-space",
    on=Settings,
    severity=Severity.WARNING,
    since="0.1",
    about=("renderingColorSpace",),
)
def unknown_rendering_color_space(settings: Settings, context: Context) -> Iterator[Finding]:
    """`renderingColorSpace` is a name that neither USD nor the scene defines."""
    attr = settings.rendering_color_space
    if attr.state is not ValueState.AUTHORED or settings.color_space is not None:
        return
    meant = _meant_space(attr.value, settings.color_space_names)
    yield Finding(
        attr,
        f"USD knows no color space '{attr.value}': a renderer that goes by its names takes its own default",
        label="unknown to USD",
        help=f"did you mean '{meant}'?"
        if meant
        else "names that USD knows are 'lin_rec709_scene', 'lin_ap1_scene' (ACEScg) and the like; an OCIO"
        " configuration may know this one",
        # Names of an OCIO configuration are like none of USD's.
        severity=None if meant else Severity.NOTE,
    )


def _meant_space(name: str, known: tuple[str, ...]) -> str | None:
    if f"{name.lower()}_scene" in known:
        return f"{name.lower()}_scene"
    return _MEANT_SPACES.get(name.lower()) or nearest(name, known)


@rule(
    "nonlinear-rendering-color-space",
    on=Settings,
    severity=Severity.WARNING,
    since="0.1",
    about=("renderingColorSpace",),
)
def nonlinear_rendering_color_space(settings: Settings, context: Context) -> Iterator[Finding]:
    """`renderingColorSpace` names a space in which light does not add up."""
    attr, space = settings.rendering_color_space, settings.color_space
    if space is None or not (space.is_data or space.gamma != 1):
        return
    yield Finding(
        attr,
        f"renderingColorSpace '{attr.value}' {_no_working_space(space)}: renderers compute in linear light",
        label="not linear",
        help="write a linear space such as 'lin_rec709_scene' or 'lin_ap1_scene', or leave it out",
    )


def _no_working_space(space: ColorSpace) -> str:
    if space.is_data:
        return "is for data, not for color"
    return f"is encoded with a gamma of {space.gamma:g}"

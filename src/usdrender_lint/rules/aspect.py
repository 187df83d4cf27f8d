"""Does the camera fit the frame?"""

from __future__ import annotations

import math
from collections.abc import Iterator

from ..model import (
    Settings,
    SettingsBase,
    ValueState,
)
from ..rule import Context, Finding, Severity, rule
from ._rendered import views_of
from ._words import nearest, one_of

GROUP = "settings"

POLICIES = (
    "expandAperture",
    "cropAperture",
    "adjustApertureWidth",
    "adjustApertureHeight",
    "adjustPixelAspectRatio",
)


@rule(
    "unknown-aspect-policy",
    on=SettingsBase,
    severity=Severity.ERROR,
    since="0.1",
    by_itself=True,
    about=("aspectRatioConformPolicy",),
)
def unknown_aspect_policy(prim: SettingsBase, context: Context) -> Iterator[Finding]:
    """`aspectRatioConformPolicy` holds a word that USD does not know."""
    attr = prim.aspect_ratio_conform_policy
    if attr.state is not ValueState.AUTHORED or attr.value in POLICIES:
        return
    begun = (p for p in POLICIES if attr.value and p.startswith(attr.value.lower()))
    meant = nearest(attr.value, POLICIES, 0.6) or next(begun, None)
    yield Finding(
        attr,
        f"'{attr.value}' is no aspectRatioConformPolicy: OpenUSD's render spec then fits nothing,"
        " Hydra takes 'expandAperture'",
        label="no such policy",
        help=f"did you mean '{meant}'?" if meant else f"policies are {one_of(POLICIES)}",
    )


@rule(
    "invalid-pixel-aspect-ratio",
    on=SettingsBase,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=("ignored-pixel-aspect-ratio",),
    by_itself=True,
    about=("pixelAspectRatio",),
)
def invalid_pixel_aspect_ratio(prim: SettingsBase, context: Context) -> Iterator[Finding]:
    """The pixel aspect ratio is no number above 0."""
    attr = prim.pixel_aspect_ratio
    if attr.state is ValueState.AUTHORED and not (math.isfinite(attr.value) and attr.value > 0):
        yield Finding(
            attr,
            f"pixelAspectRatio of <{prim.path}> is {attr.value:g}: a pixel has no such shape",
            label="not a number above 0",
            help="write 1 for square pixels, or leave it out",
        )


@rule(
    "ignored-pixel-aspect-ratio",
    on=Settings,
    severity=Severity.WARNING,
    since="0.1",
    about=("pixelAspectRatio",),
)
def ignored_pixel_aspect_ratio(settings: Settings, context: Context) -> Iterator[Finding]:
    """A pixel aspect ratio is authored, and the policy computes another."""
    for view in views_of(settings):
        ratio, policy = view.pixel_aspect_ratio, view.aspect_ratio_conform_policy
        if policy.value != "adjustPixelAspectRatio" or ratio.state is not ValueState.AUTHORED:
            continue
        if ratio.value != 1:
            yield Finding(
                ratio,
                f"pixelAspectRatio {ratio.value:g} has no effect:"
                " 'adjustPixelAspectRatio' computes it from the aperture and the resolution",
                label="overwritten",
                help="remove it, or choose another aspectRatioConformPolicy",
                related=((policy, "is the policy"),),
            )

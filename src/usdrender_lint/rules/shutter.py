"""Is there motion blur, by both of the flags?"""

from __future__ import annotations

from collections.abc import Iterator

from ..model import (
    Attr,
    Settings,
    SettingsBase,
    Site,
    ValueState,
)
from ..rule import Context, Finding, Severity, rule
from ._rendered import views_of

GROUP = "settings"


@rule(
    "deprecated-instantaneous-shutter",
    on=Settings,
    severity=Severity.WARNING,
    since="0.1",
    about=("instantaneousShutter",),
)
def deprecated_instantaneous_shutter(settings: Settings, context: Context) -> Iterator[Finding]:
    """Motion blur is switched off where most renderers no longer look."""
    flags: dict[Site, Attr[bool]] = {}
    for view in views_of(settings):
        flag = view.instantaneous_shutter
        if flag.state is ValueState.AUTHORED and flag.value and not view.disable_motion_blur.value:
            flags[flag.site] = flag
    for flag in flags.values():
        yield Finding(
            flag,
            f"instantaneousShutter of <{flag.site.prim_path}> is deprecated, and OpenUSD's render spec"
            " does not read it: most renderers still blur",
            label="read by few",
            help="add uniform bool disableMotionBlur = true, and keep this one for kick",
        )


@rule(
    "conflicting-shutter-flags",
    on=SettingsBase,
    severity=Severity.WARNING,
    since="0.1",
    supersedes=("deprecated-instantaneous-shutter",),
    about=("instantaneousShutter",),
)
def conflicting_shutter_flags(prim: SettingsBase, context: Context) -> Iterator[Finding]:
    """One flag switches motion blur off and the other leaves it on."""
    old, new = prim.instantaneous_shutter, prim.disable_motion_blur
    if not old.state is new.state is ValueState.AUTHORED or old.value == new.value:
        return
    if new.value:  # how Solaris writes: meant as it is, but kick does not see it, nor did Karma before Houdini 19.5
        yield Finding(
            old,
            f"<{prim.path}> has disableMotionBlur true and instantaneousShutter false: a renderer that"
            " reads only the deprecated flag renders with motion blur",
            label="says blur",
            help="write the same in both, or leave this one out",
            related=((new, "says no blur"),),
            severity=Severity.NOTE,
        )
    else:
        yield Finding(
            old,
            f"<{prim.path}> has instantaneousShutter true and disableMotionBlur false: kick"
            " renders without motion blur, others with it",
            label="says no blur",
            help="write the same in both",
            related=((new, "says blur"),),
        )

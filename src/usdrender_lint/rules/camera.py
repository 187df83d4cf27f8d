"""Is there one camera to render through?"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TypeVar

from ..model import (
    EXTERNAL_CAMERA,
    Attr,
    Camera,
    Output,
    RenderScope,
    Settings,
    SettingsBase,
    Site,
    ValueState,
    View,
)
from ..rule import Context, Finding, Severity, Sign, rule
from ._chains import dead_ends, start_of
from ._words import paths

GROUP = "camera"

T = TypeVar("T")

_SAME_SHAPE = 0.01
"""Ratios that differ by less are one, rounded."""


@rule("missing-camera", on=RenderScope, severity=Severity.ERROR, since="0.1", about=("products",))
def missing_camera(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """Neither the product nor its settings name a camera."""
    told: set[str] = set()
    for settings in scope.settings:
        if not settings.live:
            continue
        for finding in _without_camera(settings, scope):
            path = finding.at.site.path
            if path not in told:  # a product that two settings share lacks its camera once
                told.add(path)
                yield finding


def _without_camera(settings: Settings, scope: RenderScope) -> Iterator[Finding]:
    if settings.camera.named:
        return
    outputs = [o for o in settings.outputs if o.product.live]
    blind = [o for o in outputs if not o.product.camera.named]
    if not blind:
        return
    if (outside := settings.extra_attr(EXTERNAL_CAMERA)) and outside.value:
        yield Finding(
            outside,
            f"<{settings.path}> is seen through Maya's own camera '{outside.value}', which is not on this stage: outside Maya {paths(o.product.path for o in blind)} will not be rendered",
            label="not a prim",
            help="for other renderers export that camera, and write rel camera = </path/of/the/camera>",
            severity=Severity.NOTE,
        )
    elif len(blind) == len(outputs):
        dropped = paths(o.product.path for o in blind)
        yield Finding(
            _camera(settings),
            f"<{settings.path}> names no camera, nor does any of its products: {dropped} will not be rendered",
            label="no camera",
            help=_choose(scope),
            related=dead_ends(settings.camera),
        )
    else:
        for output in blind:
            yield _blind_product(output, scope)


def _blind_product(output: Output, scope: RenderScope) -> Finding:
    return Finding(
        _camera(output.product),
        f"neither <{output.product.path}> nor its settings <{output.settings}> name a camera: it will not be rendered",
        label="no camera",
        help=_choose(scope),
        related=dead_ends(output.product.camera),
    )


def _camera(prim: SettingsBase) -> Site:
    return Site(f"{prim.path}.camera")


def _choose(scope: RenderScope) -> str:
    known = sorted(
        {t.path for s in (*scope.settings, *scope.products) for t in s.camera.of_type("Camera")}
    )
    if known:
        return f"write rel camera; cameras that others use: {paths(known)}"
    return "write rel camera = </path/of/the/camera> on the settings"


@rule("multiple-cameras", on=SettingsBase, severity=Severity.WARNING, since="0.1")
def multiple_cameras(prim: SettingsBase, context: Context) -> Iterator[Finding]:
    """The camera relationship names several prims, and only the first is used."""
    targets = prim.camera.targets
    if len(targets) > 1:
        yield Finding(
            targets[1].written,
            f"<{prim.path}> names {len(targets)} cameras: only the first, <{targets[0].path}>, is used",
            label="not used",
            help="leave one; list edits of other layers decide which is the first",
            related=start_of(targets[1]),
        )


@rule(
    "inverted-shutter",
    on=Camera,
    severity=Severity.ERROR,
    since="0.1",
    about=("shutter:open", "shutter:close"),
)
def inverted_shutter(camera: Camera, context: Context) -> Iterator[Finding]:
    """The shutter closes before it opens."""
    opens, closes = camera.shutter_open, camera.shutter_close
    if camera.views and all(v.disable_motion_blur.value for v in camera.views):
        return  # nobody asks when it closes; most renderers ask whatever the deprecated flag says
    for time, (first, last) in camera.over_time(opens, closes):
        if last < first:
            written = closes if closes.authored else opens
            yield Finding(
                _at(written, time),
                f"the shutter of <{camera.path}> closes at {last:g}, before it opens at {first:g}{_when(time)}:"
                " there is no exposure",
                label="closes first" if written is closes else "opens last",
                help="are shutter:open and shutter:close swapped?"
                if closes.authored
                else f"shutter:close is not written, and falls back to {last:g}: write it",
                related=((opens, "opens it"),) if closes.authored and opens.authored else (),
            )
            return


@rule("zero-shutter", on=Camera, severity=Severity.NOTE, since="0.1", default=False)
def zero_shutter(camera: Camera, context: Context) -> Iterator[Finding]:
    """Motion blur is on, and the shutter is never open."""
    blurred = [v for v in camera.views if _blurs(v)]
    opens, closes = camera.shutter_open, camera.shutter_close
    moments = list(camera.over_time(opens, closes))
    if blurred and all(first == last for _, (first, last) in moments):
        yield Finding(
            closes if closes.authored else opens,
            f"the shutter of <{camera.path}> opens and closes at {moments[0][1][0]:g}:"
            f" motion blur is on for {paths(_path(v) for v in blurred)}, and nothing blurs",
            label="no time between",
            help="write shutter:open = -0.25 and shutter:close = 0.25, or disableMotionBlur = true",
        )


def _blurs(view: View) -> bool:
    return not (view.disable_motion_blur.value or view.instantaneous_shutter.value)


@rule(
    "invalid-clipping-range",
    on=Camera,
    severity=Severity.ERROR,
    since="0.1",
    about=("clippingRange",),
)
def invalid_clipping_range(camera: Camera, context: Context) -> Iterator[Finding]:
    """The clipping range leaves nothing between its planes, or begins behind the lens."""
    attr = camera.clipping_range
    for time, ((near, far),) in camera.over_time(attr):
        if not near < far:
            yield Finding(
                _at(attr, time),
                f"clippingRange of <{camera.path}> is ({near:g}, {far:g}){_when(time)}: nothing lies"
                " between its near and its far plane",
                label="near is not nearer than far",
                help="are the two swapped?"
                if far < near
                else "write the near distance, then the far",
            )
            return
        if camera.is_perspective and near <= 0:
            yield Finding(
                _at(attr, time),
                f"clippingRange of <{camera.path}> begins at {near:g}{_when(time)}: a perspective camera"
                " sees only what is in front of it, and rasterizers lose all depth",
                label="not in front of the lens",
                help="write a near distance above 0",
                severity=Severity.WARNING,
            )
            return


@rule(
    "invalid-camera-lens",
    on=Camera,
    severity=Severity.ERROR,
    since="0.1",
    about=("horizontalAperture", "verticalAperture", "focalLength"),
)
def invalid_camera_lens(camera: Camera, context: Context) -> Iterator[Finding]:
    """An aperture or the focal length is not above 0."""
    needed = [camera.horizontal_aperture, camera.vertical_aperture]
    if camera.is_perspective:
        needed.append(camera.focal_length)
    for attr in needed:
        for time, (value,) in camera.over_time(attr):
            if not (math.isfinite(value) and value > 0):
                yield Finding(
                    _at(attr, time),
                    f"{attr.name} of <{camera.path}> is {value:g}{_when(time)}: the camera has no field of view",
                    label="not above 0",
                    help="write a length above 0, in tenths of a scene unit: millimeters, where that is a centimeter",
                )
                break


@rule(
    "incomplete-depth-of-field", on=Camera, severity=Severity.WARNING, since="0.1", about=("fStop",)
)
def incomplete_depth_of_field(camera: Camera, context: Context) -> Iterator[Finding]:
    """There is an f-stop and no distance to focus at."""
    focused = [v for v in camera.views if not v.disable_depth_of_field.value]
    stop, distance = camera.f_stop, camera.focus_distance
    if not focused or not camera.is_perspective:
        return
    for time, (number, where) in camera.over_time(stop, distance):
        if number > 0 >= where:
            yield Finding(
                _at(distance if distance.authored else stop, time),
                f"<{camera.path}> has fStop {number:g} and focusDistance {where:g}{_when(time)}: RenderMan"
                " leaves out depth of field, Arnold blurs everything",
                label="no focusDistance" if not distance.authored else "focuses at no distance",
                help="write focusDistance, or fStop = 0 for a picture without depth of field",
            )
            return


@rule(
    "instanced-camera",
    on=Camera,
    severity=Severity.WARNING,
    since="0.1",
    about=(Sign.INSTANCED_CAMERA,),
)
def instanced_camera(camera: Camera, context: Context) -> Iterator[Finding]:
    """The camera stands in an instance."""
    if camera.instance is None:
        return
    leading = {v.camera.targets[0].site: v.camera.targets[0] for v in camera.views}
    for target in leading.values():
        yield Finding(
            target,
            f"the camera <{camera.path}> stands in the instance <{camera.instance}>:"
            " Hydra has no camera at that path",
            label="shared by all instances",
            help=f"write instanceable = false on <{camera.instance}>",
            related=((Site(camera.instance, "instanceable"), "is the instance"),),
        )


@rule("aspect-mismatch", on=Camera, severity=Severity.NOTE, since="0.1", default=False)
def aspect_mismatch(camera: Camera, context: Context) -> Iterator[Finding]:
    """Camera and image have different shapes, and nobody says what gives way."""
    across, up = camera.horizontal_aperture, camera.vertical_aperture
    told: set[float] = set()
    for view in camera.views:
        width, height = view.resolution.value
        image = view.pixel_aspect_ratio.value * width / (height or 1)
        if view.aspect_ratio_conform_policy.state is not ValueState.FALLBACK or image in told:
            continue
        if min(across.value, up.value, width, height, image) <= 0:
            continue
        if abs(across.value / up.value / image - 1) > _SAME_SHAPE:
            told.add(image)
            yield Finding(
                up if up.authored else across,
                f"the aperture of <{camera.path}> is {across.value:g} x {up.value:g}"
                f" ({across.value / up.value:.3g}), the image of <{_path(view)}> {width} x {height}"
                f" ({image:.3g}): the aperture is expanded to fit",
                label="another shape than the image",
                help="give both one shape, or say with aspectRatioConformPolicy what gives way",
                related=((view.resolution, "is the image"),) if view.resolution.authored else (),
            )


@rule(
    "animated-aperture",
    on=Camera,
    severity=Severity.NOTE,
    since="0.1",
    default=False,
    about=("horizontalAperture", "verticalAperture"),
)
def animated_aperture(camera: Camera, context: Context) -> Iterator[Finding]:
    """The aperture varies, and the image is fitted with its value at the default time."""
    for attr in (camera.horizontal_aperture, camera.vertical_aperture):
        other = next(((t, v) for t, v in attr.samples if v != attr.value), None)
        if attr.varying is not None and other is not None:
            time, value = other
            yield Finding(
                Site(attr.site.path, attr.varying),
                f"{attr.name} of <{camera.path}> is {value:g} at frame {time:g}: OpenUSD's render spec fits"
                f" the image to its value at the default time, {attr.value:g}",
                label="not at the default time",
                help="animate focalLength instead",
            )


def _at(attr: Attr[T], time: float | None) -> Site:
    """The samples, where they are what is wrong."""
    return Site(attr.site.path, attr.varying if time is not None and attr.varying else "default")


def _when(time: float | None) -> str:
    return "" if time is None else f" at frame {time:g}"


def _path(view: View) -> str:
    return view.product.path if isinstance(view, Output) else view.path

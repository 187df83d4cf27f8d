"""Which cameras are rendered through, and what do they say at the frames that are rendered?"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any, TypeVar

from pxr import Sdf, Usd

from ..likeness import likeness
from ..model import (
    Attr,
    Camera,
    FrameRange,
    Product,
    Settings,
    Site,
    State,
    Target,
    ValueState,
    View,
)
from .prims import Asked, same_storage, state_of
from .properties import read_property
from .values import plain_floats, plain_text, read_attr

T = TypeVar("T")

_SIMILAR = (0.5, 0.78)
"""Ratio from which a name is that of a camera, misspelt: of the only one there is, and of one of
several."""

_PROJECTIONS = ("perspective", "orthographic", "")
"""All that the schema allows; blocked, it is empty."""

_ATTRIBUTES: dict[str, tuple[str, Callable[[Any], Any]]] = {
    "projection": ("projection", plain_text),
    "horizontal_aperture": ("horizontalAperture", float),
    "vertical_aperture": ("verticalAperture", float),
    "focal_length": ("focalLength", float),
    "clipping_range": ("clippingRange", plain_floats),
    "f_stop": ("fStop", float),
    "focus_distance": ("focusDistance", float),
    "shutter_open": ("shutter:open", float),
    "shutter_close": ("shutter:close", float),
}


def read_cameras(
    stage: Usd.Stage,
    frames: FrameRange,
    settings: Iterable[Settings],
    products: Iterable[Product],
) -> tuple[Camera, ...]:
    views: dict[str, list[View]] = {}
    for view in _views(settings, products):
        # Every reader of the render spec takes the first target.
        for target in view.camera.targets[:1]:
            if target.live and "Camera" in target.isa and not target.is_property:
                views.setdefault(target.path, []).append(view)
            elif meant := _meant(stage, target):
                views.setdefault(meant, []).append(view)
    return tuple(
        _camera(stage.GetPrimAtPath(path), frames, tuple(seen))
        for path, seen in sorted(views.items())
    )


def _meant(stage: Usd.Stage, target: Target) -> str | None:
    """The camera that will be rendered through once a broken target is mended: its faults need not
    wait for that."""
    path = _path_meant(target)
    prim = stage.GetPrimAtPath(path) if path else None
    if not prim or not prim.IsA("Camera") or prim.IsInstanceProxy() or prim.IsInstance():
        return None
    return path if state_of(prim) is State.LIVE else None


def _path_meant(target: Target) -> str | None:
    if target.is_property:
        return target.path.partition(".")[0]
    if target.meant:
        return target.meant
    found = target.candidates
    if not found:
        return None
    if target.state is State.LIVE:  # of another type
        below = found[0].path.startswith(f"{target.path}/")
        return found[0].path if below or len(found) == 1 else None
    near = likeness(target.path.rpartition("/")[2], found[0].name) >= _SIMILAR[len(found) > 1]
    return found[0].path if near and target.state is State.MISSING else None


def _views(settings: Iterable[Settings], products: Iterable[Product]) -> Iterator[View]:
    listed: set[str] = set()
    for one in settings:
        if not one.live:
            continue
        outputs = [o for o in one.outputs if o.product.live]
        listed.update(o.product.path for o in outputs)
        yield from outputs
        if not outputs:
            yield one
    yield from (p for p in products if p.live and p.path not in listed)


def _camera(prim: Usd.Prim, frames: FrameRange, views: tuple[View, ...]) -> Camera:
    asked = Asked(prim)
    path = asked.path
    attrs = {field: _attr(asked, name, plain) for field, (name, plain) in _ATTRIBUTES.items()}
    varying = [attr for attr in attrs.values() if _varies(asked, attr)]
    times = _times(prim, varying, frames)
    for field, (_, plain) in _ATTRIBUTES.items():
        if attrs[field] in varying:
            attrs[field] = _sampled(asked, attrs[field], plain, times)
    known = asked.schema.names
    odd = [name for name in asked.authored if ":" not in name and name not in known]
    odd += [attr.name for attr in attrs.values() if attr.state is ValueState.MISTYPED]
    if attrs["projection"].value not in _PROJECTIONS:
        odd.append("projection")
    return Camera(
        path=path,
        type_name=str(prim.GetTypeName()),
        site=Site(path),
        properties=tuple(read_property(asked, name) for name in sorted({*odd})),
        built_in=tuple(sorted(n for n in known if ":" not in n)) if odd else (),
        **attrs,
        instance=_instance(prim),
        views=views,
    )


def _attr(asked: Asked, name: str, plain: Callable[[Any], T]) -> Attr[T]:
    """A blocked value is the fallback: cameras are read at the frame, where a block leaves it be."""
    declared = asked.schema.attribute(name)
    assert declared is not None, "cameras have all of these"  # noqa: S101 for mypy
    return read_attr(asked, name, plain, asked.schema.fallback(name, plain, declared.default))


def _varies(asked: Asked, attr: Attr[Any]) -> bool:
    """Samples of a wrong type are not read."""
    if attr.varying is None or attr.state is ValueState.MISTYPED:
        return False
    schema = asked.schema.attribute(attr.name)
    written = Sdf.ValueTypeNames.Find(attr.authored_type)
    return schema is not None and same_storage(written, schema.type)


def _times(prim: Usd.Prim, varying: list[Attr[Any]], frames: FrameRange) -> list[float]:
    """When the attributes have samples or knots inside the frame range, and at its ends."""
    times: set[float] = set()
    for attr in varying:
        attribute = prim.GetAttribute(attr.name)
        if attr.varying == "spline":
            times.update(float(t) for t in attribute.GetSpline().GetKnots().keys())  # noqa: SIM118 no dictionary of Python's
        else:
            times.update(float(t) for t in attribute.GetTimeSamples())
    ends = {t for t in (frames.start, frames.end) if times and t is not None}
    return sorted(ends | {t for t in times if frames.holds(t)})


def _sampled(asked: Asked, attr: Attr[T], plain: Callable[[Any], T], times: list[float]) -> Attr[T]:
    attribute, declared = asked.prim.GetAttribute(attr.name), asked.schema.attribute(attr.name)
    assert declared is not None, "cameras have all of these"  # noqa: S101 for mypy
    read = ((time, attribute.Get(time)) for time in times)
    values = (
        (time, declared.checked(value, f"{asked.path}.{attr.name}"))
        for time, value in read
        if value is not None
    )
    return replace(attr, samples=tuple((time, plain(value)) for time, value in values))


def _instance(prim: Usd.Prim) -> str | None:
    if not prim.IsInstanceProxy():
        return None
    while prim.IsInstanceProxy():
        prim = prim.GetParent()
    return str(prim.GetPath())

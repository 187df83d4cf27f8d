"""Which part of the frame is rendered?"""

from __future__ import annotations

import math
from collections.abc import Iterator

from ..model import (
    RenderScope,
)
from ..rule import Context, Finding, Severity, rule
from ._rendered import Size, Window, named_settings, outputs_of, windows_of
from ._words import spelt

GROUP = "settings"

_PIXELS = 4.0
"""From this a data window counts pixels: nobody renders three frames of overscan on each side."""
_CROPPED = 1e-4
"""Of the frame's width: less is rounding."""


@rule(
    "empty-data-window",
    on=RenderScope,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=("data-window-units", "leftover-crop"),
    about=("dataWindowNDC",),
)
def empty_data_window(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """The data window holds no pixel."""
    for prim, sizes in windows_of(scope):
        window = prim.data_window_ndc.value
        if found := _nothing_in(window, sizes):
            why, severity = found
            yield Finding(
                prim.data_window_ndc,
                f"dataWindowNDC of <{prim.path}> is {spelt(window)}: {why}",
                label="holds nothing of the frame",
                help=_mended(window),
                severity=severity,
            )


def _nothing_in(window: Window, sizes: list[Size]) -> tuple[str, Severity | None] | None:
    left, bottom, right, top = window
    if not all(math.isfinite(v) for v in window):
        return "not all of these are numbers", None
    if left >= right:
        return f"xmin {left:g} is not below xmax {right:g}", None
    if bottom >= top:
        return f"ymin {bottom:g} is not below ymax {top:g}", None
    for width, height in sizes:
        if min(width, height) > 0 and not (
            _centers(left, right, width) and _centers(bottom, top, height)
        ):
            return f"no pixel of {width} x {height} has its center in it", None
    outside = left >= 1 or bottom >= 1 or right <= 0 or top <= 0
    if outside and max(map(abs, window)) <= _PIXELS:
        return "it lies beside the frame, which is (0, 0, 1, 1)", Severity.WARNING
    return None


def _centers(low: float, high: float, pixels: int) -> int:
    """How many pixels have their center between two edges."""
    return math.ceil(high * pixels - 0.5) - math.ceil(low * pixels - 0.5)


def _mended(window: Window) -> str:
    left, bottom, right, top = window
    ordered = (min(left, right), min(bottom, top), max(left, right), max(bottom, top))
    if ordered != window and ordered[0] < ordered[2] and ordered[1] < ordered[3]:
        return f"the order is xmin, ymin, xmax, ymax: did you mean {spelt(ordered)}?"
    return "the order is xmin, ymin, xmax, ymax, and (0, 0, 1, 1) is the whole frame"


@rule(
    "data-window-units",
    on=RenderScope,
    severity=Severity.WARNING,
    since="0.1",
    supersedes=("leftover-crop",),
    about=("dataWindowNDC",),
)
def data_window_units(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """The data window counts pixels, where the frame is 1 wide and 1 high."""
    for prim, sizes in windows_of(scope):
        window = prim.data_window_ndc.value
        if not all(math.isfinite(v) for v in window) or max(map(abs, window)) <= _PIXELS:
            continue
        left, bottom, right, top = window
        width, height = sizes[0]
        meant = (
            left / (width or 1),
            bottom / (height or 1),
            right / (width or 1),
            top / (height or 1),
        )
        yield Finding(
            prim.data_window_ndc,
            f"dataWindowNDC of <{prim.path}> is {spelt(window)}: these look like pixels,"
            " and the whole frame is (0, 0, 1, 1)",
            label="pixels?",
            help=f"divide by the resolution: {spelt(meant)}",
        )


@rule(
    "leftover-crop", on=RenderScope, severity=Severity.NOTE, since="0.1", about=("dataWindowNDC",)
)
def leftover_crop(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """Only a part of the frame is rendered."""
    named = named_settings(scope)
    for prim, _ in windows_of(scope):
        users = {s.path for s, o in outputs_of(scope) if o.product.path == prim.path} or {prim.path}
        left, bottom, right, top = prim.data_window_ndc.value
        if named and not users & named:
            continue
        if max(left, bottom) > _CROPPED or min(right, top) < 1 - _CROPPED:
            part = _length(left, right) * _length(bottom, top)
            share = f"{part:.0%}" if part >= 0.005 else "less than 1%"
            yield Finding(
                prim.data_window_ndc,
                f"dataWindowNDC of <{prim.path}> is {spelt(prim.data_window_ndc.value)}:"
                f" {share} of the frame will be rendered",
                label="a crop",
                help="remove it, if it was left over from interactive work",
            )


def _length(low: float, high: float) -> float:
    """Of the stretch that lies in the frame."""
    return max(0.0, min(high, 1.0) - max(low, 0.0))

"""What the rules about cameras believe of USD, tried; and what is read of a camera over time."""

from __future__ import annotations

from collections.abc import Iterable

import pytest
from pxr import Sdf, Usd

from usdrender_lint.model import Camera, Settings
from usdrender_lint.read import read
from usdrender_lint.read.text import Texts
from usdrender_lint.stage import open_stage

STAGE = """#usda 1.0
(
    %s
)
def Scope "Render"
{
    def RenderSettings "S"
    {
        rel camera = </rig/cam>
    }
}
class Xform "_rig"
{
    def Camera "cam"
    {
        %s
    }
}
def Xform "rig" (
    inherits = </_rig>
    instanceable = %s
)
{
}
"""


def camera(body: str = "", metadata: str = "", instanceable: str = "false") -> Camera:
    layer = Sdf.Layer.CreateAnonymous(".usda")
    assert layer.ImportFromString(STAGE % (metadata, body, instanceable))
    (found,) = read(open_stage(layer, ("/Render",)), Texts()).cameras
    return found


def times(samples: Iterable[tuple[float, object]]) -> list[float]:
    return [time for time, _ in samples]


def test_fallbacks() -> None:
    """A camera without opinions has a lens, no shutter and no depth of field."""
    read_one = camera()
    assert read_one.focal_length.value == 50
    assert read_one.clipping_range.value == (1, 1_000_000)
    assert (read_one.shutter_open.value, read_one.shutter_close.value) == (0, 0)
    assert (read_one.f_stop.value, read_one.focus_distance.value) == (0, 0)


def test_a_camera_in_an_instance_is_found_and_is_a_proxy() -> None:
    layer = Sdf.Layer.CreateAnonymous(".usda")
    assert layer.ImportFromString(STAGE % ("", "", "true"))
    stage = Usd.Stage.Open(layer)
    prim = stage.GetPrimAtPath("/rig/cam")
    assert prim.IsA("Camera")
    assert prim.IsInstanceProxy()
    assert camera(instanceable="true").instance == "/rig"
    assert camera().instance is None


def test_nothing_varies() -> None:
    one = camera("double shutter:open = 0.25")
    assert list(one.over_time(one.shutter_open, one.shutter_close)) == [(None, (0.25, 0))]


@pytest.mark.parametrize(
    ("metadata", "wanted"),
    [
        ("", [1, 10, 20]),
        ("startTimeCode = 5", [5, 10, 20]),
        ("startTimeCode = 5\n endTimeCode = 15", [5, 10, 15]),
    ],
)
def test_samples_of_the_frame_range_and_its_ends(metadata: str, wanted: list[float]) -> None:
    one = camera("float focalLength.timeSamples = { 1: 10, 10: 20, 20: 30 }", metadata)
    assert times(one.focal_length.samples) == wanted


def test_all_that_varies_is_read_at_the_same_times() -> None:
    one = camera(
        "double shutter:open.timeSamples = { 1: 0, 3: 1 }\n"
        "double shutter:close.timeSamples = { 2: 0.5 }"
    )
    assert list(one.over_time(one.shutter_open, one.shutter_close)) == [
        (1, (0, 0.5)),
        (2, (0.5, 0.5)),
        (3, (1, 0.5)),
    ]


def test_a_spline_is_read_at_its_knots() -> None:
    one = camera("float focalLength.spline = { 1: 35; post linear, 3: 50 }")
    assert one.focal_length.samples == ((1, 35), (3, 50))


def test_samples_of_another_type_are_not_read() -> None:
    one = camera("double2 clippingRange.timeSamples = { 1: (5, 1) }")
    assert one.clipping_range.samples == ()
    assert one.clipping_range.value == (1, 1_000_000)


def test_a_block_leaves_the_fallback_at_the_frame() -> None:
    layer = Sdf.Layer.CreateAnonymous(".usda")
    assert layer.ImportFromString(STAGE % ("", "float focalLength = None", "false"))
    stage = Usd.Stage.Open(layer)
    focal_length = stage.GetAttributeAtPath("/rig/cam.focalLength")
    assert focal_length.Get() is None
    assert focal_length.Get(1) == 50
    assert camera("float focalLength = None").focal_length.value == 50


def test_settings_without_products_look_through_their_camera() -> None:
    (view,) = camera().views
    assert isinstance(view, Settings)

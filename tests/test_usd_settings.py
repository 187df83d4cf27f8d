"""What the rules about values believe of USD, tried."""

from __future__ import annotations

import pytest
from pxr import Gf, Sdf, Usd

from usdrender_lint.read.colors import read_color_space
from usdrender_lint.read.values import Asked, plain_ints, plain_text, read_attr

LAYER = """#usda 1.0
class RenderSettings "_base"
{
    uniform int2 resolution.timeSamples = {
        1: (5, 5),
    }
    uniform bool disableMotionBlur = true
    uniform token aspectRatioConformPolicy.timeSamples = {
        1: "cropAperture",
    }
}
def Scope "Render" (
    prepend apiSchemas = ["ColorSpaceDefinitionAPI:show"]
)
{
    uniform token colorSpaceDefinition:show:name = "lin_show"
    def RenderSettings "S" (
        inherits = </_base>
    )
    {
        uniform int2 resolution = (10, 10)
        uniform bool disableMotionBlur.timeSamples = {
            1: false,
        }
        uniform float pixelAspectRatio.spline = {
            1: 1,
            10: 2,
        }
    }
}
"""


@pytest.fixture
def stage() -> Usd.Stage:
    layer = Sdf.Layer.CreateAnonymous(".usda")
    assert layer.ImportFromString(LAYER)
    return Usd.Stage.Open(layer)


@pytest.fixture
def settings(stage: Usd.Stage) -> Usd.Prim:
    return stage.GetPrimAtPath("/Render/S")


def test_a_stronger_default_ends_weaker_samples(settings: Usd.Prim) -> None:
    resolution = settings.GetAttribute("resolution")
    assert resolution.Get(1) == Gf.Vec2i(10, 10)
    assert resolution.GetNumTimeSamples() == 0
    assert read_attr(Asked(settings), "resolution", plain_ints, (0, 0)).varying is None


def test_stronger_samples_leave_a_weaker_default(settings: Usd.Prim) -> None:
    blur = settings.GetAttribute("disableMotionBlur")
    assert blur.Get() is True
    assert blur.Get(1) is False
    assert read_attr(Asked(settings), "disableMotionBlur", bool, False).varying == "timeSamples"


@pytest.mark.parametrize("name", ["aspectRatioConformPolicy", "pixelAspectRatio"])
def test_samples_and_splines_count_as_authored_and_read_as_the_fallback(
    settings: Usd.Prim, name: str
) -> None:
    attribute = settings.GetAttribute(name)
    fallback = settings.GetPrimDefinition().GetSchemaAttributeSpec(name).default
    assert attribute.HasAuthoredValue()
    assert attribute.Get() == fallback


def test_a_spline_is_no_time_samples(settings: Usd.Prim) -> None:
    ratio = settings.GetAttribute("pixelAspectRatio")
    assert ratio.GetTimeSamples() == []
    assert ratio.HasSpline()
    assert ratio.Get(10) == 2


@pytest.mark.parametrize(
    ("name", "is_valid"),
    [
        ("lin_rec709_scene", True),
        ("ACEScg", True),
        ("acescg", False),
        ("lin_rec709", False),
        ("sRGB", False),
        ("ACES - ACEScg", False),
        ("", False),
        ("raw", True),
        ("Raw", True),
    ],
)
def test_names_of_color_spaces(name: str, is_valid: bool) -> None:
    assert Gf.ColorSpace.IsValid(name) is is_valid


@pytest.mark.parametrize("name", ["raw", "data", "unknown", "identity"])
def test_data_looks_linear_by_its_gamma(name: str) -> None:
    assert Gf.ColorSpace(name).GetGamma() == 1


@pytest.mark.parametrize("name", ["lin_show", "show", "lin_ap1_scene", "nope"])
def test_we_know_the_names_that_usd_knows(settings: Usd.Prim, name: str) -> None:
    """The value of a definition's `name` is the name, not that of the API's instance."""
    settings.GetAttribute("renderingColorSpace").Set(name)
    read = read_attr(Asked(settings), "renderingColorSpace", plain_text, "")
    space, _ = read_color_space(settings, read)
    assert (space is not None) == Usd.ColorSpaceAPI.IsValidColorSpaceName(settings, name, None)

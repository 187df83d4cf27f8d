"""Rules that are off by default have no fixtures: what they let pass, and what they say once."""

from __future__ import annotations

import pytest

from usdrender_lint.testing import BASE, HEADER, lint_files

BLOCKS = {
    "repeats, for one of two settings": (
        "redundant-override",
        """
def Scope "Render"
{
    def RenderProduct "Beauty"
    {
        uniform int2 resolution = (1920, 1080)
    }
    def RenderSettings "Other"
    {
        rel camera = </World/main_cam>
        rel products = </Render/Beauty>
        uniform int2 resolution = (960, 540)
    }
}
""",
        [],
    ),
    "repeats a blocked, a sampled and another value": (
        "redundant-override",
        """
def Scope "Render"
{
    def RenderProduct "Beauty"
    {
        uniform int2 resolution = None
        uniform float pixelAspectRatio = 1.5
        uniform bool disableMotionBlur.timeSamples = {
            1: false,
        }
    }
}
""",
        [],
    ),
    "another camera": (
        "redundant-override",
        """
def Scope "Render"
{
    def RenderProduct "Beauty"
    {
        rel camera = </World/left_cam>
    }
}
def Xform "World"
{
    def Camera "left_cam"
    {
    }
}
""",
        [],
    ),
    "shapes that differ by rounding": (
        "aspect-mismatch",
        """
def Xform "World"
{
    def Camera "main_cam"
    {
        float verticalAperture = 11.7872
    }
}
""",
        [],
    ),
    "squeezed pixels": (
        "aspect-mismatch",
        """
def Scope "Render"
{
    def RenderSettings "Primary"
    {
        uniform float pixelAspectRatio = 0.7709
    }
}
""",
        [],
    ),
    "one shape for two products": (
        "aspect-mismatch",
        """
def Scope "Render"
{
    def RenderSettings "Primary"
    {
        append rel products = </Render/Matte>
    }
    def RenderProduct "Matte"
    {
        token productName = "/shots/sh010/matte.exr"
        rel orderedVars = </Render/Vars/color>
    }
}
""",
        [
            "the aperture of </World/main_cam> is 20.955 x 15.2908 (1.37), the image of"
            " </Render/Beauty> 1920 x 1080 (1.78): the aperture is expanded to fit"
        ],
    ),
    "no blur wanted, in the old words": (
        "zero-shutter",
        """
def Scope "Render"
{
    def RenderSettings "Primary"
    {
        uniform bool instantaneousShutter = true
    }
}
""",
        [],
    ),
    "a shutter that opens at some frames": (
        "zero-shutter",
        """
def Xform "World"
{
    def Camera "main_cam"
    {
        double shutter:close.timeSamples = {
            1: 0,
            2: 0.5,
        }
    }
}
""",
        [],
    ),
    "samples that say what the default says": (
        "animated-aperture",
        """
def Xform "World"
{
    def Camera "main_cam"
    {
        float horizontalAperture = 24
        float horizontalAperture.timeSamples = {
            1: 24,
        }
    }
}
""",
        [],
    ),
    "portrait through an upright camera": (
        "suspicious-resolution",
        """
def Scope "Render"
{
    def RenderSettings "Primary"
    {
        uniform int2 resolution = (1080, 1920)
    }
}
def Xform "World"
{
    def Camera "main_cam"
    {
        float horizontalAperture = 11
        float verticalAperture = 20
    }
}
""",
        [],
    ),
    "a thumbnail": (
        "suspicious-resolution",
        """
def Scope "Render"
{
    def RenderProduct "Beauty"
    {
        uniform int2 resolution = (12, 8)
    }
}
""",
        ["resolution of </Render/Beauty> is 12 x 8, which is very small"],
    ),
    "the order is told, the spelling not": (
        "houdini-all-purpose",
        """
def Scope "Render"
{
    def RenderSettings "Primary"
    {
        uniform token[] materialBindingPurposes = ["", "full", "allPurpose"]
    }
}
""",
        [],
    ),
    "a fallback by its name": (
        "no-all-purpose-fallback",
        """
def Scope "Render"
{
    def RenderSettings "Primary"
    {
        uniform token[] materialBindingPurposes = ["full", "allPurpose"]
    }
}
""",
        [],
    ),
    "proxies instead": (
        "render-purpose-omitted",
        """
def Scope "Render"
{
    def RenderSettings "Primary"
    {
        uniform token[] includedPurposes = ["default", "proxy"]
    }
}
""",
        [],
    ),
}


@pytest.mark.parametrize(("rule", "block", "wanted"), BLOCKS.values(), ids=BLOCKS)
def test_says(rule: str, block: str, wanted: list[str]) -> None:
    _, found = lint_files({"main.usda": HEADER + block, "base.usda": BASE}, rules=[rule])
    assert [mark.text for mark in found] == wanted

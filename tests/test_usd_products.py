"""What the rules about products and vars rely on in usd-core, tried."""

from __future__ import annotations

from pathlib import Path

import pytest
from pxr import Sdf, Usd

from usdrender_lint.rules._types import pixel


def product_name(folder: Path, statement: str) -> Usd.Attribute:
    """Of a product, as the usda `statement` writes it. The stage is kept alive by the test's folder."""
    file = folder / "main.usda"
    file.write_text(f'#usda 1.0\ndef RenderProduct "P"\n{{\n    {statement}\n}}\n', "utf-8")
    stage = Usd.Stage.Open(str(file))
    STAGES.append(stage)
    return stage.GetPrimAtPath("/P").GetAttribute("productName")


STAGES: list[Usd.Stage] = []


@pytest.mark.parametrize(
    ("written", "read"),
    [
        (r"C:\renders\new\beauty.exr", "C:\renders\new\beauty.exr"),
        (r"C:\shots\out.exr", "C:shotsout.exr"),
        (r"C:\\shots\\out.exr", r"C:\shots\out.exr"),
        ("C:/shots/out.exr", "C:/shots/out.exr"),
    ],
)
def test_a_single_backslash_in_usda_begins_an_escape(
    tmp_path: Path, written: str, read: str
) -> None:
    """`\\r` becomes a carriage return; before a letter that means nothing the backslash is dropped."""
    attribute = product_name(tmp_path, f'token productName = "{written}"')
    assert attribute.Get() == read


def test_a_name_is_held_from_sample_to_sample(tmp_path: Path) -> None:
    """So a single sample names every frame, and frames before the first get the first name."""
    attribute = product_name(tmp_path, 'token productName.timeSamples = { 5: "a", 7: "b" }')
    assert [attribute.Get(t) for t in (1, 5, 6.9, 7, 99)] == ["a", "a", "a", "b", "b"]
    assert attribute.Get() == ""


def test_nothing_in_a_name_is_expanded(tmp_path: Path) -> None:
    name = "~/$HOME/${SHOT}/beauty.$F4.####.exr"
    assert product_name(tmp_path, f'token productName = "{name}"').Get(12) == name


def value_types() -> list[str]:
    """Every name that USD knows, but for arrays."""
    found = (getattr(Sdf.ValueTypeNames, name) for name in dir(Sdf.ValueTypeNames))
    return sorted(
        {str(t) for t in found if isinstance(t, Sdf.ValueTypeName) and not t.isArray and str(t)}
    )


def test_every_value_type_is_a_pixel_or_known_to_be_none() -> None:
    none = {name for name in value_types() if pixel(name) is None}
    assert "matrix4d" in none
    assert none <= {
        *(
            "asset",
            "bool",
            "duration",
            "group",
            "opaque",
            "pathExpression",
            "string",
            "timecode",
            "token",
        ),
        *("frame4d", "matrix2d", "matrix3d", "matrix4d", "quatd", "quatf", "quath"),
    }


@pytest.mark.parametrize("name", ["float", "int3", "half4", "color4h", "texCoord2f", "normal3d"])
def test_a_pixel_has_as_many_numbers_as_the_type(name: str) -> None:
    found = pixel(name)
    assert found is not None
    default = Sdf.ValueTypeNames.Find(name).defaultValue
    assert found.components == (len(default) if hasattr(default, "__len__") else 1)


def test_no_pixel_is_an_array() -> None:
    assert pixel("color3f[]") is None

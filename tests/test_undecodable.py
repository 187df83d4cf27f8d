"""Text that is not UTF-8 costs a binary layer nothing but itself, and is told at its prim."""

from __future__ import annotations

from pathlib import Path

import pytest
from pxr import Sdf

from usdrender_lint.lint import lint
from usdrender_lint.results import Report

SPEC = """\
#usda 1.0
(
    renderSettingsPrimPath = "/Render/S"
)
def Scope "Render"
{
    def RenderSettings "S"
    {
        rel camera = </World/gone>
        rel products = </Render/P>
    }
    def RenderProduct "P"
    {
        token productName = "/out/QQQQ.exr"
        rel orderedVars = </Render/v>
    }
    def RenderVar "v"
    {
        string sourceName = "Ci"
    }
}
"""


def crate(folder: Path, text: str) -> Path:
    """The text as a crate, every QQQQ of which is Latin-1."""
    written, file = folder / "text.usda", folder / "main.usdc"
    written.write_text(text, "utf-8")
    assert Sdf.Layer.FindOrOpen(str(written)).Export(str(file))
    data = file.read_bytes()
    assert b"QQQQ" in data
    file.write_bytes(data.replace(b"QQQQ", b"caf\xe9"))
    return file


def linted(file: Path) -> Report:
    return lint([str(file)], cwd=file.parent)


@pytest.mark.parametrize(
    ("text", "place"),
    [
        (SPEC, "</Render/P>"),
        (SPEC.replace('"Ci"', '"QQQQ"').replace("/out/QQQQ", "/out/a"), "</Render/v>"),
        (SPEC.replace('"/Render/S"', '"/Render/QQQQ"').replace("/out/QQQQ", "/out/a"), "the metadata of the layer"),
    ],
)  # fmt: skip
def test_it_is_told_and_the_rest_is_linted(tmp_path: Path, text: str, place: str) -> None:
    report = linted(crate(tmp_path, text))
    (problem,) = report.problems
    assert (problem.kind, problem.path) == ("undecodable-text", "main.usdc")
    assert f"holds text that is not UTF-8, in {place}: read without it" in problem.message
    assert "unresolved-target" in {f.rule.id for f in report.findings}


def test_the_file_is_left_as_it_is(tmp_path: Path) -> None:
    file = crate(tmp_path, SPEC)
    before = file.read_bytes()
    linted(file)
    assert file.read_bytes() == before


def test_a_layer_that_somebody_has_open_is_left_as_it_is(tmp_path: Path) -> None:
    """In the program that calls this one."""
    file = crate(tmp_path, SPEC)
    opened = Sdf.Layer.FindOrOpen(str(file))
    (problem,) = linted(file).problems
    assert problem.kind == "undecodable-text"
    assert "nothing of it was linted" in problem.message
    with pytest.raises(UnicodeDecodeError):
        opened.GetAttributeAtPath("/Render/P.productName").default  # noqa: B018


def test_a_backslash_is_no_such_byte(tmp_path: Path) -> None:
    """`\\xe9` in usda is a byte, `\\\\xe9` a backslash and three letters."""
    text = SPEC.replace('"Ci"', r'"C:\\xe9"')
    report = linted(crate(tmp_path, text))
    (problem,) = report.problems
    assert "</Render/v>" not in problem.message


def test_what_usd_prints_and_leaves_out(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """In a dictionary nothing is raised."""
    data = 'customLayerData = { dictionary usdrenderLint = { string[] ignore = ["QQQQ"] } }'
    text = SPEC.replace("\n)\n", f"\n    {data}\n)\n").replace("/out/QQQQ", "/out/a")
    (problem,) = linted(crate(tmp_path, text)).problems
    assert problem.kind == "undecodable-text"
    assert "in the metadata of the layer" in problem.message
    assert "UnicodeDecodeError" not in capfd.readouterr().err


def test_a_name_that_is_not_utf_8(tmp_path: Path) -> None:
    """It cannot be replaced in text: nothing is linted, and that is told."""
    file, written = tmp_path / "main.usdc", tmp_path / "text.usda"
    written.write_text(SPEC, "utf-8")
    assert Sdf.Layer.FindOrOpen(str(written)).Export(str(file))
    before = file.read_bytes()
    file.write_bytes(before.replace(b"ttingsPrim", b"\xe9tingsPrim"))
    assert file.read_bytes() != before
    (problem,) = linted(file).problems
    assert problem.kind == "undecodable-text"
    assert "nothing of it was linted" in problem.message

"""What stands in a package or in a plug-in's format: read where USD can, unknown where it cannot."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest
from pxr import Sdf

from usdrender_lint.lint import lint
from usdrender_lint.results import Report, Span
from usdrender_lint.rule import Severity

SPEC = """\
    def RenderSettings "S"
    {
        rel camera = </World/cam>
        rel products = </Render/P>
    }
    def RenderProduct "P"
    {
        token productName = "/out/a.exr"
        rel orderedVars = </Render/v>
    }
    def RenderVar "v"
    {
        string sourceName = "Ci"
    }
"""
META = '#usda 1.0\n(\n    renderSettingsPrimPath = "/Render/S"\n%s)\n'
RENDER = f'def Scope "Render"\n{{\n{SPEC}}}\n'
WORLD = '\ndef Xform "World"\n{\n    def Camera "cam"\n    {\n    }\n}\n'


def package(folder: Path, **members: str) -> Path:
    """A usdz; `main` is its root layer."""
    file = folder / "shot.usdz"
    with Sdf.ZipFileWriter.CreateNew(str(file)) as writer:
        for name, text in members.items():
            (folder / f"{name}.usda").write_text(text, "utf-8")
            writer.AddFile(str(folder / f"{name}.usda"), f"{name}.usda")
    return file


def linted(file: Path) -> Report:
    return lint([str(file)], cwd=file.parent)


@pytest.mark.parametrize("arc", ["sublayer", "reference"])
def test_a_member_that_does_not_parse_is_told(tmp_path: Path, arc: str) -> None:
    if arc == "sublayer":
        main = META % "    subLayers = [@./broken.usda@]\n" + RENDER + WORLD
    else:
        main = META % "" + RENDER + 'def "World" (references = @./broken.usda@)\n{\n}\n'
    report = linted(package(tmp_path, main=main, broken='#usda 1.0\ndef Scope "A"\n{\n  what\n}\n'))
    (finding,) = report.findings
    assert (finding.rule.id, finding.severity) == ("syntax-error", Severity.ERROR)
    at = finding.location
    assert (at.path, at.member, at.span) == ("shot.usdz", "broken.usda", Span(4, 3, 4))


@pytest.mark.parametrize(
    ("name", "held"),
    [
        ("cam.abc", b"Ogawa\xff\x00\x01" + struct.pack("<Q", 16) + b"\x00" * 40),
        ("cam.mtlx", b'<?xml version="1.0"?>\n<materialx version="1.39"/>\n'),
        ("cam.obj", b"v 0 0 0\n"),
    ],
)
def test_a_format_of_a_plugin_is_unknown_and_not_missing(
    tmp_path: Path, name: str, held: bytes
) -> None:
    (tmp_path / name).write_bytes(held)
    main = tmp_path / "main.usda"
    world = f'def Xform "World" (references = @./{name}@</World>)\n{{\n}}\n'
    main.write_text(META % "" + RENDER + world, "utf-8")
    report = linted(main)
    assert report.problems == ()
    (finding,) = report.findings
    assert (finding.rule.id, finding.severity) == ("composition-error", Severity.NOTE)
    assert "needs a plug-in of USD" in finding.message

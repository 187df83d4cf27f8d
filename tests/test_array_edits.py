"""An array may be edited instead of set: what comes of it is judged, and never takes a run down."""

from __future__ import annotations

from pathlib import Path

import pytest
from pxr import Usd

from conftest import since
from usdrender_lint.lint import lint

EDIT = '        uniform token[] includedPurposes = edit [ append "prowy" ]\n'
WEAK = '        uniform token[] includedPurposes = ["default"]\n'


def written(file: Path, statement: str, metadata: str = "") -> str:
    body = f'    def RenderSettings "S"\n    {{\n{statement}    }}\n'
    file.write_text(f'#usda 1.0\n{metadata}def Scope "Render"\n{{\n{body}}}\n', "utf-8")
    return str(file)


@pytest.mark.parametrize(
    "statement",
    [
        EDIT,
        "        int[] mine = edit [ append 1 ]\n",
        "        int[] mine.timeSamples = { 1: edit [ append 1 ] }\n",
        EDIT.replace(" = edit", ".timeSamples = { 1: edit").replace("]\n", "] }\n"),
    ],
)
def test_an_edit_of_nothing(tmp_path: Path, statement: str) -> None:
    assert lint([written(tmp_path / "main.usda", statement)], cwd=tmp_path).problems == ()


@since(26, 5)
def test_an_edit_of_what_a_weaker_layer_says(tmp_path: Path) -> None:
    written(tmp_path / "weak.usda", WEAK)
    file = written(tmp_path / "main.usda", EDIT, "(\n    subLayers = [@weak.usda@]\n)\n")
    stage = Usd.Stage.Open(file)
    assert list(stage.GetAttributeAtPath("/Render/S.includedPurposes").Get()) == [
        "default",
        "prowy",
    ]
    report = lint([file], cwd=tmp_path)
    assert report.problems == ()
    (found,) = (f for f in report.findings if f.rule.id == "unknown-purpose")
    assert "'prowy'" in found.message
    assert found.location.path == "main.usda"

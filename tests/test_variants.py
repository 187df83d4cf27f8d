"""`--variants` lints what the composed selection hides, and says where each finding holds."""

from __future__ import annotations

from pathlib import Path

import pytest

from usdrender_lint.job import Config
from usdrender_lint.lint import lint
from usdrender_lint.lint_file import MOST_VARIANTS
from usdrender_lint.registry import select
from usdrender_lint.results import Located, Report

STAGE = """\
#usda 1.0
(
    renderSettingsPrimPath = "/Render/S"
)
def Scope "Render" (
    variants = {
        string quality = "low"
    }
    prepend variantSets = "quality"
)
{
    def RenderSettings "S"
    {
        rel products = </Render/P>
    }
    def RenderProduct "P"
    {
        uniform token productType = "rastr"
        token productName = "/out/x.exr"
        rel orderedVars = </Render/v>
    }
    def RenderVar "v"
    {
        uniform string sourceName = "Ci"
    }
    variantSet "quality" = {
        "low" {
            over "S"
            {
                rel camera = </World/cam>
                uniform int2 resolution = (960, 0)
            }
        }
        "high" {
            over "S"
            {
                rel camera = </World/camera>
            }
        }
        "final" {
            over "S"
            {
                rel camera = </World/camera>
            }
        }
    }
}
def Xform "World"
{
    def Camera "cam"
    {
    }
}
"""


def lint_stage(folder: Path, text: str, *, variants: bool = True) -> Report:
    file = folder / "main.usda"
    file.write_text(text, "utf-8")
    return lint([str(file)], Config(variants=variants), cwd=folder)


def where(report: Report) -> dict[tuple[str, int], tuple[tuple[str, tuple[str, ...]], ...]]:
    return {(f.rule.id, line_of(f)): f.variants for f in report.findings}


def line_of(finding: Located) -> int:
    assert finding.location.span is not None
    return finding.location.span.line


def line_at(text: str, after: int) -> int:
    return STAGE.count("\n", 0, STAGE.index(text, after)) + 1


def test_without_the_flag_only_the_composed_selection_is_linted(tmp_path: Path) -> None:
    report = lint_stage(tmp_path, STAGE, variants=False)
    assert {f.rule.id for f in report.findings} == {"invalid-resolution", "unknown-product-type"}


def test_a_finding_says_in_which_variants_it_holds(tmp_path: Path) -> None:
    found = where(lint_stage(tmp_path, STAGE))
    low, high, final = (STAGE.index(f'"{name}" {{') for name in ("low", "high", "final"))
    assert found["invalid-resolution", line_at("(960, 0)", low)] == (
        ("/Render{quality}", ("low",)),
    )
    assert found["unresolved-target", line_at("</World/camera>", high)] == (
        ("/Render{quality}", ("high",)),
    )
    assert found["unresolved-target", line_at("</World/camera>", final)] == (
        ("/Render{quality}", ("final",)),
    )


def test_what_holds_in_all_variants_is_said_once_and_without_them(tmp_path: Path) -> None:
    report = lint_stage(tmp_path, STAGE)
    everywhere = [f for f in report.findings if f.rule.id == "unknown-product-type"]
    assert [f.variants for f in everywhere] == [()]


def test_a_finding_of_several_variants_lists_them(tmp_path: Path) -> None:
    text = STAGE.replace("uniform int2 resolution = (960, 0)", "")
    text = text.replace("rel camera = </World/cam>\n", "")
    found = where(lint_stage(tmp_path, text))
    # With "low" no camera is named; "high" and "final" name one that does not exist.
    assert found["missing-camera", line_at("RenderSettings", 0)] == (
        ("/Render{quality}", ("low",)),
    )


def test_variant_sets_of_targets_count_and_those_of_the_scene_do_not(tmp_path: Path) -> None:
    text = STAGE.partition("    variantSet")[0] + (
        "}\n"
        'def Xform "World"\n{\n'
        '    def Camera "cam" (\n        variants = {\n            string rig = "a"\n        }\n'
        '        prepend variantSets = "rig"\n    )\n    {\n'
        '        variantSet "rig" = {\n            "a" {\n            }\n'
        '            "b" (\n                active = false\n            ) {\n            }\n        }\n    }\n'
        '    def Xform "set" (\n        prepend variantSets = "look"\n    )\n    {\n'
        '        variantSet "look" = {\n            "x" {\n            }\n            "y" {\n            }\n        }\n    }\n'
        "}\n"
    )
    text = text.replace("rel products", "rel camera = </World/cam>\n        rel products")
    report = lint_stage(tmp_path, text)
    dead = [f.variants for f in report.findings if f.rule.id == "dead-target"]
    assert dead == [(("/World/cam{rig}", ("b",)),)]
    assert not any("look" in name for f in report.findings for name, _ in f.variants)


def test_the_limit_is_told_and_makes_the_run_incomplete(tmp_path: Path) -> None:
    many = "".join(f'        "v{n}" {{\n        }}\n' for n in range(MOST_VARIANTS + 2))
    text = (
        '#usda 1.0\ndef Scope "Render" (\n    variants = {\n        string q = "v0"\n    }\n'
        f'    prepend variantSets = "q"\n)\n{{\n    variantSet "q" = {{\n{many}    }}\n}}\n'
    )
    report = lint_stage(tmp_path, text)
    assert [p.kind for p in report.problems] == ["too-many-variants"]


EXPRESSION = """\
#usda 1.0
(
    expressionVariables = {
        string LOOK = "hi"
    }
)
def Scope "Render" (
    prepend variantSets = "look"
    variants = {
        string look = "`${LOOK}`"
    }
)
{
    variantSet "look" = {
        "hi" {
            def RenderSettings "S"
            {
                rel camera = </cam>
            }
        }
    }
}
def Camera "cam"
{
}
"""


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("", "", []),
        (
            '"hi"\n    }',
            '"mid"\n    }',
            ["missing-variant: </Render> selects the variant 'mid' of 'look', which does not exist: nothing of it is composed"],
        ),
        (
            "string look",
            "string lok",
            ["missing-variant: </Render> selects the variant '`${LOOK}`' of 'lok', which does not exist: nothing of it is composed"],
        ),
        (
            "string look =",
            "string lok = \"`${NONE}`\"\n        string look =",
            ["missing-variant: </Render> selects the variant '`${NONE}`' of 'lok', which does not exist: nothing of it is composed"],
        ),
        (
            "string LOOK",
            "string OTHER",
            ["composition-error: the variant selection '`${LOOK}`' on </Render> is no expression that USD can evaluate: no value for variable 'LOOK'"],
        ),
    ],
)  # fmt: skip
def test_a_selection_by_an_expression(tmp_path: Path, old: str, new: str, told: list[str]) -> None:
    file = tmp_path / "main.usda"
    file.write_text(EXPRESSION.replace(old, new))
    report = lint([str(file)], Config(select(["missing-variant", "composition-error"])), tmp_path)
    assert [f"{f.rule.id}: {f.message}" for f in report.findings] == told
    assert all(f.location.span and f.location.span.line == 10 for f in report.findings)


def test_an_expression_for_a_set_that_is_not_there_is_never_evaluated(tmp_path: Path) -> None:
    file = tmp_path / "main.usda"
    text = EXPRESSION.replace("string LOOK", "string OTHER")
    file.write_text(
        text.replace("string look =", 'string lok = "`${NONE}`"\n        string look =')
    )
    report = lint([str(file)], Config(select(["composition-error"])), tmp_path)
    assert [f.message.partition(" is no")[0] for f in report.findings] == [
        "the variant selection '`${LOOK}`' on </Render>"
    ]

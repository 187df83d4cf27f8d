"""Is exactly that silenced which a comment or metadata names, and is every idle word told?"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import pytest
from pxr import Sdf, Usd, UsdUtils, Vt

from conftest import ROOT
from usdrender_lint.__main__ import main
from usdrender_lint.job import Config
from usdrender_lint.lint import lint
from usdrender_lint.opening import open_layer
from usdrender_lint.registry import all_rules, select
from usdrender_lint.report import sarif
from usdrender_lint.results import Report, Verdict
from usdrender_lint.rule import Finding, Severity
from usdrender_lint.suppress import is_about_suppressions
from usdrender_lint.testing import BASE, HEADER
from usdrender_lint.usda import UsdaText, scan

IGNORE = "# usdrender-lint: ignore[unresolved-target]"
SUPPRESSION_RULES = {i for i, r in all_rules().items() if is_about_suppressions(r)}


def linted(folder: Path, files: Mapping[str, str | bytes], *given: str, **config: object) -> Report:
    """Write the files and lint those given, by default `main.usda`."""
    for name, text in files.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(text if isinstance(text, bytes) else text.encode())
    roots = [str(folder / name) for name in given or ("main.usda",)]
    return lint(roots, Config(**config), cwd=folder)  # type: ignore[arg-type]


def settings(lines: str, base: str = BASE) -> dict[str, str]:
    """A layer whose lines override the settings of the base."""
    indented = "".join(f"        {line}\n" for line in lines.splitlines())
    main = f'{HEADER}def Scope "Render"\n{{\n    over "Primary"\n    {{\n{indented}    }}\n}}\n'
    return {"main.usda": main, "base.usda": base}


def ids(report: Report) -> list[str]:
    assert report.problems == ()
    return [f.rule.id for f in report.findings]


def told(report: Report) -> list[str]:
    """What is reported, by rule and target."""
    assert report.problems == ()
    return [f"{f.rule.id} {f.target or ''}".strip() for f in report.findings]


def hidden(report: Report) -> list[tuple[str, str]]:
    return [(f.target or f.rule.id, f.verdict) for f in report.suppressed]


def texts(report: Report) -> list[str]:
    """The text under the caret of each finding."""
    spans = [(f.location.source or "", f.location.span) for f in report.findings]
    return [source[s.column - 1 : s.end_column - 1] if s else "" for source, s in spans]


# Comments


@pytest.mark.parametrize(
    "lines",
    [
        f"rel camera = </c> {IGNORE}",
        f"rel camera = </c>{IGNORE} because of the farm",
        f"rel camera = </c> {IGNORE}because",
        "rel camera = </c> #usdrender-lint:ignore[unresolved-target]",
        "rel camera = </c> ##\tusdrender-lint: ignore [ unresolved-target ]",
        "rel camera = </c> // usdrender-lint: ignore[unresolved-target]",
        "rel camera = </c> /* usdrender-lint: ignore[unresolved-target] */",
        "/* usdrender-lint: ignore[unresolved-target] */ rel camera = </c>",
        f"{IGNORE}\nrel camera = </c>",
        f"\t{IGNORE}\t\nrel camera = </c>",
        f"{IGNORE}\n# another comment\n// and one more\nrel camera = </c>",
        "/* usdrender-lint: ignore[unresolved-target]\n  at length */\nrel camera = </c>",
        f"rel camera = [\n  {IGNORE}\n  </c>\n]",
        f"rel camera = [\n  </c> {IGNORE}\n]",
        f'string my:a = "the # is no comment" # an umlaut: ä\nrel camera = </c> {IGNORE}',
        f'asset my:a = @#a.usda@\nstring my:b = """\n#"""\nrel camera = </c> {IGNORE}',
    ],
)
@pytest.mark.parametrize("line_break", ["\n", "\r\n"])
def test_a_comment_silences_its_line_or_alone_the_next(
    tmp_path: Path, lines: str, line_break: str
) -> None:
    files = settings(lines)
    report = linted(tmp_path, files | {"main.usda": files["main.usda"].replace("\n", line_break)})
    assert told(report) == []
    assert hidden(report) == [("/c", Verdict.BY_COMMENT)]


@pytest.mark.parametrize(
    "lines",
    [
        f"{IGNORE}\n\nrel camera = </c>",
        f"{IGNORE}\nstring my:a = ''\nrel camera = </c>",
        f"rel camera = </c>\n{IGNORE}",
        f"string my:a = '' {IGNORE}\nrel camera = </c>",
        f"/* a */ string my:a = '' {IGNORE}\nrel camera = </c>",
        f"rel camera = [\n </c>\n] {IGNORE}",
    ],
)
def test_a_comment_silences_no_other_line(tmp_path: Path, lines: str) -> None:
    report = linted(tmp_path, settings(lines))
    assert sorted(told(report)) == [
        "unresolved-target /c",
        "unused-suppression unresolved-target",
    ]
    assert report.suppressed == ()


@pytest.mark.parametrize(
    "lines",
    [
        f'string my:a = "{IGNORE}"\nrel camera = </c>',
        f'string my:a = """\n{IGNORE}"""\nrel camera = </c>',
        f"string my:a = '''\n{IGNORE}\n'''; rel camera = </c>",
        f"asset my:a = @{IGNORE}@\nrel camera = </c>",
        f"asset my:a = @@@{IGNORE}@@@; rel camera = </c>",
        "# see usdrender-lint: ignore[unresolved-target]\nrel camera = </c>",
        "# Usdrender-lint: ignore[unresolved-target]\nrel camera = </c>",
    ],
)
def test_what_is_no_comment_or_no_suppression_is_none(tmp_path: Path, lines: str) -> None:
    assert told(linted(tmp_path, settings(lines))) == ["unresolved-target /c"]


def test_one_rule_is_silenced_and_no_other(tmp_path: Path) -> None:
    lines = (
        "token renderingColorSpace = 'nonesuch' # usdrender-lint: ignore[unresolved-target]\n"
        "rel products = [\n"
        "    </Render/Beauty>,\n"
        f"    </Render/A>, {IGNORE}\n"
        "    </Render/B>,\n"
        "    </Render/C>, # usdrender-lint: ignore[missing-camera, unresolved-target]\n"
        "]\n"
    )
    report = linted(tmp_path, settings(lines))
    assert hidden(report) == [
        ("/Render/A", Verdict.BY_COMMENT),
        ("/Render/C", Verdict.BY_COMMENT),
    ]
    assert set(told(report)) == {
        "unknown-rendering-color-space",
        "unused-suppression unresolved-target",
        "unresolved-target /Render/B",
        "unused-suppression missing-camera",
    }


def test_ignore_file_silences_a_rule_in_its_layer_and_in_no_other(tmp_path: Path) -> None:
    everywhere = "usdrender-lint: ignore-file[unresolved-target] the farm adds them"
    broken = BASE.replace("</Render/Beauty>", "</Render/Gone>").replace(
        "def Xform", "\n\ndef Xform"
    )
    files = settings(f"rel camera = </c>\n# {everywhere}", broken)
    report = linted(tmp_path, files)
    assert told(report) == ["unresolved-target /Render/Gone"]
    assert hidden(report) == [("/c", Verdict.BY_COMMENT)]
    report = linted(tmp_path, {"base.usda": f"{broken}// {everywhere}"})
    assert told(report) == []


def test_the_header_is_a_line_with_a_comment_too(tmp_path: Path) -> None:
    suppressed = "#usda 1.0  # usdrender-lint: ignore[default-settings-unset] set in the shot\n"
    assert told(linted(tmp_path, {"main.usda": BASE})) == ["default-settings-unset"]
    report = linted(tmp_path, {"main.usda": BASE.replace("#usda 1.0\n", suppressed)})
    assert told(report) == []
    assert hidden(report) == [("default-settings-unset", Verdict.BY_COMMENT)]
    # And it is alone on its line no more than any other header.
    below = suppressed + BASE.replace("#usda 1.0\n", "").replace("World/main_cam", "c")
    report = linted(tmp_path, {"main.usda": below.replace("default-settings-unset", "dead-target")})
    assert "unused-suppression dead-target" in told(report)


def test_a_comment_in_a_layer_that_is_used_holds_for_the_stages_that_use_it(
    tmp_path: Path,
) -> None:
    # The finding stands in base.usda, whichever stage it is found in, and the same line of another
    # layer is another line.
    line = "        rel camera = </World/cam>"
    base = BASE.replace("        rel camera = </World/main_cam>", line)
    number = base.splitlines().index(line) + 1
    pad = "#\n" * (number - HEADER.count("\n") - 1)
    decoy = f"{HEADER}{pad}{IGNORE}\n"
    assert decoy.splitlines()[number - 1] == IGNORE
    report = linted(tmp_path, {"main.usda": decoy, "base.usda": base})
    assert (
        told(report)
        == ["unused-suppression unresolved-target", "unresolved-target /World/cam"][::-1]
    )
    silenced = base.replace(line, f"{line} {IGNORE}")
    report = linted(tmp_path, {"main.usda": HEADER, "base.usda": silenced})
    assert told(report) == []
    assert hidden(report) == [("/World/cam", Verdict.BY_COMMENT)]
    referencing = (
        '#usda 1.0\n(\n    renderSettingsPrimPath = "/Render/Primary"\n)\n'
        'def "Render" (\n    references = @base.usda@</Render>\n)\n{\n}\n'
    )
    report = linted(tmp_path, {"main.usda": referencing, "base.usda": silenced})
    assert [f.verdict for f in report.suppressed if f.rule.id == "target-outside-reference"] == []
    inside = silenced.replace("</World/cam>", "</Render/cam>")
    report = linted(tmp_path, {"main.usda": referencing, "base.usda": inside})
    assert hidden(report) == [("/Render/cam", Verdict.BY_COMMENT)]


def test_a_layer_that_does_not_parse_may_say_that_this_is_known(tmp_path: Path) -> None:
    text = (
        "#usda 1.0\n# usdrender-lint: ignore-file[syntax-error] a template\ndef Scope {{ name }}\n"
    )
    report = linted(tmp_path, {"main.usda": text})
    assert ids(report) == []
    assert hidden(report) == [("syntax-error", Verdict.BY_COMMENT)]


BAD = [
    file
    for file in sorted([*(ROOT / "fixtures" / "bad").glob("*.usda")])
    if b"@" not in file.read_bytes()  # alone, it can be copied
]


def _without_suppressions(report: Report) -> Iterator[tuple[str, str, str | None]]:
    for finding in report.findings:
        if finding.rule.id not in SUPPRESSION_RULES:
            yield finding.rule.id, finding.message, finding.target


@pytest.mark.parametrize("file", BAD, ids=[file.stem for file in BAD])
def test_a_comment_above_silences_each_finding_of_every_bad_scene(
    tmp_path: Path, file: Path
) -> None:
    """And nothing beside what the same rule says of the same line."""
    source = re.sub(r"[ \t]*# (?:at line \d+: )?(?:error|warning|note):.*", "", file.read_text())
    before = linted(tmp_path, {"main.usda": source})
    places = {(f.rule.id, f.location.span.line) for f in before.findings if f.location.span}
    assert places or not before.findings
    lines = source.splitlines(keepends=True)
    for rule, number in sorted(places):
        if number == 1:
            comment = f"# usdrender-lint: ignore[{rule}]"
            changed = [f"{lines[0].rstrip()} {comment}\n", *lines[1:]]
        else:
            comment = f"# usdrender-lint: ignore[{rule}] known\n"
            changed = [*lines[: number - 1], comment, *lines[number - 1 :]]
        after = linted(tmp_path, {"main.usda": "".join(changed)})
        remaining = [
            (f.rule.id, f.message, f.target)
            for f in before.findings
            if (f.rule.id, f.location.span and f.location.span.line) != (rule, number)
        ]
        assert sorted(map(str, _without_suppressions(after))) == sorted(map(str, remaining))
        assert {f.rule.id for f in after.suppressed} == {rule}
        assert not SUPPRESSION_RULES.intersection(f.rule.id for f in after.findings)


def test_a_header_stands_never_alone_on_its_line() -> None:
    comments = UsdaText(b"#usda 1.0 # X\n# X\n\n").comments(b"X")
    assert [(c.line, c.column, c.below) for c in comments] == [(1, 1, None), (2, 1, 3)]


# Metadata


def _data(*rules: str) -> dict[str, object]:
    return {"usdrenderLint": {"ignore": Vt.StringArray(rules)}}


NAMES = ["main.usda", "main.usdc", "main.usd", "main.usdz"]


@pytest.fixture(params=NAMES)
def scene(tmp_path: Path, request: pytest.FixtureRequest) -> tuple[Path, Sdf.Layer]:
    """A scene with one finding, about a camera, in each format; and its layer before it is saved."""
    name: str = request.param
    flat = BASE.replace(
        "#usda 1.0\n", '#usda 1.0\n(\n    renderSettingsPrimPath = "/Render/Primary"\n)\n'
    )
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(flat.replace("</World/main_cam>", "</World/cam>"))
    return tmp_path / name, layer


def _saved(file: Path, layer: Sdf.Layer) -> Report:
    if file.suffix == ".usdz":
        inner = file.with_name("inner.usdc")
        layer.Export(str(inner))
        assert UsdUtils.CreateNewUsdzPackage(str(inner), str(file))
    else:
        layer.Export(str(file))
    return lint([str(file)], Config(), cwd=file.parent)


def test_the_scene_has_one_finding(scene: tuple[Path, Sdf.Layer]) -> None:
    assert told(_saved(*scene)) == ["unresolved-target /World/cam"]


@pytest.mark.parametrize("path", ["/Render", "/Render/Primary", "/Render/Primary.camera"])
def test_metadata_holds_for_a_property_a_prim_and_what_is_below(
    scene: tuple[Path, Sdf.Layer], path: str
) -> None:
    scene[1].GetObjectAtPath(path).customData = _data("unresolved-target")
    report = _saved(*scene)
    assert told(report) == []
    assert hidden(report) == [("/World/cam", Verdict.BY_METADATA)]


def test_metadata_of_the_layer_holds_for_what_stands_in_it(scene: tuple[Path, Sdf.Layer]) -> None:
    scene[1].customLayerData = _data("unresolved-target")
    report = _saved(*scene)
    assert told(report) == []
    assert hidden(report) == [("/World/cam", Verdict.BY_METADATA)]


@pytest.mark.parametrize("path", ["/World", "/Render/Beauty", "/Render/Primary.products"])
def test_metadata_elsewhere_is_idle(scene: tuple[Path, Sdf.Layer], path: str) -> None:
    scene[1].GetObjectAtPath(path).customData = _data("unresolved-target")
    report = _saved(*scene)
    assert sorted(told(report)) == [
        "unresolved-target /World/cam",
        "unused-suppression unresolved-target",
    ]
    (idle,) = [f for f in report.findings if f.rule.id == "unused-suppression"]
    assert f"<{path}>" in idle.message
    assert f"{idle.prim_path}.{idle.property}" == (path if "." in path else f"{path}.None")
    if scene[0].suffix == ".usda":
        assert texts(report)[report.findings.index(idle)] == '"unresolved-target"'


def test_a_name_that_only_begins_alike_is_not_below(tmp_path: Path) -> None:
    prim = """\
def Scope "Render"
{
    def "Prim" (
        customData = { dictionary usdrenderLint = { string[] ignore = ["unresolved-target"] } }
    )
    {
    }
    over "Primary"
    {
        rel camera = </c>
    }
}
"""
    report = linted(tmp_path, {"main.usda": HEADER + prim, "base.usda": BASE})
    assert "unresolved-target /c" in told(report)


def test_a_member_of_a_package_speaks_for_itself(tmp_path: Path) -> None:
    files = settings("rel camera = </c>", BASE.replace("</Render/Beauty>", "</Render/Gone>"))
    linted(tmp_path, files)
    layer = Sdf.Layer.FindOrOpen(str(tmp_path / "base.usda"))
    layer.customLayerData = _data("unresolved-target")
    layer.Save()
    package = str(tmp_path / "package.usdz")
    assert UsdUtils.CreateNewUsdzPackage(str(tmp_path / "main.usda"), package)
    report = linted(tmp_path, {}, "package.usdz")
    assert told(report) == ["unresolved-target /c"]
    assert hidden(report) == [("/Render/Gone", Verdict.BY_METADATA)]


def test_every_layer_may_ignore_what_another_says(tmp_path: Path) -> None:
    """A shot silences what its library says; and neither's list replaces the other's."""
    ignoring = """\
(
    customData = {
        dictionary usdrenderLint = { RULES }
    }
)
"""
    files = settings("rel camera = </c>")
    weak = ignoring.replace("RULES", 'string[] ignore = ["unresolved-target"]')
    strong = ignoring.replace("RULES", 'token ignore = "empty-product-name"')
    base = BASE.replace('def RenderSettings "Primary"', f'def RenderSettings "Primary" {weak}')
    main = files["main.usda"].replace('over "Primary"', f'over "Primary" {strong}')
    report = linted(tmp_path, {"main.usda": main, "base.usda": base})
    assert told(report) == ["unused-suppression empty-product-name"]
    assert hidden(report) == [("/c", Verdict.BY_METADATA)]


def test_metadata_comes_through_references_and_instances(tmp_path: Path) -> None:
    library = """\
#usda 1.0
def Scope "Lib" (
    customData = { dictionary usdrenderLint = { string[] ignore = ["unresolved-target"] } }
)
{
    def RenderProduct "P"
    {
        token productName = "/a.exr"
        rel orderedVars = </Lib/gone>
    }
}
"""
    main = """\
#usda 1.0
(
    renderSettingsPrimPath = "/Render/S"
)
def Scope "Render"
{
    def RenderSettings "S"
    {
        rel camera = </cam>
        rel products = </Render/Products/P>
    }
    def "Products" (
        references = @lib.usda@</Lib>
    )
    {
    }
}
def Camera "cam"
{
}
"""
    report = linted(tmp_path, {"main.usda": main, "lib.usda": library})
    assert hidden(report) == [("/Render/Products/gone", Verdict.BY_METADATA)]
    silent = library.replace("customData", "customLayerData", 1)
    header = '#usda 1.0\n(\n    customLayerData = { dictionary usdrenderLint = { string[] ignore = ["unresolved-target"] } }\n)\n'
    plain = re.sub(r" \(\n.*\n\)", "", silent)
    for lib, root, verdicts in (
        (plain, main, []),
        (plain.replace("#usda 1.0\n", header), main, [Verdict.BY_METADATA]),
        (plain, main.replace("#usda 1.0\n(\n", header[:-2]), []),
    ):
        report = linted(tmp_path, {"main.usda": root, "lib.usda": lib})
        assert [f.verdict for f in report.suppressed] == verdicts


def test_both_of_two_suppressions_of_one_finding_are_needed(tmp_path: Path) -> None:
    """Else taking one of them out, as told, and then the other, would bring the finding back."""
    files = settings(
        f"rel camera = </c> {IGNORE}\n# usdrender-lint: ignore-file[unresolved-target]"
    )
    files["main.usda"] = files["main.usda"].replace(
        "renderSettingsPrimPath",
        'customLayerData = { dictionary usdrenderLint = { string[] ignore = ["unresolved-target"] } }\n'
        "    renderSettingsPrimPath",
    )
    report = linted(tmp_path, files)
    assert told(report) == []
    assert hidden(report) == [("/c", Verdict.BY_COMMENT)]


# Idle ones


def test_an_idle_suppression_is_told_by_rule_and_word(tmp_path: Path) -> None:
    lines = (
        "# usdrender-lint: ignore[unresolved-target, empty-product-name]\n"
        "rel camera = </c>\n"
        "# usdrender-lint: ignore-file[missing-camera] ä\n"
        "int my:a = 3 # usdrender-lint: ignore[dead-target]\n"
    )
    report = linted(tmp_path, settings(lines))
    found = [(f.message, f.prim_path, f.severity) for f in report.findings]
    assert found == [
        (
            f"'{rule}' is ignored {where}, but finds nothing there",
            "/Render/Primary",
            Severity.WARNING,
        )
        for rule, where in (
            ("empty-product-name", "on the line below"),
            ("missing-camera", "in this layer"),
            ("dead-target", "on this line"),
        )
    ]
    assert texts(report) == ["empty-product-name", "missing-camera", "dead-target"]
    assert len({f.fingerprint for f in report.findings}) == 3


def test_a_rule_that_did_not_run_makes_no_suppression_idle(tmp_path: Path) -> None:
    files = settings(
        "# usdrender-lint: ignore-file[empty-product-name, arnold-deep-product, clobbered-targets]"
    )
    assert told(linted(tmp_path, files)) == [
        "unused-suppression empty-product-name",
        "unused-suppression clobbered-targets",
    ]
    off = linted(tmp_path, settings("# usdrender-lint: ignore-file[no-render-settings]"))
    assert told(off) == ["unused-suppression no-render-settings"]
    files_of_kit = settings("# usdrender-lint: ignore-file[no-render-settings]")
    assert told(linted(tmp_path, files_of_kit, renderer="omniverse")) == []
    asked = {"no-render-settings": Severity.NOTE}
    report = linted(tmp_path, files_of_kit, renderer="omniverse", severities=asked)
    assert told(report) == ["unused-suppression no-render-settings"]
    ignored = select(ignore=["empty-product-name"])
    assert told(linted(tmp_path, files, selection=ignored)) == [
        "unused-suppression clobbered-targets"
    ]
    few = select(["unresolved-target", "unused-suppression"])
    assert told(linted(tmp_path, files, selection=few)) == []
    report = linted(tmp_path, files, renderer="arnold")
    assert "unused-suppression arnold-deep-product" in told(report)


def test_only_files_that_are_given_are_told_of(tmp_path: Path) -> None:
    files = settings("rel camera = </World/main_cam>", BASE + IGNORE)
    assert told(linted(tmp_path, files)) == []
    report = linted(tmp_path, files, "main.usda", "base.usda")
    assert told(report) == ["unused-suppression unresolved-target"]
    assert [f.location.path for f in report.findings] == ["base.usda"]


def test_it_is_needed_if_one_stage_of_the_run_needs_it(tmp_path: Path) -> None:
    shot = f'{HEADER.replace("base", "part")}def Camera "cam"\n{{\n}}\n'
    part = settings(f"rel camera = </cam> {IGNORE}")["main.usda"]
    files = {"shot.usda": shot, "part.usda": part, "base.usda": BASE}
    assert told(linted(tmp_path, files, "part.usda")) == []
    assert told(linted(tmp_path, files, "shot.usda")) == []
    both = linted(tmp_path, files, "shot.usda", "part.usda")
    assert told(both) == []
    # Through the shot there is nothing to hide; whoever lints the part alone needs it.
    assert both.suppressed == ()
    # Where the camera is there in both, nobody needs it.
    files["part.usda"] = part + 'def Camera "cam"\n{\n}\n'
    assert told(linted(tmp_path, files, "shot.usda", "part.usda")) == [
        "unused-suppression unresolved-target"
    ]


def test_it_is_needed_by_whatever_name_its_file_is_met(tmp_path: Path) -> None:
    line = "rel camera = </World/main_cam> # usdrender-lint: ignore[dead-target]"
    files = {
        "part_v2.usda": settings(line)["main.usda"],
        "base.usda": BASE,
        "shot.usda": HEADER.replace("base", "latest")
        + 'over "World"\n{\n    over "main_cam" (\n        active = false\n    )\n    {\n    }\n}\n',
    }
    (tmp_path / "latest.usda").symlink_to(tmp_path / "part_v2.usda")
    assert told(linted(tmp_path, files, "part_v2.usda")) == ["unused-suppression dead-target"]
    report = linted(tmp_path, files, "part_v2.usda", "shot.usda")
    assert told(report) == []
    assert hidden(report) == [("/World/main_cam", Verdict.BY_COMMENT)]


def test_a_finding_that_only_some_stages_ignore_is_reported_for_the_others(tmp_path: Path) -> None:
    ignoring = """\
over "Render" (
    customData = { dictionary usdrenderLint = { string[] ignore = ["unresolved-target"] } }
)
{
}
"""
    base = BASE.replace("</World/main_cam>", "</c>")
    files = {"a.usda": HEADER + ignoring, "b.usda": HEADER, "base.usda": base}
    report = linted(tmp_path, files, "a.usda", "b.usda")
    assert [(f.rule.id, f.roots) for f in report.findings] == [("unresolved-target", ("b.usda",))]
    assert [(f.rule.id, f.roots) for f in report.suppressed] == [("unresolved-target", ("a.usda",))]


VARIANTS = f"""\
#usda 1.0
(
    renderSettingsPrimPath = "/Render/S"
)
def Scope "Render" (
    variants = {{
        string quality = "low"
    }}
    prepend variantSets = "quality"
)
{{
    def RenderSettings "S"
    {{
        rel products = </Render/P>
    }}
    def RenderProduct "P"
    {{
        token productName = "/a.exr"
        rel orderedVars = </Render/v>
    }}
    def RenderVar "v"
    {{
        uniform string sourceName = "Ci"
    }}
    variantSet "quality" = {{
        "low" {{
            over "S"
            {{
                rel camera = </cam>
            }}
        }}
        "high" {{
            over "S" (
                customData = {{ dictionary usdrenderLint = {{ string[] ignore = ["dead-target"] }} }}
            )
            {{
                rel camera = </gone> {IGNORE}
                int my:a = 1 # usdrender-lint: ignore[missing-camera]
            }}
        }}
    }}
}}
def Camera "cam"
{{
}}
"""


def test_a_variant_that_nobody_selected_is_not_judged(tmp_path: Path) -> None:
    assert told(linted(tmp_path, {"main.usda": VARIANTS})) == []
    report = linted(tmp_path, {"main.usda": VARIANTS}, variants=True)
    assert told(report) == ["unused-suppression dead-target", "unused-suppression missing-camera"]
    assert hidden(report) == [("/gone", Verdict.BY_COMMENT)]
    assert report.suppressed[0].variants == (("/Render{quality}", ("high",)),)
    high = VARIANTS.replace('quality = "low"', 'quality = "high"')
    assert told(linted(tmp_path, {"main.usda": high})) == told(report)
    # Metadata within a variant holds where that is selected.
    silent = VARIANTS.replace(f"</gone> {IGNORE}", "</gone>").replace(
        '["dead-target"]', '["unresolved-target"]'
    )
    report = linted(tmp_path, {"main.usda": silent}, variants=True)
    assert hidden(report) == [("/gone", Verdict.BY_METADATA)]
    assert told(report) == ["unused-suppression missing-camera"]


def test_a_stage_with_parts_missing_makes_no_suppression_idle(tmp_path: Path) -> None:
    files = settings("# usdrender-lint: ignore[unresolved-target]")
    assert told(linted(tmp_path, files)) == ["unused-suppression unresolved-target"]
    # Whoever misses a part may be the one who needs it.
    incomplete = f'{HEADER}over "Render" (\n    references = @gone.usda@\n)\n{{\n}}\n'
    uses = {"shot.usda": incomplete.replace("base", "main")}
    report = linted(tmp_path, files | uses, "shot.usda", "main.usda")
    assert ids(report) == ["composition-error"]
    # A part that does not parse, one that is not there, and one that cannot be read.
    assert ids(linted(tmp_path, files | {"base.usda": "#usda 1.0\ndef {\n"})) == ["syntax-error"]
    (tmp_path / "base.usda").unlink()
    assert "unused-suppression" not in ids(linted(tmp_path, {"main.usda": files["main.usda"]}))
    report = linted(tmp_path, files | {"base.usda": ""})
    assert report.problems
    assert "unused-suppression" not in {f.rule.id for f in report.findings}
    # Nor does a run that met something else which it could not look at.
    report = linted(tmp_path, files | {"other.usda": ""}, "main.usda", "other.usda")
    assert report.problems
    assert report.findings == ()


def test_what_a_stronger_finding_explains_away_is_still_needed(tmp_path: Path) -> None:
    """Otherwise the suppression would be taken out, and be missed when the cause is mended."""
    files = settings("rel camera = </World/main_cam>")
    files["main.usda"] += """\
def RenderProduct "P" # usdrender-lint: ignore[product-without-vars]
{
    token productName = "/a.exr"
}
"""
    report = linted(tmp_path, files)
    assert hidden(report) == [("product-without-vars", Verdict.BY_COMMENT)]
    before = ids(report)
    files["base.usda"] += 'def RenderVar "P"\n{\n}\n'
    report = linted(tmp_path, files)
    assert sorted(ids(report)) == sorted([*before, "conflicting-prim-type"])
    assert report.suppressed == ()


def test_what_is_said_of_suppressions_can_be_silenced_too(tmp_path: Path) -> None:
    both = "int my:a = 1 # usdrender-lint: ignore[dead-target, unused-suppression] in the shot"
    above = (
        "# usdrender-lint: ignore[unused-suppression] in the shot\n"
        "# usdrender-lint: ignore[dead-target]\nint my:a = 1"
    )
    for lines in (both, above):
        report = linted(tmp_path, settings(lines))
        assert told(report) == []
        assert hidden(report) == [("dead-target", Verdict.BY_COMMENT)]
    # A suppression of this kind is never idle itself.
    idle = "# usdrender-lint: ignore-file[unused-suppression, bare-suppression]"
    assert told(linted(tmp_path, settings(idle))) == []


# What is not understood


@pytest.mark.parametrize(
    ("comment", "rule", "caret", "said"),
    [
        ("ignore", "bare", "ignore", "names no rule"),
        ("ignore-file", "bare", "ignore-file", "names no rule"),
        ("ignore the camera", "bare", "ignore", "names no rule"),
        ("ignore[]", "bare", "ignore[]", "names no rule"),
        ("ignore[ , ] a", "bare", "ignore[ , ]", "names no rule"),
        ("", "bare", "", "names no rule"),
        ("ignore[missing-camra]", "misspelled", "missing-camra", "did you mean 'missing-camera'?"),
        ("ignore-file[nonesuch]", "misspelled", "nonesuch", "--list-rules"),
        ("ignore[ALL]", "misspelled", "ALL", "stands for several rules"),
        ("ignore[default]", "misspelled", "default", "stands for several rules"),
        ("ignore[camera]", "misspelled", "camera", "stands for several rules"),
        ("ignroe[missing-camera]", "misspelled", "ignroe", "did you mean 'ignore'?"),
        ("ignore-line[missing-camera]", "misspelled", "ignore-line", "no word"),
        ("[missing-camera]", "misspelled", "[missing-camera]", "no word"),
        ("off", "misspelled", "off", "write ignore[rule-id]"),
        ("ignore[missing-camera", "misspelled", "ignore[missing-camera", "has no end"),
    ],
)
def test_what_is_not_understood_is_told_and_silences_nothing(
    tmp_path: Path, comment: str, rule: str, caret: str, said: str
) -> None:
    report = linted(
        tmp_path, settings(f"rel camera = </c> # ä usdrender-lint: x\n# usdrender-lint: {comment}")
    )
    found, silenced = report.findings[1:], report.findings[:1]
    assert [f.rule.id for f in silenced] == ["unresolved-target"]
    assert [f.rule.id for f in found] == [f"{rule}-suppression"]
    assert texts(report)[1] == caret
    assert said in f"{found[0].message} {found[0].help}"
    assert found[0].severity is Severity.WARNING


def test_a_rule_that_stands_where_a_word_belongs_silences_nothing(tmp_path: Path) -> None:
    report = linted(tmp_path, settings("rel camera = </c> # usdrender-lint: unresolved-target"))
    assert sorted(ids(report)) == ["misspelled-suppression", "unresolved-target"]


def test_metadata_silences_what_is_said_of_suppressions_below_it(tmp_path: Path) -> None:
    text = f"""\
{HEADER}def Scope "Render"
{{
    over "Primary" (
        customData = {{ dictionary usdrenderLint = {{ string[] ignore = ["unused-suppression"] }} }}
    )
    {{
        int my:a = 1 # usdrender-lint: ignore[dead-target]
    }}
    over "Primary2"
    {{
        int my:a = 1 # usdrender-lint: ignore[missing-camera]
    }}
}}
"""
    report = linted(tmp_path, {"main.usda": text, "base.usda": BASE})
    assert hidden(report) == [("dead-target", Verdict.BY_METADATA)]
    assert "unused-suppression missing-camera" in told(report)


@pytest.mark.parametrize(
    ("data", "rule", "caret", "said"),
    [
        ("dictionary usdrenderLint = { string[] ignore = [] }", "bare", "[]", "names no rule"),
        ("dictionary usdrenderLint = { string ignore = 'missing-camra' }", "misspelled", "'missing-camra'", "'missing-camera'?"),
        ("dictionary usdrenderLint = { token[] ignore = ['a', 'camera'] }", "misspelled", "'camera'", "several"),
        ("dictionary usdrenderLint = { string[] ignored = ['missing-camera'] }", "misspelled", "['missing-camera']", "mean 'ignore'?"),
        ("dictionary usdrenderLint = { int[] ignore = [1] }", "misspelled", "[1]", "no list of rules"),
        ("string usdrenderLint = 'missing-camera'", "misspelled", "'missing-camera'", "no list of rules"),
    ],
)  # fmt: skip
def test_metadata_that_is_not_understood_is_told(
    tmp_path: Path, data: str, rule: str, caret: str, said: str
) -> None:
    text = f'{HEADER}over "Render" (\n    customData = {{ {data} }}\n)\n{{\n}}\n'
    report = linted(tmp_path, {"main.usda": text, "base.usda": BASE})
    finding = report.findings[-1]
    assert finding.rule.id == f"{rule}-suppression"
    assert texts(report)[-1] == caret
    assert said in f"{finding.message} {finding.help}"


def test_a_reason_in_metadata_is_no_mistake(tmp_path: Path) -> None:
    data = 'dictionary usdrenderLint = { string[] ignore = ["unresolved-target"]; string reason = "it is" }'
    files = settings(f"rel camera = </c> (\n    customData = {{ {data} }}\n)")
    report = linted(tmp_path, files)
    assert told(report) == []
    assert hidden(report) == [("/c", Verdict.BY_METADATA)]


# What a person sees


@pytest.fixture
def show(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    files = settings(f"rel camera = </c> {IGNORE}")
    (tmp_path / "base.usda").write_text(files["base.usda"])
    (tmp_path / "main.usda").write_text(files["main.usda"])
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_what_is_ignored_fails_no_run(show: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["main.usda"]) == 0
    assert capsys.readouterr().out == "No findings in 1 file; 1 ignored.\n"
    assert main(["main.usda", "--no-ignores"]) == 1
    assert "error[unresolved-target]" in (said := capsys.readouterr().out)
    assert said.endswith("1 finding (1 error) in 1 file.\n")
    assert main(["main.usda", "missing.usda"]) == 2


def test_without_ignores_the_idle_ones_are_told_as_ever(tmp_path: Path) -> None:
    lines = f"rel camera = </c> {IGNORE}\nint my:a = 1 {IGNORE}"
    report = linted(tmp_path, settings(lines), ignores=False)
    assert told(report) == ["unresolved-target /c", "unused-suppression unresolved-target"]
    assert report.suppressed == ()


def test_machines_read_how_many_and_not_which(
    show: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["main.usda", "--output-format", "json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["findings"] == []
    assert found["summary"] == {"error": 0, "warning": 0, "note": 0, "suppressed": 1, "baseline": 0}
    report = lint(["main.usda"])
    assert report.suppressed
    assert json.loads(sarif.render(report, {}))["runs"][0]["results"] == []


def test_an_idle_suppression_fails_a_run(show: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = show / "main.usda"
    file.write_text(file.read_text().replace("</c>", "</World/main_cam>"))
    assert main(["main.usda"]) == 1
    assert main(["main.usda", "--ignore", "unused-suppression"]) == 0
    assert main(["main.usda", "--severity", "unused-suppression=note"]) == 0
    assert "note[unused-suppression]" in capsys.readouterr().out


def test_a_rule_about_suppressions_that_crashes_makes_the_run_incomplete(tmp_path: Path) -> None:
    def broken(*_: object) -> Iterator[Finding]:
        raise ZeroDivisionError

    chosen = select()
    rules = (replace(r, check=broken) if r.id == "bare-suppression" else r for r in chosen.run)
    files = settings("# usdrender-lint: ignroe[missing-camera]")
    report = linted(tmp_path, files, selection=replace(chosen, run=tuple(rules)))
    assert [f.rule.id for f in report.findings] == ["misspelled-suppression"]
    (problem,) = report.problems
    assert (problem.kind, problem.path, problem.rule) == (
        "crashed-rule",
        "main.usda",
        "bare-suppression",
    )


# Speed


def test_a_text_without_the_mark_is_not_searched_for_comments(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_: object) -> Iterator[scan.Range]:
        raise AssertionError

    monkeypatch.setattr(scan.Scan, "comments", fail)
    report = linted(tmp_path, settings("rel camera = </c> # a comment"))
    assert told(report) == ["unresolved-target /c"]
    with pytest.raises(AssertionError):
        list(UsdaText(b"#usda 1.0\n# usdrender-lint: ignore").comments(b"usdrender-lint:"))


def test_layers_without_the_key_are_not_walked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    walked = []
    monkeypatch.setattr(Sdf.Layer, "Traverse", lambda self, *_: walked.append(self.identifier))
    files = settings("rel camera = </c>")
    linted(tmp_path, files)
    stage = Usd.Stage.Open(str(tmp_path / "main.usda"))
    stage.Export(str(tmp_path / "flat.usdc"))
    assert "unresolved-target" in ids(linted(tmp_path, {}, "flat.usdc"))
    assert walked == []
    layer = open_layer(str(tmp_path / "flat.usdc"))
    assert isinstance(layer, Sdf.Layer)
    layer.GetPrimAtPath("/Render").customData = _data("unresolved-target")
    layer.Export(str(tmp_path / "said.usdc"))
    assert "unresolved-target" not in ids(linted(tmp_path, {}, "said.usdc"))
    assert len(walked) == 1


@pytest.mark.parametrize(
    "text",
    [
        b"'\"@/" * 100_000 + b"# usdrender-lint: ignore",
        b"\n# usdrender-lint: ignore" * 3_000,
        b"\n#" * 200_000 + b"\n# usdrender-lint: ignore\n/* */ int a",
        b"\n/**/" * 100_000 + b"/* usdrender-lint: ignore",
    ],
)
def test_no_text_takes_long(text: bytes) -> None:
    assert list(UsdaText(text).comments(b"usdrender-lint:"))

"""The pictures and the summary of `full`, from reports made by hand."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from usdrender_lint.model import RenderPrim
from usdrender_lint.report import full, page_url
from usdrender_lint.results import (
    Located,
    Location,
    Place,
    Problem,
    RendererChoice,
    Report,
    Span,
    Step,
)
from usdrender_lint.rule import Rule, Severity

REPOSITORY = Path("/show")
CAMERA = Span(12, 22, 34)
SGR = re.compile(r"\x1b\[[0-9;]*m")


def fake_rule(id: str, severity: Severity = Severity.ERROR) -> Rule[RenderPrim]:
    return Rule(id, RenderPrim, severity, "0.1", "", lambda subject, context: iter(()))


def at(
    path: str = "shots/render.usda",
    source: str | None = "        rel camera = </World/cam>",
    span: Span | None = CAMERA,
    member: str | None = None,
) -> Location:
    return Location(str(REPOSITORY / path), path, member, span, source)


def finding(
    location: Location | None = None,
    *,
    message: str = "camera </World/cam> does not exist",
    label: str = "no prim here",
    help: str = "",
    prim: str = "/Render/Primary",
    property: str | None = "camera",
    rule: str = "unresolved-target",
    severity: Severity = Severity.ERROR,
    related: tuple[Place, ...] = (),
    roots: tuple[str, ...] = (),
) -> Located:
    return Located(
        fake_rule(rule, severity),
        severity,
        message,
        label,
        help,
        location or at(),
        prim,
        property,
        None,
        related,
        roots,
    )


def report(
    *findings: Located,
    files: tuple[str, ...] = ("shots/render.usda",),
    problems: tuple[Problem, ...] = (),
    renderers: tuple[RendererChoice, ...] = (),
    chatter: tuple[str, ...] = (),
) -> Report:
    return Report(
        "0.1.0", (), files, findings, problems=problems, renderers=renderers, chatter=chatter
    )


def picture(one: Located, *, width: int | None = None, base: Path = REPOSITORY) -> str:
    return full.render(report(one), color=False, width=width, quiet=True, base=base)


def excerpt(source: str, column: int, end: int, width: int | None = None) -> list[str]:
    """The source line and the carets below it, without gutter."""
    text = picture(finding(at(source=source, span=Span(1, column, end)), label=""), width=width)
    return [line[5:] for line in text.splitlines()[3:]]


def test_the_picture() -> None:
    camera = at("shots/layout.usda", "", Span(40, 16, 20))
    binary = Location("/show/shots/look.usdc", "shots/look.usdc")
    text = full.render(
        report(
            finding(
                help="did you mean </World/main_cam>?",
                related=(Place("is a Camera", camera, "/World/main_cam", None),),
            ),
            finding(
                binary,
                rule="static-product-name",
                severity=Severity.WARNING,
                message="every frame writes 'beauty.exr'",
                label="no frame number",
                prim="/Render/Products/beauty",
                property="productName",
            ),
        ),
        color=False,
        base=REPOSITORY,
    )
    assert text == (
        """\
error[unresolved-target]: camera </World/cam> does not exist
  --> shots/render.usda:12:22  </Render/Primary.camera>
   |
12 |         rel camera = </World/cam>
   |                      ^^^^^^^^^^^^ no prim here
   = help: did you mean </World/main_cam>?
   = related: shots/layout.usda:40:16 </World/main_cam> is a Camera

warning[static-product-name]: every frame writes 'beauty.exr'
  --> shots/look.usdc  </Render/Products/beauty.productName>      (binary layer, no line)

2 findings (1 error, 1 warning) in 1 file.
"""
    )


def a_place(line: int, source: str, path: str = "shots/render.usda", **more: str | None) -> Place:
    span = Span(line, 1, len(source) + 1)
    return Place(f"place {line}", at(path, source, span, more.get("member")), "/X", None)


def test_a_related_place_in_another_line_is_drawn() -> None:
    one = finding(
        at(source="rel x", span=Span(8, 5, 6)),
        label="here",
        help="help",
        related=(a_place(1042, 'over "x"', "shots/layout.usda"),),
        roots=("shot.usda",),
    )
    assert (
        picture(one)
        == """\
error[unresolved-target]: camera </World/cam> does not exist
    --> shots/render.usda:8:5  </Render/Primary.camera>
     |
   8 | rel x
     |     ^ here
     = help: help
     = related: shots/layout.usda:1042:1 </X> place 1042
1042 | over "x"
     | ^^^^^^^^
     = in: shot.usda
"""
    )


def drawn(*related: Place, **more: Severity) -> list[str]:
    """The lines of source below the finding's own."""
    text = picture(finding(at(source="own", span=Span(12, 1, 4)), related=related, **more))
    return re.findall(r"^ *\d+ \| (.*)", text, re.M)[1:]


@pytest.mark.parametrize(
    ("related", "expected"),
    [
        ([a_place(13, "a")], ["a"]),
        ([a_place(12, "own")], []),
        ([a_place(12, "other", "b.usda")], ["other"]),
        ([a_place(12, "member", member="m.usda")], ["member"]),
        ([a_place(13, "a"), replace(a_place(13, "a"), message="b"), a_place(14, "b")], ["a", "b"]),
        ([a_place(n, f"{n}") for n in range(13, 20)], ["13", "14"]),
        ([Place("", at("b.usdc", None, None), "/X", None), a_place(13, "a")], ["a"]),
        ([Place("", at("b.usda", None), "/X", None)], []),
    ],
    ids=["another line", "the same", "file", "member", "twice", "many", "binary", "no source"],
)
def test_few_related_places_are_drawn_and_no_line_twice(
    related: list[Place], expected: list[str]
) -> None:
    assert drawn(*related) == expected


@pytest.mark.parametrize("severity", list(Severity))
def test_a_note_stays_short(severity: Severity) -> None:
    shown = drawn(a_place(13, "a"), severity=severity)
    assert shown == ([] if severity is Severity.NOTE else ["a"])


def test_the_name_of_a_rule_leads_to_its_page() -> None:
    made = report(finding())
    linked = full.render(made, color=True, links=True)
    url = page_url("unresolved-target")
    link = f"\x1b]8;;{url}\x1b\\unresolved-target\x1b]8;;\x1b\\"
    assert linked == full.render(made, color=True).replace("unresolved-target", link)
    assert linked.startswith(f"\x1b[1;31merror[{link}]\x1b[0m")


def test_the_gutter_grows_with_the_line_number() -> None:
    one = finding(at(source="active = false", span=Span(1042, 1, 7)), help="remove it")
    assert (
        picture(one)
        == """\
error[unresolved-target]: camera </World/cam> does not exist
    --> shots/render.usda:1042:1  </Render/Primary.camera>
     |
1042 | active = false
     | ^^^^^^ no prim here
     = help: remove it
"""
    )


def test_a_small_line_number_stands_at_the_right() -> None:
    assert " 1 | over" in picture(finding(at(source="over", span=Span(1, 1, 5))))


def test_what_a_layer_says_about_itself_has_no_prim() -> None:
    one = finding(at(source="(", span=Span(2, 1, 2)), prim="/", property=None)
    assert "  --> shots/render.usda:2:1\n" in picture(one)


def test_a_place_without_its_source_is_not_drawn() -> None:
    assert "^" not in picture(finding(at(source=None)))


@pytest.mark.parametrize(
    ("location", "expected"),
    [
        (at("c.usdz", member="sub/a.usda"), "  --> c.usdz[sub/a.usda]:12:22  <"),
        (at("c.usdz", None, None, "sub/a.usdc"), "(binary layer, no line)\n"),
        (at("c.usdz", None, None, "sub/a.usda"), "      (no line)\n"),
    ],
)
def test_packages(location: Location, expected: str) -> None:
    assert expected in picture(finding(location))


@pytest.mark.parametrize(
    ("base", "expected"),
    [
        ("/show", "shots/render.usda:12:22"),
        ("/show/shots", "render.usda:12:22"),
        ("/show/assets", "shots/render.usda:12:22"),
        ("/", "show/shots/render.usda:12:22"),
    ],
)
def test_paths_are_relative_to_where_one_stands(base: str, expected: str) -> None:
    assert f"--> {expected}  <" in picture(finding(), base=Path(base))


def test_the_current_directory_is_the_base(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    location = Location(str(Path.cwd() / "a" / "b.usdc"), "deep/a/b.usdc")
    assert "--> a/b.usdc  <" in full.render(report(finding(location)), color=False)


@pytest.mark.parametrize(
    ("roots", "base", "expected"),
    [
        ((), "/show", None),
        (("shots/render.usda",), "/show", None),
        (("shots/shot.usda",), "/show", "shots/shot.usda"),
        (("shots/shot.usda",), "/show/shots", "shot.usda"),
        (("shots/render.usda", "b.usda"), "/show", "shots/render.usda, b.usda"),
        (("a.usda", "b.usda", "c.usda"), "/show", "a.usda, b.usda, c.usda"),
        (("a", "b", "c", "d", "e"), "/show", "a, b, c and 2 more"),
        (("/elsewhere/a.usda",), "/show", "/elsewhere/a.usda"),
    ],
)
def test_roots(roots: tuple[str, ...], base: str, expected: str | None) -> None:
    lines = picture(finding(roots=roots), base=Path(base)).splitlines()
    told = [line.removeprefix("   = in: ") for line in lines if line.startswith("   = in: ")]
    assert told == ([expected] if expected else [])


@pytest.mark.parametrize(
    ("roots", "expected"),
    [
        (("shots/shot.usda",), "shot.usda -> (sublayer) light.usdz[a.usda] -> (reference) b.usda"),
        # Each comes another way.
        (("shots/shot.usda", "shots/x.usda"), "shot.usda, x.usda"),
    ],
)
def test_the_way_from_the_root(roots: tuple[str, ...], expected: str) -> None:
    chain = (Step("sublayer", "shots/light.usdz[a.usda]"), Step("reference", "shots/b.usda"))
    one = replace(finding(roots=roots), chain=chain)
    shown = picture(one, base=REPOSITORY / "shots")
    assert f"   = in: {expected}\n" in shown


def test_roots_of_a_layer_outside_of_the_repository() -> None:
    location = Location("/elsewhere/a.usda", "/elsewhere/a.usda")
    assert "   = in: b.usda\n" in picture(finding(location, roots=("b.usda",)))


@pytest.mark.parametrize(
    "text",
    ["inputs:camera:exposure", "c.usdz[sub/a.usda]", "[/Render/X]", "[bold]x[/bold]", "a\\b"],
)
@pytest.mark.parametrize("color", [False, True])
def test_names_arrive_unchanged(text: str, color: bool) -> None:
    one = finding(at(source=text, span=Span(1, 1, 2)), message=text, label=text, help=text)
    shown = SGR.sub("", full.render(report(one), color=color, quiet=True))
    assert f"]: {text}\n" in shown
    assert f" | {text}\n" in shown
    assert f"^ {text}\n" in shown
    assert f"= help: {text}\n" in shown


@pytest.mark.parametrize(
    ("source", "column", "end", "drawn", "carets"),
    [
        ("rel camera", 5, 11, "rel camera", "    ^^^^^^"),
        ("\t\trel camera", 7, 13, "        rel camera", "            ^^^^^^"),
        ("a\tb", 2, 3, "a    b", " ^^^^"),
        ('name = "日本" x', 8, 12, 'name = "日本" x', "       ^^^^^^"),
        ('"日本" x', 6, 7, '"日本" x', "       ^"),
        ("e\u0301e\u0301 x", 6, 7, "e\u0301e\u0301 x", "   ^"),
        ("e\u0301 x", 2, 3, "e\u0301 x", " ^"),
        ("\x1b[31m x", 7, 8, "\\x1b[31m x", "         ^"),
        ("rel", 4, 5, "rel", "   ^"),
        ("rel", 90, 99, "rel", "   ^"),
        ("rel", 2, 2, "rel", " ^"),
        ("rel\r\n", 1, 4, "rel", "^^^"),
        ("", 1, 1, "", "^"),
    ],
    ids=[
        "plain",
        "tabs before",
        "tab inside",
        "wide inside",
        "wide before",
        "combining before",
        "combining itself",
        "escape before",
        "end of line",
        "beyond the line",
        "empty span",
        "line break left",
        "empty line",
    ],
)
def test_carets_stand_below_the_span(
    source: str, column: int, end: int, drawn: str, carets: str
) -> None:
    assert excerpt(source, column, end) == [drawn, carets]


LONG = "".join(f"<{n:03}>" for n in range(100))
"""500 code points, `<100>` never among them."""


@pytest.mark.parametrize("width", [None, 40, 80, 10, 1])
@pytest.mark.parametrize("column", [1, 6, 251, 496])
def test_long_lines_are_cut_around_the_span(column: int, width: int | None) -> None:
    source, carets = excerpt(LONG, column, column + 5, width)
    assert len(source) <= max(width or full.PIPED_WIDTH, 25) - 5
    assert source.startswith("...") is (column > 100)
    assert source.endswith("...") is (column < 400)
    start = carets.index("^")
    assert source[start : start + carets.count("^")] == f"<{column // 5:03}>"


def test_a_line_that_just_fits_is_whole() -> None:
    assert excerpt("x" * 75, 1, 2, width=80)[0] == "x" * 75
    assert excerpt("x" * 76, 1, 2, width=80)[0] == "x" * 69 + "..."


def test_a_span_longer_than_the_screen_shows_its_beginning() -> None:
    source, carets = excerpt(LONG, 11, 400, width=45)
    assert source == "..." + LONG[10:44] + "..."
    assert carets == "   " + "^" * 34


def test_wide_characters_are_cut_by_cells() -> None:
    source, carets = excerpt("日" * 100, 50, 51, width=45)
    assert source == "..." + "日" * 17 + "..."
    assert carets == " " * 19 + "^^"


def test_a_line_of_megabytes_takes_no_time() -> None:
    source, _ = excerpt("(0, 0, 0), " * 1_000_000, 5_000_000, 5_000_001)
    assert len(source) == full.PIPED_WIDTH - 5


HOSTILE = "a\x1b[2J\nb\r\x07\x9b31m\u202e\u2028\udc80\x00"
HARMLESS = r"a\x1b[2J\nb\r\x07\x9b31m\u202e\u2028\udc80\x00"


def hostile_report() -> Report:
    location = Location("/show/x", f"{HOSTILE}.usda", HOSTILE, Span(1, 1, 2), HOSTILE)
    return report(
        finding(
            location,
            message=HOSTILE,
            label=HOSTILE,
            help=HOSTILE,
            prim=HOSTILE,
            property=HOSTILE,
            related=(
                Place(HOSTILE, location, HOSTILE, HOSTILE),
                Place(HOSTILE, replace(location, span=Span(2, 1, 2)), HOSTILE, HOSTILE),
            ),
            roots=(HOSTILE,),
        ),
        problems=(Problem("unreadable-file", HOSTILE, HOSTILE),),
        renderers=(RendererChoice(HOSTILE, HOSTILE, HOSTILE), RendererChoice("b", "any", HOSTILE)),
        chatter=(HOSTILE,),
    )


@pytest.mark.parametrize("color", [False, True])
def test_nothing_reaches_the_terminal_but_text(color: bool) -> None:
    hostile = hostile_report()
    text = full.render(hostile, color=color, verbose=True) + full.problems(hostile, color)
    plain = SGR.sub("", text)
    assert HARMLESS in plain
    assert plain.replace("\n", "").isprintable()
    assert color or plain == text
    text.encode("utf-8")


def test_every_color_is_closed_on_its_line() -> None:
    hostile = hostile_report()
    text = full.render(hostile, color=True, verbose=True) + full.problems(hostile, True)
    assert SGR.search(text)
    for line in text.splitlines():
        codes = SGR.findall(line)
        assert codes[1::2] == ["\x1b[0m"] * (len(codes) // 2)
        assert "\x1b[0m" not in codes[::2]


def test_color_changes_no_text() -> None:
    one = report(finding(help="help"), finding(at("a.usdc", None, None)))
    assert SGR.sub("", full.render(one, color=True)) == full.render(one, color=False)


def test_unicode_changes_gutter_and_cut() -> None:
    one = report(finding(at(source=LONG, span=Span(1, 1, 6))))
    text = full.render(one, color=False, unicode=True, width=40)
    assert " 1 │ <000>" in text
    assert "…\n" in text


@pytest.mark.parametrize(
    ("made", "expected"),
    [
        (report(), "No findings in 1 file.\n"),
        (report(files=("a", "b")), "No findings in 2 files.\n"),
        (report(finding()), "1 finding (1 error) in 1 file.\n"),
        (
            report(
                finding(severity=Severity.NOTE),
                finding(),
                finding(),
                finding(severity=Severity.WARNING),
                files=("a", "b", "c"),
            ),
            "4 findings (2 errors, 1 warning, 1 note) in 3 files.\n",
        ),
    ],
)
def test_summary(made: Report, expected: str) -> None:
    assert full.summary(made) == expected
    assert full.render(made, color=False).endswith(expected)


def test_quiet_is_silent_without_findings() -> None:
    assert full.render(report(), color=False, quiet=True) == ""


MISSING = Problem("missing-path", "x.usda", "does not exist")
BROKEN = Problem("unreadable-file", "a.usdc", "is empty")
CRASHED = Problem("crashed-rule", "a.usda", "KeyError: 'x'", rule="orphan-var")


@pytest.mark.parametrize(
    ("problems", "expected"),
    [
        ((BROKEN,), "1 error kept 1 file from being linted"),
        ((BROKEN, BROKEN), "2 errors kept 1 file from being linted"),
        ((BROKEN, MISSING), "2 errors kept 2 paths from being linted"),
        ((CRASHED,), "1 rule failed on 1 file"),
        ((BROKEN, CRASHED), "1 error kept 1 file from being linted and 1 rule failed on 1 file"),
    ],
)
def test_an_incomplete_run_ends_by_saying_so(problems: tuple[Problem, ...], expected: str) -> None:
    assert full.summary(report(problems=problems)) == (
        f"No findings in 1 file.\nThe run is incomplete: {expected} (see above).\n"
    )


def test_a_run_that_looked_at_nothing_does_not_sound_clean() -> None:
    assert full.summary(report(files=())) == "Nothing was linted.\n"


def test_problems() -> None:
    made = report(problems=(BROKEN, Problem("crashed-usd", "", "out of memory")))
    assert full.problems(made, False) == "error: a.usdc: is empty\nerror: out of memory\n"
    assert full.problems(report(), False) == ""


ANY = RendererChoice("a.usda", "any", "no evidence")
KIT = RendererChoice("b.usda", "omniverse", "/Render/OmniverseKit is Kit's")
KIT_TOO = RendererChoice("c.usda", "omniverse", "omni: namespace.")


@pytest.mark.parametrize(
    ("renderers", "expected"),
    [
        ((ANY,), None),
        ((KIT,), "Judged as omniverse: /Render/OmniverseKit is Kit's."),
        ((KIT, KIT), "Judged as omniverse: /Render/OmniverseKit is Kit's."),
        ((KIT, KIT_TOO), "Judged as omniverse; -v says why."),
        ((ANY, KIT, KIT_TOO), "Judged as any (1 file) and omniverse (2 files); -v says why."),
    ],
)
def test_the_judge_is_named(renderers: tuple[RendererChoice, ...], expected: str | None) -> None:
    lines = full.summary(report(renderers=renderers)).splitlines()
    assert lines[1:] == ([expected] if expected else [])


def test_verbose_tells_every_reason_and_what_usd_said() -> None:
    made = report(renderers=(ANY, KIT_TOO), chatter=("Warning: in x\nat y",))
    assert (
        full.summary(made, verbose=True)
        == """\
USD: Warning: in x
USD: at y
a.usda: judged as any: no evidence.
c.usda: judged as omniverse: omni: namespace.
No findings in 1 file.
Judged as any (1 file) and omniverse (1 file); -v says why.
"""
    )


def test_rich_is_not_imported() -> None:
    code = (
        "import sys; from usdrender_lint.report import concise, full, explain; "
        "from usdrender_lint.results import Report; "
        "full.render(Report('', (), (), ()), color=True); "
        "explain.render('', color=False, width=80); "
        "print({'rich', 'unicodedata'} & sys.modules.keys())"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout == "set()\n"

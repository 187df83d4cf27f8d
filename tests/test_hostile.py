"""What nobody means to hand over, and everybody does once: told in a sentence, and nothing waits,
raises, passes or is overwritten."""

from __future__ import annotations

import os
import subprocess
import sys
import zlib
from collections.abc import Callable
from pathlib import Path

import pytest
from pxr import Sdf, Usd

from usdrender_lint.lint import lint
from usdrender_lint.results import Report

BODY = """\
def Scope "Render"
{
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
}
def Xform "World"
{
    def Camera "cam"
    {
    }
}
"""
META = '#usda 1.0\n(\n    renderSettingsPrimPath = "/Render/S"\n%s)\n'
WHOLE = META % "" + BODY
DAMAGED = b"\0" * 4096
POSIX = pytest.mark.skipif(os.name == "nt", reason="pipes and devices")


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path(".git").mkdir()


def linted(held: bytes | str, name: str = "main.usda") -> Report:
    Path(name).write_bytes(held if isinstance(held, bytes) else held.encode())
    return lint([name])


def said(report: Report) -> list[str]:
    """Errors, and findings with their places."""
    found = [p.message for p in report.problems]
    for one in report.findings:
        span = one.location.span
        at = f"{span.line}:{span.column}: " if span else ""
        found.append(f"{at}{one.message}")
    return found


def run(*args: str) -> tuple[int, str]:
    command = [sys.executable, "-m", "usdrender_lint", *args]
    done = subprocess.run(command, capture_output=True, timeout=60, stdin=subprocess.DEVNULL)
    assert b"Traceback" not in done.stderr
    return done.returncode, done.stderr.decode()


TEXT = WHOLE.encode()
FORMATS: list[tuple[str, bytes, str]] = [
    ("a.usda", DAMAGED, "begins with nothing but zero bytes"),
    ("a.usdc", DAMAGED, "begins with nothing but zero bytes"),
    ("a.usdz", DAMAGED, "begins with nothing but zero bytes"),
    ("a.usda", TEXT + DAMAGED, "a zero byte stands in its text, in line 28"),
    ("a.usda", WHOLE.encode("utf-32"), "UTF-32 text"),
    ("a.usda", WHOLE.encode("utf-32-be"), "UTF-32 text"),
    ("a.usda", WHOLE.encode("utf-16"), "UTF-16 text"),
    ("a.usd", b"\x1f\x8b" + zlib.compress(TEXT), "packed by gzip"),
    ("a.usd", b"<html><body>504</body></html>", "holds neither usda text"),
    (".usda", TEXT, "its name is an ending alone"),
    ("a:SDF_FORMAT_ARGS:b.usda", TEXT, "its name holds ':SDF_FORMAT_ARGS:'"),
]


@pytest.mark.parametrize(("name", "held", "told"), FORMATS)
def test_what_is_no_layer(name: str, held: bytes, told: str) -> None:
    if os.name == "nt" and ":" in name:
        pytest.skip("no such name")
    report = linted(held, name)
    (problem,) = report.problems
    assert told in problem.message
    assert not report.files


HEADERS = [
    ("../real/main.usda", "1:1: it holds the path of another file"),
    ("<<<<<<< HEAD\n#usda 1.0\n", "1:1: a merge conflict is left here, found '<<<<<<<'"),
    (WHOLE.replace("\n", "\r"), "1:1: its lines end in carriage returns alone"),
    (WHOLE.replace("1.0", "0.9"), "1:1: it is written for usda 0.9, and USD reads none older"),
    (WHOLE.replace("1.0", "9.0"), "1:1: it is written for usda 9.0, and USD reads none later"),
    (WHOLE.replace("1.0", "one"), "1:1: the first line is not '#usda 1.0'"),
    (WHOLE.replace(" 1.0", ""), "1:1: the first line is not '#usda 1.0'"),
]


@pytest.mark.parametrize(("text", "told"), HEADERS)
def test_a_first_line_that_usd_does_not_read(text: str, told: str) -> None:
    (one,) = said(linted(text))
    assert one.startswith(told)


STATEMENTS = {
    "\x0c": "9:9: '\\x0c' stands here, a control character",
    "int2 resolution = (4294967296, 1)": "9:27: a number in the value does not fit its type",
    'token[] x:a = ["a", 1]': "9:23: element 2 of the value does not fit its type",
    "int2 resolution = [(1, 2)]": "9:27: the value is a list, and its type has no brackets",
    "rel resolution = </World>\nint2 resolution = (1, 2)": "10:6: the attribute 'resolution' is "
    "declared twice, once as uniform and once not",
    "int2 x:a.spline = { 1: 2 }": "9:18: a spline holds single numbers, and none of this type",
    "asset x:a = @a\x1b@": "9:23: an asset path holds a control character",
    "dictionary a = { }": "9:9: no attribute is a dictionary",
    'token \U0001f600 = "x"': "9:15: '\U0001f600' is no name of a property",
}


@pytest.mark.parametrize(("statement", "told"), STATEMENTS.items())
def test_a_statement_that_usd_does_not_read(statement: str, told: str) -> None:
    text = WHOLE.replace("        rel camera", f"        {statement}\n        rel camera")
    (one,) = said(linted(text))
    assert one.startswith(told)
    assert "Sdf" not in one
    assert "Gf" not in one


def test_a_target_within_a_property_of_another_path() -> None:
    """USD gives no object for it, and one that raises where it is asked whether it is defined."""
    report = linted(WHOLE.replace("</World/cam>", "</World.a[/x].b>", 1))
    assert not report.problems
    assert any("camera" in one for one in said(report))


ARCS = {
    "./": "4:18: the sublayer @./@ leads to a folder",
    "b.usda:SDF_FORMAT_ARGS:a=b": "4:18: the sublayer @b.usda:SDF_FORMAT_ARGS:a=b@ leads to no file",
    "main.usda:SDF_FORMAT_ARGS:target=x": "USD cannot open it with the arguments behind its name "
    "(brought in by main.usda)",
    "`5`": "4:18: the sublayer @`5`@ is no expression that USD can evaluate: it comes to something "
    "else than a string",
}


@pytest.mark.parametrize(("asset", "told"), ARCS.items())
def test_a_sublayer_that_is_none(asset: str, told: str) -> None:
    report = linted(META % f"    subLayers = [@{asset}@]\n" + BODY)
    assert said(report) == [told]
    assert report.problems or any(map(report.fails, report.findings))


RELOCATES = {
    "</World/cam> : </World/cam>": "the relocation of </World/cam> is ignored: ",
    "</World> : </Set>": "the relocation of </World> is ignored: ",
    "</World/a> : </World/c>, </World/b> : </World/c>": "the relocation of </World/a> is ignored: "
    "other prims are relocated to the same path",
}


@pytest.mark.parametrize(("entries", "told"), RELOCATES.items())
def test_a_relocation_that_usd_passes_over_is_told_at_its_place(entries: str, told: str) -> None:
    report = linted(META % f"    relocates = {{ {entries} }}\n" + BODY)
    assert [one.startswith(f"4:17: {told}") for one in said(report)] == [True]


def test_a_relocated_prim_is_not_advised_at_its_old_path() -> None:
    report = linted(META % "    relocates = { </World/cam> : </World/moved> }\n" + BODY)
    (finding,) = report.findings
    assert finding.rule.id == "unresolved-target"
    assert "did you mean </World/cam>" not in (finding.help or "")


def test_sublayers_a_thousand_deep() -> None:
    for number in range(1200):
        Path(f"s{number}.usda").write_text(
            f"#usda 1.0\n(\n    subLayers = [@s{number + 1}.usda@]\n)\n"
        )
    report = linted(META % "    subLayers = [@s0.usda@]\n" + BODY)
    assert said(report) == ["3:18: the sublayer @s1200.usda@ leads to no file"]


def test_a_target_of_ten_thousand_names_takes_no_time() -> None:
    asked: list[Sdf.Path] = []

    class Stage:
        def GetPrimAtPath(self, path: Sdf.Path) -> Usd.Prim:  # noqa: N802 as USD calls it
            asked.append(path)
            return stage.GetPrimAtPath(path)

        def GetPseudoRoot(self) -> Usd.Prim:  # noqa: N802 as USD calls it
            return stage.GetPseudoRoot()

    from usdrender_lint.read.targets import Targets

    stage = Usd.Stage.CreateInMemory()
    stage.DefinePrim("/a/a")
    targets = Targets.__new__(Targets)
    targets._stage = Stage()
    nearest = targets._nearest(Sdf.Path("/a" * 10_000))
    assert nearest.GetPath() == Sdf.Path("/a/a")
    assert len(asked) == 3


def test_names_of_a_million_letters_are_likened_to_none() -> None:
    from usdrender_lint.likeness import closest, is_like, likeness

    long = "n" * 1_000_000
    assert likeness(long, "name") == 0
    assert likeness(long, long.upper()) == 1
    assert not is_like(long, "n", 0.1)
    assert closest(long, ["name"]) is None
    assert closest("name", [long, "names"]) == "names"


def test_a_member_is_no_path_of_its_own() -> None:
    Path("main.usda").write_text(WHOLE)
    with Sdf.ZipFileWriter.CreateNew("shot.usdz") as writer:
        writer.AddFile("main.usda", "main.usda")
    for member in ("main.usda", "none.usda"):
        (problem,) = lint([f"shot.usdz[{member}]"]).problems
        assert problem.message == "a member of a package is linted with all of it: name shot.usdz"


def test_of_thousands_of_complaints_the_first_tells_the_place() -> None:
    nested = "(" * 2000 + ")" * 2000
    text = WHOLE.replace("        rel camera", f"        float x = {nested}\n        rel camera", 1)
    (one,) = said(linted(text))
    assert one.startswith("9:2019: ")


def test_each_of_many_sublayers_is_found_in_one_look(monkeypatch: pytest.MonkeyPatch) -> None:
    from usdrender_lint.usda.scan import Scan

    looks = []
    metadata = Scan.metadata
    monkeypatch.setattr(Scan, "metadata", lambda *args: looks.append(args) or metadata(*args))
    names = [f"s{number}.usda" for number in range(50)]
    assets = ", ".join(f"@{name}@" for name in names)
    report = linted(META % f"    subLayers = [{assets}]\n" + BODY)
    columns = [f.location.span.column for f in report.findings if f.location.span]
    assert len(set(columns)) == len(names)
    assert len(looks) < 10


# Beside the layers


@POSIX
@pytest.mark.parametrize(
    ("prepare", "args", "told"),
    [
        (lambda: os.mkfifo("usdrender-lint.toml"), [], "a named pipe, not a file"),
        (lambda: Path("usdrender-lint.toml").symlink_to("/dev/zero"), [], "it has no end"),
        (lambda: _configured('extend = "/dev/zero"'), [], "it has no end"),
        (lambda: (_configured('extend = "p"'), os.mkfifo("p")), [], "a named pipe, not a file"),
        (lambda: _configured(f"select = {'9' * 5000}"), [], "a number in it is too long"),
        (lambda: _configured('baseline = "/dev/zero"'), [], "it has no end"),
        (lambda: None, ["--config", "/dev/zero"], "it has no end"),
        (lambda: None, ["--baseline", "/dev/zero"], "it has no end"),
        (lambda: None, ["--files-from", "/dev/zero"], "it has no end"),
        (lambda: None, ["--files-from", ""], "'' names no file"),
        (lambda: None, ["--output-file", "new/"], "'new/' names no file"),
        (lambda: None, ["--output-file", "a" * 300 + ".json"], "cannot be written"),
        (lambda: Path("b.json").write_text("9" * 5000), ["--baseline", "b.json"], "too long"),
    ],
)
def test_what_has_no_end_or_makes_no_sense(
    prepare: Callable[[], object], args: list[str], told: str
) -> None:
    Path("main.usda").write_text(WHOLE)
    prepare()
    code, heard = run(*args, "main.usda")
    assert code == 2
    assert told in heard


def _configured(text: str) -> None:
    Path("usdrender-lint.toml").write_text(text)


def test_a_long_chain_of_configurations() -> None:
    Path("main.usda").write_text(WHOLE)
    _configured('extend = "0.toml"')
    for number in range(500):
        Path(f"{number}.toml").write_text(f'extend = "{number + 1}.toml"')
    code, heard = run("main.usda")
    assert code == 2
    assert "more than 64 files extend each other" in heard


@POSIX
@pytest.mark.parametrize(
    "prepare",
    [
        lambda: os.mkfifo(".gitignore"),
        lambda: Path(".gitignore").symlink_to("/dev/zero"),
        lambda: Path(".gitignore").write_text("a" * 1_000_000),
        lambda: (Path(".git").rmdir(), Path(".git").write_bytes(b"\0\xff")),
    ],
)
def test_git_passes_over_what_it_cannot_read(prepare: Callable[[], object]) -> None:
    Path("main.usda").write_text(WHOLE)
    prepare()
    assert run(".")[0] == 0


@pytest.mark.parametrize("option", ["--output-file", "--baseline"])
def test_a_link_to_a_scene_is_not_written_through(option: str) -> None:
    Path("main.usda").write_text(WHOLE)
    try:
        Path("report.json").symlink_to("main.usda")
    except OSError:
        pytest.skip("no links here")
    update = ["--update-baseline"] if option == "--baseline" else []
    code, heard = run(option, "report.json", *update, "main.usda")
    assert code == 2
    assert "is a link to a USD file" in heard
    assert Path("main.usda").read_text() == WHOLE


def test_a_root_that_cannot_be_read_may_use_the_layer() -> None:
    """So nobody may say that none uses it."""
    from usdrender_lint.config.find import Configurations
    from usdrender_lint.context import not_used, planned
    from usdrender_lint.discover import Shown, discover

    Path("layer.usda").write_text(WHOLE)
    Path("shot.usda").write_bytes(DAMAGED)
    shown = Shown(Path.cwd())
    given = discover(["layer.usda"], shown, Configurations()).files
    plan = planned(given, ["shot.usda"], ["/Render"], Path.cwd(), shown)
    read = [("layer.usda",), ("shot.usda",)]
    unread: list[tuple[str, ...]] = [("layer.usda",), ()]
    assert [t.shown for t in plan.targets] == ["layer.usda", "shot.usda"]
    assert list(not_used(plan, unread, shown)) == []
    assert list(not_used(plan, read, shown)) != []

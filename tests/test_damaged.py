"""What USD opens although it is damaged is told as that: no crash of ours, and no false green."""

from __future__ import annotations

import re
import struct
import subprocess
import sys
from pathlib import Path

import pytest
from pxr import Sdf, Tf, Usd

from conftest import ROOT
from usdrender_lint import lint_file
from usdrender_lint.lint import lint
from usdrender_lint.model import Site, State, Target
from usdrender_lint.read import read
from usdrender_lint.read.crate_types import crate_types
from usdrender_lint.read.members import member
from usdrender_lint.read.specs import there
from usdrender_lint.read.text import Texts
from usdrender_lint.results import Report
from usdrender_lint.stage import open_stage
from usdrender_lint.torn import torn_among
from usdrender_lint.unopened import DamagedError

SCENE = (ROOT / "fixtures" / "formats" / "scene.usdc").read_bytes()
OPENS = "USD opens it, and it is damaged: "


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def patched(at: int, value: int) -> bytes:
    data = bytearray(SCENE)
    data[at] = value
    return bytes(data)


def linted(data: bytes) -> Report:
    Path("a.usdc").write_bytes(data)
    return lint(["a.usdc"])


def told(report: Report) -> list[tuple[str, str]]:
    assert not report.files
    return [(p.kind, p.message) for p in report.problems]


def torn(by: int) -> bytes:
    """The table of tokens announces more bytes than it holds."""
    data = bytearray(SCENE)
    contents = struct.unpack_from("<q", data, 16)[0]
    for number in range(data[contents]):
        name, start, _ = struct.unpack_from("<16sqq", data, contents + 8 + 32 * number)
        if name.startswith(b"TOKENS"):
            size = struct.unpack_from("<Q", data, start + 8)[0]
            struct.pack_into("<Q", data, start + 8, size + by)
    return bytes(data)


@pytest.mark.parametrize("by", [1, 100])
@pytest.mark.parametrize(
    "name", ["a.usdc", "a.usd", "a.usdz", "b.usdz[x/a.usdc]", "c.usdz[a.usdz]"]
)
def test_a_table_of_names_that_is_shorter_than_it_says(name: str, by: int) -> None:
    """USD takes for names what its memory holds behind them: it may refuse the crate or open it."""
    file, inside = name.partition("[")[0], name.endswith("]")
    for data, is_torn in ((SCENE, False), (torn(by), True)):
        Path("a.usdc").write_bytes(data)
        if name == "a.usd":
            Path("a.usd").write_bytes(data)
        if inside or name == "a.usdz":
            with Sdf.ZipFileWriter.CreateNew("a.usdz") as writer:
                writer.AddFile("a.usdc", "a.usdc")
        if inside:
            Path("first.usda").write_text("#usda 1.0\n(subLayers = [@./x/a.usdc@])\n")
            with Sdf.ZipFileWriter.CreateNew(file) as writer:
                if file == "b.usdz":
                    writer.AddFile("first.usda", "first.usda")
                    writer.AddFile("a.usdc", "x/a.usdc")
                else:
                    writer.AddFile("a.usdz", "a.usdz")
        assert [one.file for one in torn_among([name, ""])] == ([name] if is_torn else [])
        for root in (file, "over.usda"):
            Path("over.usda").write_text(f"#usda 1.0\n(subLayers = [@./{file}@])\n")
            report = lint([root])
            assert report.complete is not is_torn
            assert len(report.problems) == is_torn  # told once, however USD takes it


def test_a_sublayer_that_opens_only_when_it_is_looked_at_again() -> None:
    """Somebody was still writing it. What it holds is missing from what was linted."""
    Path("shot.usda").write_text("#usda 1.0\n(subLayers = [@./late.usda@, @./missing.usda@])\n")
    Path("late.usda").write_text('#usda 1.0\ndef Scope "Render" {')
    opened = open_stage(Sdf.Layer.FindOrOpen("shot.usda"), ("/Render",))
    Path("late.usda").write_text("#usda 1.0\n")
    scope = read(opened, Texts())
    assert [(Path(one.file).name, one.message) for one in opened.unreadable] == [
        (
            "late.usda",
            "USD refused it when it composed the stage, and opens it now: it was being written, or it is damaged",
        )
    ]
    assert [(error.kind, error.asset) for error in scope.errors] == [
        ("missing-asset", "./missing.usda")
    ]


def test_a_property_that_is_listed_and_not_there() -> None:
    report = linted(patched(148, 1))
    stage = Usd.Stage.Open("a.usdc")
    prim = stage.GetPrimAtPath("/Render/beauty")
    assert "World" in prim.GetAuthoredPropertyNames()
    assert not prim.GetProperty("World").GetPropertyStack(Usd.TimeCode.Default())
    what = "it lists the property </Render/beauty.World>, which is not there"
    assert told(report) == [("unreadable-file", OPENS + what)]


@pytest.mark.parametrize(("at", "usd_says"), [(378, "unpack"), (149, "propName")])
def test_a_stage_that_does_not_open_for_what_is_in_a_layer(at: int, usd_says: str) -> None:
    """USD's own words, of its C++, are told only with -v."""
    report = linted(patched(at, 1))
    said = "USD opens it, and it is damaged, or a layer that it uses is"
    assert told(report) == [("unreadable-file", said)]
    assert any(usd_says in one for one in report.chatter)


def test_a_stage_that_does_not_open(monkeypatch: pytest.MonkeyPatch) -> None:
    def give_up(*_: object, **__: object) -> None:
        Tf.RaiseRuntimeError("the boost of the node")

    monkeypatch.setattr(lint_file, "open_stage", give_up)
    report = linted(SCENE)
    said = "USD opens its layers and gives up on the stage: one of them may be damaged"
    assert told(report) == [("unopened-stage", said)]
    assert any("the boost of the node" in one for one in report.chatter)


def test_metadata_of_a_type_that_python_does_not_know() -> None:
    layer = Sdf.Layer.CreateNew("whole.usdc")
    layer.subLayerPaths.append("x.usda")
    layer.subLayerOffsets[0] = Sdf.LayerOffset(5)
    layer.Save()
    data = Path("whole.usdc").read_bytes()
    assert data.count(b"Offsets") == 1
    report = linted(data.replace(b"Offsets", b"Offsetz"))
    stage = Usd.Stage.Open("a.usdc")
    with pytest.raises(TypeError, match="LayerOffset"):
        stage.GetPseudoRoot().GetAllAuthoredMetadata()
    assert told(report) == [
        ("unreadable-file", OPENS + "its metadata holds a value of a wrong type")
    ]


def test_a_spec_that_is_not_there() -> None:
    with pytest.raises(DamagedError, match="not there"):
        there([1, None])
    assert there([1, 2]) == [1, 2]


def test_a_prim_is_missed_before_usd_is_asked_for_arcs_and_dies() -> None:
    file = str(ROOT / "fixtures" / "broken" / "lost_prim.usdc")
    command = [sys.executable, "-m", "usdrender_lint", "-j", "0", "--isolated", file]
    run = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert run.returncode == 2
    assert "lost_prim.usdc: " + OPENS + "it lists a prim or variant that is not there" in run.stderr


def test_no_damage_stops_the_tables_of_a_crate() -> None:
    pattern = re.compile(rb"Render(?:Settings|Product|Var|Pass)")
    for at in range(0, len(SCENE), 3):
        Path("a.usdc").write_bytes(patched(at, 255))
        if (types := crate_types("a.usdc", pattern)) is not None:
            types.paths()


def test_dictionaries_deep_within_each_other_are_no_damage() -> None:
    deep = (
        "dictionary d = {\n" * 3000 + 'string renderSettingsPrimPath = "/Render/S"\n' + "}\n" * 3000
    )
    Path("a.usda").write_text(f"#usda 1.0\n(\n    customLayerData = {{\n{deep}}}\n)\n")
    report = lint(["a.usda"])
    assert report.problems == ()
    assert [f.rule.id for f in report.findings] == ["default-settings-misspelled"]


def test_a_relative_member_is_looked_for_no_further() -> None:
    """Layers hold absolute paths only, unless they are damaged."""

    class Stage:
        asked = 0

        def GetPrimAtPath(self, path: Sdf.Path) -> None:  # noqa: N802 as USD calls it
            self.asked += 1
            assert self.asked < 10

    target = Target("../World", State.MISSING, Site("/Render/P.collection:c:includes"))
    assert member(Stage(), target, guess=True).path == "../World"

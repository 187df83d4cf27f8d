"""Is what was known hidden, and nothing else, whatever is edited around it?"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from usdrender_lint.__main__ import main
from usdrender_lint.baseline import Baseline, Entry, load
from usdrender_lint.model import RenderScope
from usdrender_lint.results import Located, Location, Report, Verdict
from usdrender_lint.rule import Rule, Severity
from usdrender_lint.testing import BASE

CLEAN = BASE.replace(
    "#usda 1.0\n", '#usda 1.0\n(\n    renderSettingsPrimPath = "/Render/Primary"\n)\n'
)
BROKEN = CLEAN.replace("rel camera = </World/main_cam>", "rel camera = </c>").replace(
    "rel products = </Render/Beauty>", "rel products = [</Render/Beauty>, </Render/Ünde>]"
)
CAMERA = '{"rule": "unresolved-target", "layer": "shots/a.usda", "prim": "/Render/Primary", "property": "camera", "target": "/c", "count": 1},'
PRODUCT = '{"rule": "unresolved-target", "layer": "shots/a.usda", "prim": "/Render/Primary", "property": "products", "target": "/Render/Ünde", "count": 1},'
WRITTEN = f'[\n{CAMERA}\n{PRODUCT}\n{{"version": 1}}\n]\n'


@dataclass(frozen=True)
class Run:
    code: int
    out: str
    err: str

    @property
    def findings(self) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = json.loads(self.out)["findings"]
        return found

    @property
    def summary(self) -> dict[str, int]:
        summary: dict[str, int] = json.loads(self.out)["summary"]
        return summary


Call = Callable[..., Run]


@pytest.fixture
def show(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A repository with a shot that has two findings, and one that has none."""
    (tmp_path / ".git").mkdir()
    (tmp_path / "shots").mkdir()
    (tmp_path / "shots" / "a.usda").write_text(BROKEN, "utf-8")
    (tmp_path / "shots" / "b.usda").write_text(CLEAN, "utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def call(capsys: pytest.CaptureFixture[str]) -> Call:
    def run(*args: str) -> Run:
        code = main([*args, "--output-format", "json"])
        said = capsys.readouterr()
        return Run(code, said.out, said.err)

    return run


@pytest.fixture
def known(show: Path) -> Path:
    file = show / "known.json"
    file.write_text(WRITTEN, "utf-8")
    return file


def edit(file: Path, old: str, new: str) -> None:
    text = file.read_text("utf-8")
    assert old in text
    file.write_text(text.replace(old, new), "utf-8")


# Writing


def test_it_is_written_sorted_a_finding_a_line_without_lines_and_times(
    show: Path, call: Call
) -> None:
    run = call("shots", "--baseline", "known.json", "--update-baseline")
    assert run.code == 0
    assert run.err == "note: known.json is written: 2 added, 0 taken out, 2 in all\n"
    assert run.findings == []
    assert run.summary["baseline"] == 2
    assert (show / "known.json").read_text("utf-8") == WRITTEN
    again = call("shots", "--baseline", "known.json", "--update-baseline")
    assert again.err == "note: known.json is written: 0 added, 0 taken out, 2 in all\n"
    assert (show / "known.json").read_text("utf-8") == WRITTEN


def test_it_is_the_same_from_every_folder_of_the_repository(
    show: Path, call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(show / "shots")
    assert call("a.usda", "--baseline", "../known.json", "--update-baseline").code == 0
    assert (show / "known.json").read_text("utf-8") == WRITTEN


def test_nothing_found_is_a_baseline_too(show: Path, call: Call) -> None:
    run = call("shots/b.usda", "--baseline", "known.json", "--update-baseline", "-q")
    assert (run.code, run.err) == (0, "")
    assert (show / "known.json").read_text("utf-8") == '[\n{"version": 1}\n]\n'
    assert call("shots/b.usda", "--baseline", "known.json").code == 0


def test_each_line_stands_for_itself(show: Path, call: Call, known: Path) -> None:
    """So git merges branches that add, and a line may be taken out by hand."""
    lines = WRITTEN.splitlines(keepends=True)
    known.write_text("".join([lines[0], *lines[2:]]), "utf-8")
    run = call("shots", "--baseline", "known.json")
    assert [f["target"] for f in run.findings] == ["/c"]
    known.write_text("".join([*lines[:2], *lines[1:]]), "utf-8")
    assert call("shots", "--baseline", "known.json").findings == []


def test_of_two_lines_for_one_finding_the_greater_counts(tmp_path: Path) -> None:
    """As a merge leaves them when both branches found more of it."""
    file = tmp_path / "known.json"
    for one, other in ((3, 2), (2, 3)):
        counted = (CAMERA.replace('"count": 1', f'"count": {n}') for n in (one, other))
        file.write_text("[\n" + "\n".join(counted) + '\n{"version": 1}\n]\n', "utf-8")
        assert load(file).count == 3


def test_lines_are_sorted_by_layer_whatever_was_found_first() -> None:
    entries = [Entry(f"{c}.usda", "/P", "", "", "r") for c in "abc"]
    text = Baseline(dict.fromkeys(reversed(entries), 1)).text()
    assert [e["layer"] for e in json.loads(text)[:-1]] == ["a.usda", "b.usda", "c.usda"]


def test_names_that_are_no_utf_8_come_back_as_they_are(tmp_path: Path) -> None:
    entry = Entry("sh\udcff.usda", "/Render", "", "", "dead-target")
    text = Baseline({entry: 3}).text().encode("utf-8", "backslashreplace").decode()
    assert json.loads(text)[0]["layer"] == entry.layer


# Hiding


def test_what_is_known_is_hidden_and_what_is_new_is_not(
    show: Path, call: Call, known: Path
) -> None:
    run = call("shots", "--baseline", "known.json")
    assert (run.code, run.err, run.findings) == (0, "", [])
    assert run.summary == {"error": 0, "warning": 0, "note": 0, "suppressed": 0, "baseline": 2}
    edit(show / "shots" / "a.usda", "</c>", "</d>")
    run = call("shots", "--baseline", "known.json")
    assert run.code == 1
    assert [f["target"] for f in run.findings] == ["/d"]
    assert run.err == "note: known.json holds 1 finding that is gone: see --update-baseline\n"


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("#usda 1.0\n", "#usda 1.0\n# one\n\n# two\n"),
        ("\n", "\r\n"),
        ('    def RenderSettings "Primary"', '\tdef RenderSettings\t"Primary"  '),
        ("rel camera = </c>", "rel camera = [\n            </c>\n]"),
    ],
)
def test_it_survives_edits(show: Path, call: Call, known: Path, old: str, new: str) -> None:
    edit(show / "shots" / "a.usda", old, new)
    run = call("shots", "--baseline", "known.json")
    assert (run.code, run.err) == (0, "")
    assert run.summary["baseline"] == 2


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("rule", "dead-target"),
        ("layer", "shots/b.usda"),
        ("prim", "/Render"),
        ("property", "products"),
        ("target", "/C"),
    ],
)
def test_everything_that_names_a_finding_counts(
    show: Path, call: Call, known: Path, key: str, value: str
) -> None:
    entries = json.loads(WRITTEN)
    entries[0][key] = value
    known.write_text(json.dumps(entries), "utf-8")
    run = call("shots", "--baseline", "known.json")
    assert run.code == 1
    assert [f["target"] for f in run.findings] == ["/c"]


def test_a_member_of_a_package_and_the_layer_itself_have_names() -> None:
    assert Baseline({}).count == 0
    finding = _finding("/", None, None)
    at = replace(finding.location, member="sub/a.usda")
    inside = replace(finding, location=at)
    known = Baseline({}).updated(_report(finding, inside))
    assert known.known == {
        Entry("a.usda", "/", "", "", "r"): 1,
        Entry("a.usda[sub/a.usda]", "/", "", "", "r"): 1,
    }
    assert json.loads(known.text())[0] == {
        "rule": "r",
        "layer": "a.usda",
        "prim": "/",
        "property": None,
        "target": None,
        "count": 1,
    }
    assert known.hide(_report(finding, inside)).findings == ()
    # The file that was linted is the package.
    assert known.stale(replace(_report(), ran={"a.usda": frozenset({"r"})})) == 2


def _finding(prim: str, name: str | None, target: str | None, message: str = "") -> Located:
    rule = Rule("r", RenderScope, Severity.ERROR, "0.1", "", lambda *_: iter(()))
    at = Location("/show/a.usda", "a.usda")
    return Located(rule, Severity.ERROR, message, "", "", at, prim, name, target)


def _report(*findings: Located) -> Report:
    return Report("0.1.0", (), ("a.usda",), findings)


def test_no_more_are_hidden_than_were_known() -> None:
    first, second, third = (_finding("/P", "a", None, m) for m in "abc")
    known = Baseline({Entry("a.usda", "/P", "a", "", "r"): 2})
    report = known.hide(_report(first, second, third))
    assert report.findings == (third,)
    assert [f.message for f in report.suppressed] == ["a", "b"]
    assert {f.verdict for f in report.suppressed} == {Verdict.BY_BASELINE}
    assert report.counts[Severity.ERROR] == 1
    assert (report.in_baseline, report.ignored) == (2, 0)
    again = replace(_report(first), ran={"a.usda": frozenset({"r"})})
    assert known.stale(again) == 1
    assert known.updated(again).count == 1


def test_what_is_found_more_often_is_added_also_in_a_layer_that_was_only_used() -> None:
    known = Baseline({Entry("a.usda", "/P", "a", "", "r"): 1})
    twice = _report(_finding("/P", "a", None, "a"), _finding("/P", "a", None, "b"))
    assert known.updated(twice).count == 2
    assert known.updated(replace(twice, ran={"a.usda": frozenset({"r"})})).count == 2


def test_a_comment_comes_before_the_baseline(show: Path, call: Call, known: Path) -> None:
    edit(show / "shots" / "a.usda", "</c>", "</c> # usdrender-lint: ignore[unresolved-target]")
    run = call("shots", "--baseline", "known.json")
    assert run.code == 0
    assert (run.summary["suppressed"], run.summary["baseline"]) == (1, 1)
    assert "1 finding that is gone" in run.err
    call("shots", "--baseline", "known.json", "--update-baseline")
    assert known.read_text("utf-8") == WRITTEN.replace(f"{CAMERA}\n", "")


def test_reports_tell_how_many(show: Path, known: Path, capsys: pytest.CaptureFixture[str]) -> None:
    edit(show / "shots" / "a.usda", "</c>", "</c> # usdrender-lint: ignore[unresolved-target]")
    for chosen in ("full", "concise"):
        assert main(["shots", "--baseline", "known.json", "--output-format", chosen]) == 0
        said = capsys.readouterr().out
        assert said == "No findings in 2 files; 1 in the baseline, 1 ignored.\n"
    edit(show / "shots" / "b.usda", "main_cam>", "cam>")
    assert main(["shots", "--baseline", "known.json"]) == 1
    said = capsys.readouterr().out
    assert said.endswith("\n1 finding (1 error) in 2 files; 1 in the baseline, 1 ignored.\n")
    main(["shots", "--baseline", "known.json", "--output-format", "sarif"])
    (run,) = json.loads(capsys.readouterr().out)["runs"]
    assert len(run["results"]) == 1
    assert "suppressions" not in run["results"][0]


def test_an_audit_shows_all(show: Path, call: Call, known: Path) -> None:
    edit(show / "shots" / "a.usda", "</c>", "</c> # usdrender-lint: ignore[unresolved-target]")
    run = call("shots", "--baseline", "known.json", "--no-ignores")
    assert (run.code, run.err, len(run.findings)) == (1, "", 2)
    assert (run.summary["suppressed"], run.summary["baseline"]) == (0, 0)


# What is gone


def test_only_what_this_run_could_have_found_is_gone(show: Path, call: Call, known: Path) -> None:
    (show / "shots" / "a.usda").write_text(CLEAN, "utf-8")
    gone = "note: known.json holds 2 findings that are gone: see --update-baseline\n"
    assert call("shots", "--baseline", "known.json").err == gone
    assert call("shots", "--baseline", "known.json", "-q").err == ""
    for args in (
        ["shots/b.usda"],
        ["shots", "--ignore", "unresolved-target"],
        ["shots", "--select", "dead-target"],
    ):
        assert call(*args, "--baseline", "known.json").err == ""
        run = call(*args, "--baseline", "known.json", "--update-baseline")
        assert run.err == "note: known.json is written: 0 added, 0 taken out, 2 in all\n"
        assert known.read_text("utf-8") == WRITTEN
    run = call("shots", "--baseline", "known.json", "--update-baseline")
    assert run.err == "note: known.json is written: 0 added, 2 taken out, 0 in all\n"


def test_a_layer_that_was_only_used_is_not_judged(show: Path, call: Call, known: Path) -> None:
    """Another stage may find in it what this one does not."""
    (show / "shots" / "b.usda").write_text(
        '#usda 1.0\n(\n    renderSettingsPrimPath = "/Render/Primary"\n    subLayers = [@a.usda@]\n)\n'
        'def Camera "c"\n{\n}\n',
        "utf-8",
    )
    run = call("shots/b.usda", "--baseline", "known.json")
    assert (run.code, run.err) == (0, "")
    assert run.summary["baseline"] == 1
    call("shots/b.usda", "--baseline", "known.json", "--update-baseline")
    assert known.read_text("utf-8") == WRITTEN
    # What it finds more often than others is known from now on.
    edit(known, '"target": "/Render/Ünde", "count": 1', '"target": "/Render/Ünde", "count": 2')
    text = known.read_text("utf-8")
    call("shots/b.usda", "--baseline", "known.json", "--update-baseline")
    assert known.read_text("utf-8") == text


def test_a_stage_with_parts_missing_makes_nothing_gone(show: Path, call: Call, known: Path) -> None:
    (show / "shots" / "a.usda").write_text("#usda 1.0\ndef {\n", "utf-8")
    run = call("shots", "--baseline", "known.json")
    assert [f["rule"] for f in run.findings] == ["syntax-error"]
    assert run.err == ""
    call("shots", "--baseline", "known.json", "--update-baseline")
    assert PRODUCT in known.read_text("utf-8")


def test_an_incomplete_run_updates_nothing(show: Path, call: Call, known: Path) -> None:
    (show / "shots" / "a.usda").write_text(CLEAN, "utf-8")
    (show / "shots" / "c.usda").write_text("", "utf-8")
    run = call("shots", "--baseline", "known.json")
    assert run.code == 2
    assert "gone" not in run.err
    run = call("shots", "--baseline", "known.json", "--update-baseline")
    assert run.code == 2
    assert "error: known.json is not updated: the run is incomplete\n" in run.err
    assert known.read_text("utf-8") == WRITTEN


# Baselines that are none


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "known.json:1: not a baseline: not JSON"),
        ("{}", "known.json:1: not a baseline: not a list of findings"),
        ("[]", "known.json:1: not a baseline: not a list of findings"),
        (WRITTEN.replace("]", ""), "known.json:6: not a baseline: not JSON"),
        (
            WRITTEN.replace(CAMERA, f"<<<<<<< HEAD\n{CAMERA}\n=======\n>>>>>>> other"),
            "known.json:2: not a baseline: not JSON",
        ),
        (WRITTEN.replace('{"version": 1}', '{"version": 2}'), """known.json:4: not a baseline: the last entry must be {"version": 1}"""),
        (WRITTEN.replace(',\n{"version": 1}', ""), "known.json:3: not a baseline: the last entry"),
        (WRITTEN.replace(PRODUCT, '"x",'), "known.json:3: not a baseline: not a finding"),
        (WRITTEN.replace(PRODUCT, "[],"), "known.json:3: not a baseline: not a finding"),
        (WRITTEN.replace('"layer": "shots/a.usda", "prim": "/Render/Primary", "property": "products", ', ""), "known.json:3: not a baseline: 'layer' must be a text"),
        (WRITTEN.replace('"/c"', "1"), "known.json:2: not a baseline: 'target' must be a text or null"),
        (WRITTEN.replace('"camera"', '""'), "known.json:2: not a baseline: 'property' must be a text or null"),
        (WRITTEN.replace('"count": 1', '"count": true'), "known.json:2: not a baseline: 'count' must be a number from 1"),
        (WRITTEN.replace('"count": 1', '"count": 0'), "known.json:2: not a baseline: 'count' must be a number from 1"),
        (WRITTEN.replace(', "count": 1', ""), "known.json:2: not a baseline: 'count' must be a number from 1"),
        ("[" * 100_000, "known.json:1: not a baseline: nested too deeply"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("update", [False, True])
def test_what_is_no_baseline_is_told_by_line_and_kept(
    show: Path, call: Call, text: str, said: str, update: bool
) -> None:
    file = show / "known.json"
    file.write_text(text, "utf-8")
    run = call("shots", "--baseline", "known.json", *(["--update-baseline"] if update else []))
    assert (run.code, run.out) == (2, "")
    assert run.err.startswith(f"error: {said}")
    assert file.read_text("utf-8") == text


def test_a_baseline_formatted_by_another_program_is_one(
    show: Path, call: Call, known: Path
) -> None:
    entries = json.loads(WRITTEN)
    known.write_text(json.dumps(entries, indent=4), "utf-8")
    assert call("shots", "--baseline", "known.json").code == 0
    entries[1]["count"] = -1
    text = json.dumps(entries, indent=4)
    known.write_text(text, "utf-8")
    run = call("shots", "--baseline", "known.json")
    number = re.findall(r"known\.json:(\d+):", run.err)
    assert number == [str(text[: text.rindex("{", 0, text.index("-1"))].count("\n") + 1)]


def test_a_baseline_that_is_not_there_is_told(show: Path, call: Call) -> None:
    run = call("shots", "--baseline", "nonesuch.json")
    assert (run.code, run.out) == (2, "")
    assert run.err == "error: nonesuch.json: no such baseline; --update-baseline makes one\n"
    run = call("shots", "--baseline", "nonesuch/known.json", "--update-baseline")
    assert run.code == 2
    assert "nonesuch/known.json cannot be written" in run.err
    (show / "bad.json").write_bytes(b'[\n{"a": "\xff"}]')
    run = call("shots", "--baseline", "bad.json")
    assert (run.code, run.err) == (2, "error: bad.json:2: not a baseline: not UTF-8\n")


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["--update-baseline"], "--update-baseline needs --baseline FILE"),
        (["--baseline", "a.json", "--update-baseline", "--no-ignores"], "exclude each other"),
        (["--baseline", "shots"], "names no file"),
        (["--baseline", ""], "names no file"),
        (["--baseline", "shots/a.usda", "--update-baseline"], "is a USD file by its name"),
    ],
)
def test_options_that_make_no_sense(show: Path, call: Call, args: list[str], said: str) -> None:
    run = call("shots", *args)
    assert run.code == 2
    assert said in run.err
    assert (show / "shots" / "a.usda").read_text("utf-8") == BROKEN

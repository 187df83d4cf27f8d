"""The contract of the command line: exit codes, what goes where, and nothing green that was not looked at.

What can be asked of `main` in this process is asked there; what only a process shows (pipes,
signals, what USD prints, what is imported) is asked of one.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import stat
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from html import unescape
from pathlib import Path

import pytest

from conftest import ROOT
from usdrender_lint import __version__, cli, lint_file, wanted
from usdrender_lint.__main__ import main
from usdrender_lint.cli import command
from usdrender_lint.formats import FORMATS
from usdrender_lint.job import Config
from usdrender_lint.lint import lint
from usdrender_lint.registry import Selection, all_rules, select
from usdrender_lint.report import page_url
from usdrender_lint.results import Report
from usdrender_lint.rule import AnyRule, Severity
from usdrender_lint.testing import BASE

BROKEN = ROOT / "fixtures" / "broken"

HEADER = '#usda 1.0\n(\n    renderSettingsPrimPath = "/Render/Primary"\n)\n'
CLEAN = BASE.replace("#usda 1.0\n", HEADER, 1)
SCENES = {
    "clean.usda": CLEAN,
    "failed.usda": CLEAN.replace("camera = </World/main_cam>", "camera = </World/cam>"),
    "warned.usda": BASE,
    "noted.usda": f"""\
{HEADER}
def Scope "Render"
{{
    def RenderSettings "Primary"
    {{
        rel camera = </cam>
    }}
}}
def Camera "cam"
{{
}}
""",
}
FAILED = "camera </World/cam> does not exist"

HERE = str(Path(cli.__file__).parents[1])
ENVIRONMENT = {
    name: value
    for name, value in os.environ.items()
    if name not in ("NO_COLOR", "FORCE_COLOR") and not name.startswith("USDRENDER_LINT_")
}
ENVIRONMENT["PYTHONPATH"] = os.pathsep.join(filter(None, (HERE, os.environ.get("PYTHONPATH"))))


@dataclass(frozen=True)
class Run:
    code: int
    out: str
    err: str


Main = Callable[..., Run]

STARTED: list[subprocess.Popen[bytes]] = []


@pytest.fixture(scope="session")
def show(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a scene for every severity."""
    folder = tmp_path_factory.mktemp("show")
    for name, text in SCENES.items():
        (folder / name).write_text(text, "utf-8")
    (folder / "empty").mkdir()
    return folder


@pytest.fixture(autouse=True)
def _in_the_show(show: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(show)
    for name in os.environ.keys() - ENVIRONMENT.keys():
        monkeypatch.delenv(name)


@pytest.fixture(autouse=True)
def _no_process_is_left() -> Iterator[None]:
    """A test that fails half-way leaves its processes."""
    yield
    while STARTED:
        process = STARTED.pop()
        process.kill()
        process.wait()
        for stream in (process.stdout, process.stderr):
            if stream is not None:
                stream.close()


@pytest.fixture
def call(capsys: pytest.CaptureFixture[str]) -> Main:
    """Run the program in this process."""

    def run(*args: str) -> Run:
        code = main(args)
        said = capsys.readouterr()
        return Run(code, said.out, said.err)

    return run


def start(
    *args: str,
    stdout: int = subprocess.PIPE,
    through: Sequence[str] = (),
    environment: dict[str, str] | None = None,
) -> subprocess.Popen[bytes]:
    """Start the program as a process of its own."""
    process = subprocess.Popen(
        [*through, sys.executable, "-m", "usdrender_lint", *args],
        stdout=stdout,
        stderr=subprocess.PIPE,
        env=ENVIRONMENT | (environment or {}),
    )
    STARTED.append(process)
    return process


def end(process: subprocess.Popen[bytes]) -> Run:
    out, err = process.communicate(timeout=60)
    return Run(process.returncode, (out or b"").decode(), err.decode())


def python(code: str, *args: str) -> Run:
    """Run a few lines of Python in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-c", code, *args], capture_output=True, env=ENVIRONMENT, timeout=60
    )
    return Run(done.returncode, done.stdout.decode(), done.stderr.decode())


# Exit codes


@pytest.mark.parametrize("jobs", ["0", "2"])
@pytest.mark.parametrize(
    ("package", "told"),
    [
        (
            "raise ModuleNotFoundError(\"No module named 'pxr'\", name='pxr')",
            "is not installed: pip install usd-core",
        ),
        ("raise ImportError('libtbb.so: not found', name='pxr.Tf')", "cannot be loaded: libtbb.so: not found"),
    ],
)  # fmt: skip
def test_without_a_usd_that_will_do(tmp_path: Path, jobs: str, package: str, told: str) -> None:
    (tmp_path / "pxr").mkdir()
    (tmp_path / "pxr" / "__init__.py").write_text(package)
    (tmp_path / "a.usda").write_text(CLEAN)
    where = {"PYTHONPATH": os.pathsep.join([str(tmp_path), HERE])}
    run = end(start("-j", jobs, str(tmp_path / "a.usda"), environment=where))
    assert (run.code, run.out, run.err) == (2, "", f"error: usd-core {told}\n")


def test_with_a_usd_that_is_too_old(tmp_path: Path) -> None:
    (tmp_path / "a.usda").write_text(CLEAN)
    code = """
import sys
from pxr import Usd
from usdrender_lint.__main__ import main
Usd.GetVersion = lambda: (0, 25, 5)
sys.exit(main(sys.argv[1:]))
"""
    run = python(code, str(tmp_path / "a.usda"))
    said = "error: usd-core cannot be loaded: it is 25.05, and 25.11 is the oldest that will do\n"
    assert (run.code, run.out, run.err) == (2, "", said)


def test_the_oldest_usd_is_that_of_the_package() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    wanted = next(one for one in project["dependencies"] if one.startswith("usd-core"))
    assert wanted.startswith("usd-core>={}.{},".format(*lint_file.OLDEST))


@pytest.mark.parametrize("chosen", FORMATS)
@pytest.mark.parametrize(
    ("code", "args"),
    [
        (0, "clean.usda"),
        (0, "noted.usda"),
        (1, "noted.usda --fail-on note"),
        (1, "warned.usda"),
        (1, "warned.usda clean.usda"),
        (0, "warned.usda --fail-on error"),
        (1, "failed.usda"),
        (1, "failed.usda --fail-on error"),
        (0, "failed.usda --fail-on never"),
        (0, "failed.usda --exit-zero"),
        (1, "failed.usda --quiet"),
        (2, "missing.usda"),
        (2, "failed.usda missing.usda"),
        (2, "failed.usda missing.usda --exit-zero"),
        (2, "failed.usda missing.usda --fail-on never"),
        (2, "clean.usda missing.usda --quiet"),
        (2, "empty"),
    ],
)
def test_the_exit_code_is_the_same_in_every_format(
    code: int, args: str, chosen: str, call: Main
) -> None:
    assert call("--output-format", chosen, *args.split()).code == code


def test_a_process_ends_with_the_exit_code() -> None:
    clean, failed, missing = map(start, ["clean.usda", "failed.usda", "missing.usda"])
    assert end(clean).code == 0
    assert end(failed).code == 1
    assert end(missing).code == 2


@pytest.mark.parametrize("chosen", FORMATS)
def test_findings_of_other_files_are_told_when_the_run_is_incomplete(
    chosen: str, call: Main
) -> None:
    run = call("--output-format", chosen, "failed.usda", "missing.usda")
    assert run.code == 2
    assert FAILED in unescape(run.out)
    assert run.err == "error: missing.usda: no such file or folder\n"


def test_a_clean_run_says_how_much_it_looked_at(call: Main) -> None:
    assert call("clean.usda").out == "No findings in 1 file.\n"


# What cannot be read


def test_all_missing_paths_are_told(call: Main) -> None:
    run = call("lost.usda", "clean.usda", "gone", "away.usdc")
    assert run.code == 2
    assert run.err == (
        "error: away.usdc: no such file or folder\n"
        "error: gone: no such file or folder\n"
        "error: lost.usda: no such file or folder\n"
    )


@pytest.mark.parametrize(
    ("file", "told"),
    [
        ("empty.usda", "the file is empty"),
        ("truncated.usdc", "truncated or damaged"),
        ("damaged_value.usdc", "it is damaged, or a layer that it uses is"),
        ("lost_property.usdc", "it is damaged: it lists the property </"),
        (
            "wrong_value.usdc",
            "it is damaged: the value of </Render/final.resolution> is not of the type of its attribute",
        ),
        ("random_bytes.usd", "binary data that is not USD"),
        ("utf8_bom.usda", "byte order mark"),
        ("malformed.usdz", "truncated or damaged"),
        ("lfs_pointer.usd", "run `git lfs pull`"),
        ("lfs_pointer.usda", "run `git lfs pull`"),
        ("lfs_pointer.usdc", "run `git lfs pull`"),
        ("lfs_pointer.usdz", "run `git lfs pull`"),
        ("README.md", "not a USD file by its name: expected .usd, .usda, .usdc or .usdz"),
        ("unreadable_sublayer.usda", "brought in by"),
    ],
)
def test_what_cannot_be_read_is_no_finding(file: str, told: str, call: Main) -> None:
    run = call(str(BROKEN / file), "--output-format", "concise", "--quiet")
    assert run.code == 2
    assert told in run.err
    assert run.err.count("\n") == 1
    assert run.out == ""


def test_a_folder_without_usd_is_an_error(call: Main) -> None:
    run = call("empty")
    assert run.code == 2
    assert run.err == "error: empty: no USD file in this folder or below it\n"
    assert run.out.startswith("Nothing was linted.\n")


def test_links_that_lead_nowhere_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: Main
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("dangling.usda").symlink_to("nowhere.usda")
    Path("loop.usda").symlink_to("loop.usda")
    run = call("dangling.usda", "loop.usda")
    assert run.code == 2
    assert re.fullmatch(
        r"error: dangling\.usda: cannot be read: .+\nerror: loop\.usda: cannot be read: .+\n",
        run.err,
    )


@pytest.mark.skipif(getattr(os, "geteuid", lambda: 0)() == 0, reason="root may read everything")
def test_a_file_without_permission_is_told(tmp_path: Path, call: Main) -> None:
    file = tmp_path / "locked.usda"
    file.write_text(CLEAN, "utf-8")
    file.chmod(0)
    run = call(str(file))
    assert run.code == 2
    assert "permission denied" in run.err


def test_a_folder_is_searched(tmp_path: Path, call: Main) -> None:
    """For all suffixes in any case, below it too, but not in what is hidden."""
    wanted = ["a.usda", "b.USDA", "deep/down/c.usd"]
    for name in [*wanted, "notes.txt", ".hidden/d.usda", ".e.usda"]:
        file = tmp_path / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(SCENES["failed.usda"], "utf-8")
    run = call(str(tmp_path), "--output-format", "json")
    assert run.code == 1
    paths = [finding["path"] for finding in json.loads(run.out)["findings"]]
    assert paths == [os.path.relpath(tmp_path / name) for name in wanted]


# What is the author's content


def test_a_layer_that_does_not_parse_is_a_finding_with_its_line(call: Main) -> None:
    run = call(str(BROKEN / "parse_error.usda"), "--output-format", "concise")
    assert run.code == 1
    assert "parse_error.usda:11:9: error[syntax-error]" in run.out
    assert run.err == ""


def test_usd_says_nothing_on_stderr() -> None:
    """It would, from C++, whatever Python does with its own streams."""
    files = ("missing_sublayer.usda", "parse_error_in_sublayer.usda", "missing_reference.usda")
    run = end(start(*(str(BROKEN / name) for name in files), "--quiet"))
    assert run.code == 1
    assert "error[composition-error]" in run.out
    assert "error[syntax-error]" in run.out
    assert run.err == ""


# Bugs


def broken(rule_id: str) -> Selection:
    """All default rules, of which one raises."""

    def check(rule: AnyRule) -> AnyRule:
        def fails(*_: object) -> Iterator[object]:
            raise KeyError("oops")

        return replace(rule, check=fails) if rule.id == rule_id else rule

    chosen = select()
    return replace(chosen, run=tuple(map(check, chosen.run)))


def test_a_rule_that_raises_costs_no_other_findings(call: Main) -> None:
    report = lint(["failed.usda"], Config(broken("missing-camera")))
    assert [f.rule.id for f in report.findings] == ["unresolved-target"]
    assert {(p.kind, p.rule) for p in report.problems} == {("crashed-rule", "missing-camera")}


@pytest.mark.parametrize("chosen", FORMATS)
def test_a_rule_that_raises_makes_the_run_incomplete(
    chosen: str, call: Main, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(wanted, "select", lambda *_, **__: broken("missing-camera"))
    run = call("failed.usda", "--output-format", chosen, "--exit-zero")
    assert run.code == 2
    assert FAILED in unescape(run.out)
    assert "the rule missing-camera failed on <" in run.err
    assert "KeyError: 'oops'" in run.err
    assert "Traceback" not in run.err


def test_a_bug_of_the_program_does_not_end_in_the_code_of_findings(
    call: Main, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*_: object, **__: object) -> Report:
        raise ZeroDivisionError

    monkeypatch.setattr(cli, "report_on", fails)
    run = call("clean.usda", "--exit-zero")
    assert run.code == 2
    assert run.out == ""
    assert run.err.startswith("Traceback")
    assert run.err.endswith("error: this is a bug of usdrender-lint\n")


# Options


@pytest.mark.parametrize(
    ("args", "told"),
    [
        ("", "Missing argument 'PATHS...'"),
        ("--quiet", "Missing argument 'PATHS...'"),
        ("-q -v x.usda", "--quiet and --verbose exclude each other"),
        ("--selct camera x.usda", "'--select'"),
        ("--select camra x.usda", "unknown rule 'camra': did you mean 'camera'?"),
        ("--select missing-camra x.usda", "did you mean 'missing-camera'?"),
        ("--select camera,missing-camra x.usda", "did you mean 'missing-camera'?"),
        ("--select zzz x.usda", "--list-rules shows them all"),
        ("--select= x.usda", "no rule is named"),
        ("--ignore missing-camra x.usda", "did you mean 'missing-camera'?"),
        ("--ignore ALL x.usda", "no rule is selected"),
        ("--select camera --ignore camera x.usda", "no rule is selected"),
        ("--severity missing-camra=note x.usda", "did you mean 'missing-camera'?"),
        ("--severity missing-camera=fatal x.usda", "'fatal' is not error, warning, note or off"),
        ("--severity missing-camera x.usda", "'missing-camera' is not RULE=LEVEL"),
        ("--severity= x.usda", "no rule is named"),
        ("--fail-on fatal x.usda", "'fatal' is not one of"),
        ("--output-format xml x.usda", "'xml' is not one of"),
        ("--output-file sarfi:x.json x.usda", "'sarfi' is not full, concise, json, sarif,"),
        ("--output-file json: x.usda", "'json:' names no file"),
        ("--output-file= x.usda", "'' names no file"),
        ("--output-file no/such.json x.usda", "there is no folder 'no'"),
        ("--output-file failed.usda/x.json failed.usda", "there is no folder 'failed.usda'"),
        ("--output-file a.json --output-file sarif:./a.json x.usda", "'a.json' is named twice"),
        ("--output-file empty x.usda", "'empty' names no file"),
        ("--color sometimes x.usda", "'sometimes' is not one of"),
        ("--renderer nobody x.usda", "unknown renderer 'nobody'"),
        ("--explain missing-camra", "did you mean 'missing-camera'?"),
        ("--explain ../README", "unknown rule '../README'"),
        ("--explain camera", "'camera' is a subject, and each of its rules has a page"),
    ],
)
def test_an_option_that_has_no_effect_is_an_error(args: str, told: str, call: Main) -> None:
    run = call(*args.split())
    assert run.code == 2
    assert told in run.err.splitlines()[-1]
    assert run.out == ""


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[Config]:
    """What is asked for; nothing is found."""
    seen: list[Config] = []

    def nothing(*asked: object, **_: object) -> Report:
        assert isinstance(asked[3], Config)
        seen.append(asked[3])
        return Report(__version__, (), (), ())

    monkeypatch.setattr(cli, "report_on", nothing)
    return seen


def group(name: str) -> set[str]:
    return {rule.id for rule in all_rules().values() if rule.group == name}


def told_by_default() -> set[str]:
    return set(select().told)


@pytest.mark.parametrize(
    ("args", "told"),
    [
        ("", told_by_default()),
        ("--select missing-camera", {"missing-camera"}),
        ("--select camera", group("camera")),
        ("--select camera,pass --select syntax-error", group("camera") | group("pass") | {"syntax-error"}),
        ("--select ALL", set(select(["ALL"]).told)),
        ("--select default,many-material-purposes", told_by_default() | {"many-material-purposes"}),
        ("--ignore camera", told_by_default() - group("camera")),
        ("--ignore camera,pass --ignore syntax-error", told_by_default() - group("camera") - group("pass") - {"syntax-error"}),
        ("--select camera --ignore missing-camera", group("camera") - {"missing-camera"}),
    ],
)  # fmt: skip
def test_rules_are_selected_by_id_and_group(
    args: str, told: set[str], call: Main, asked: list[Config]
) -> None:
    call("clean.usda", *args.split())
    assert asked[0].selection.told == told
    assert len(told) >= 1


def test_all_has_the_rules_that_the_default_leaves_out() -> None:
    assert set(select(["ALL"]).told) > told_by_default()


def test_a_severity_of_the_person_stands_above_the_rules_own(call: Main) -> None:
    assert call("failed.usda", "--severity", "unresolved-target=note").code == 0
    assert call("failed.usda", "--severity", "property=note").code == 0
    assert call("noted.usda", "--severity", "settings-without-products=error").code == 1


def test_the_later_severity_counts(call: Main, asked: list[Config]) -> None:
    call("clean.usda", "--severity", "camera=note,missing-camera=warning")
    wanted = dict.fromkeys(group("camera"), Severity.NOTE) | {"missing-camera": Severity.WARNING}
    assert asked[0].severities == wanted


def test_paths_may_begin_with_a_dash(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: Main
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("-q.usda").write_text(CLEAN, "utf-8")
    assert call("--", "-q.usda").out == "No findings in 1 file.\n"


# Information


def test_help_names_every_option_and_the_exit_codes(call: Main) -> None:
    run = call("--help")
    assert run.code == 0
    assert run.err == ""
    for option in {name for param in command.params for name in param.opts if name.startswith("-")}:
        assert option in run.out
    for code in (0, 1, 2, 130, 141):
        assert re.search(rf"^ +{code}  ", run.out, re.M)
    assert call("-h") == run


def test_help_is_in_sections(call: Main) -> None:
    lines = call("--help").out.splitlines()
    sections = [line for line in lines if re.fullmatch(r"\S.*:", line)]
    assert sections == [f"{name}:" for name in cli._SECTIONS.values()]
    assert cli._SECTIONS.keys() <= {param.name for param in command.params}
    at = [lines.index(section) for section in sections]
    assert at[0] < lines.index(next(line for line in lines if "--select RULES" in line)) < at[1]


# Completion


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_shell_is_told_how_to_complete(
    shell: str, call: Main, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("_USDRENDER_LINT_COMPLETE", f"{shell}_source")
    run = call()
    assert run.code == 0
    assert f"_USDRENDER_LINT_COMPLETE={shell}_complete" in run.out


def test_a_shell_that_is_unknown_gets_nothing(call: Main, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("_USDRENDER_LINT_COMPLETE", "sh_source")
    assert call() == Run(2, "", "error: _USDRENDER_LINT_COMPLETE=sh_source is unknown\n")


@pytest.mark.parametrize(
    ("line", "completed"),
    [
        ("--explain missing-cam", ["plain,missing-camera"]),
        ("--explain camer", []),
        ("--select camer", ["plain,camera"]),
        ("--select camera,missing-cam", ["plain,camera,missing-camera"]),
        ("--severity missing-cam", ["plain,missing-camera="]),
        ("--severity missing-camera=w", ["plain,missing-camera=warning"]),
        ("--output-file re", ["file,re"]),
        ("--fail-on e", ["plain,error"]),
        ("--baseline x --update-b", ["plain,--update-baseline"]),
        ("--selct x --ignore missing-cam", ["plain,missing-camera"]),
        ("--severity nonsense sho", ["file,sho"]),
        ("sho", ["file,sho"]),
    ],
)
def test_what_is_begun_is_completed(
    line: str, completed: list[str], call: Main, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("_USDRENDER_LINT_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", f"usdrender-lint {line}")
    monkeypatch.setenv("COMP_CWORD", str(len(line.split())))
    run = call()
    assert (run.code, run.err) == (0, "")
    assert run.out.split() == completed


@pytest.mark.skipif(os.name == "nt" or not shutil.which("bash"), reason="needs bash")
def test_bash_completes(tmp_path: Path) -> None:
    program = tmp_path / "usdrender-lint"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m usdrender_lint "$@"\n')
    program.chmod(0o755)
    script = """
        eval "$(_USDRENDER_LINT_COMPLETE=bash_source usdrender-lint)" &&
        complete -p usdrender-lint >&2 &&
        COMP_WORDS=(usdrender-lint --explain missing-cam) COMP_CWORD=2 &&
        _usdrender_lint_completion usdrender-lint &&
        echo "${COMPREPLY[@]}"
    """
    path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["bash", "-c", script],
        env={**os.environ, "PATH": path, "PYTHONPATH": HERE},
        capture_output=True,
        text=True,
    )
    assert "complete" in done.stderr
    assert done.stdout == "missing-camera\n"


def test_version(call: Main) -> None:
    assert call("--version") == Run(0, f"usdrender-lint {__version__}\n", "")


def test_list_rules_has_a_line_for_every_rule(call: Main) -> None:
    run = call("--list-rules")
    assert run.code == 0
    listed = re.findall(r"^  (\S+) +(error|warning|note) +(.+?)(?:  \(.*\))?$", run.out, re.M)
    assert sorted(listed) == [(r.id, r.severity, r.summary) for r in all_rules().values()]


def test_list_rules_goes_by_subject_and_says_what_has_to_be_asked_for(call: Main) -> None:
    out = call("--list-rules").out
    subjects = re.findall(r"^(\w+)$", out, re.M)
    assert subjects == sorted({rule.group for rule in all_rules().values()})
    asked_for = dict(re.findall(r"^  (\S+) .*  \((only (?:when|with)[^,)]*)", out, re.M))
    assert asked_for == {r.id: r.only_when for r in all_rules().values() if r.only_when}
    assert asked_for["lights-hidden-by-pass"] == "only with --scene or by name"


@pytest.mark.parametrize(
    "args", ["--list-rules --output-format json", "--output-format json --list-rules"]
)
def test_list_rules_as_data(args: str, call: Main) -> None:
    run = call(*args.split())
    assert run.code == 0
    told = json.loads(run.out)
    assert list(told) == ["version", "tool", "rules"]
    assert told["tool"] == {"name": "usdrender-lint", "version": __version__}
    assert [(r["id"], r["group"], r["severity"], r["default"], r["needsScene"], r["renderers"], r["summary"], r["url"]) for r in told["rules"]] == [
        (r.id, r.group, r.severity, r.default, r.needs_scene, list(r.renderers), r.summary, page_url(r.id))
        for r in all_rules().values()
    ]  # fmt: skip
    assert any(r["needsScene"] for r in told["rules"])
    assert any(r["renderers"] for r in told["rules"])


@pytest.mark.parametrize(
    "args",
    [
        "--explain missing-camera --output-format json",
        "--output-format json --color always --explain missing-camera",
    ],
)
def test_explain_as_data(args: str, call: Main) -> None:
    told = json.loads(call(*args.split()).out)
    assert list(told) == ["version", "tool", "rule"]
    page = (ROOT / "rules" / "missing-camera.md").read_text("utf-8")
    (facts,) = [
        rule
        for rule in json.loads(call("--list-rules", "--output-format", "json").out)["rules"]
        if rule["id"] == "missing-camera"
    ]
    assert told["rule"] == {**facts, "page": page}


def test_statistics_stand_instead_of_the_findings(call: Main) -> None:
    for chosen in ("full", "concise"):
        run = call("--statistics", "--output-format", chosen, "failed.usda", "warned.usda")
        assert run.code == 1
        assert run.out.splitlines() == [
            "1  error    unresolved-target       1 file",
            "1  warning  default-settings-unset  1 file",
            "2 findings (1 error, 1 warning) in 2 files.",
        ]
    assert call("--statistics", "clean.usda").out == call("clean.usda").out
    for chosen in ("json", "sarif", "github", "gitlab", "junit"):
        args = ("failed.usda", "--output-format", chosen)
        assert call("--statistics", *args) == call(*args)


def test_a_red_test_is_a_red_job(call: Main) -> None:
    for threshold, failures in (("error", 0), ("warning", 1), ("never", 0)):
        run = call("warned.usda", "--output-format", "junit", "--fail-on", threshold)
        assert (run.code, f'failures="{failures}"' in run.out) == (failures, True)


def test_explain_shows_the_page(call: Main) -> None:
    page = (ROOT / "rules" / "missing-camera.md").read_text("utf-8")
    assert call("--explain", "missing-camera") == Run(0, page, "")


@pytest.mark.parametrize(
    "args",
    ["--color always --explain missing-camera", "--explain missing-camera --color always"],
)
def test_explain_is_rendered_where_there_is_color(args: str, call: Main) -> None:
    run = call(*args.split())
    assert run.code == 0
    assert run.out.startswith("\x1b[")
    assert "```" not in run.out


def test_information_and_option_errors_never_import_usd() -> None:
    """Nor rich, but for a page on a terminal. A shell prompt waits for no stage."""
    script = """
import contextlib, io, sys
from usdrender_lint.__main__ import main
for line in sys.argv[1:]:
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        code = main(line.split())
    heavy = {"pxr", "rich"} & sys.modules.keys()
    print(code, *sorted(heavy))
"""
    lines = {
        "--list-rules": "0",
        "--version": "0",
        "--help": "0",
        "--explain missing-camera": "0",
        "": "2",
        "--selct x clean.usda": "2",
        "--select missing-camra clean.usda": "2",
        "--severity missing-camra=note clean.usda": "2",
        "--ignore ALL clean.usda": "2",
        "missing.usda empty": "2",
        "--explain missing-camera --color always": "0 rich",
    }
    run = python(script, *lines)
    assert run.err == ""
    assert dict(zip(lines, run.out.splitlines(), strict=True)) == lines


def test_completion_never_imports_usd() -> None:
    script = """
import os, sys
from usdrender_lint.__main__ import main
os.environ["_USDRENDER_LINT_COMPLETE"] = "zsh_complete"
os.environ["COMP_WORDS"], os.environ["COMP_CWORD"] = "usdrender-lint --ignore miss", "2"
code = main([])
print(code, *{"pxr", "rich"} & sys.modules.keys(), file=sys.stderr)
"""
    run = python(script)
    assert "missing-camera" in run.out
    assert run.err == "0\n"


# Streams


@pytest.mark.skipif(os.name == "nt", reason="a closed pipe is something else there")
def test_a_closed_pipe_is_the_readers_business() -> None:
    """As in `usdrender-lint ... | head -1`."""
    lines = [f"failed.usda --output-format {chosen}" for chosen in FORMATS]
    lines += ["--list-rules", "--help", "--version", "--explain missing-camera"]
    processes = {line: start(*line.split()) for line in lines}
    for process in processes.values():
        assert process.stdout is not None
        process.stdout.close()
    for line, process in processes.items():
        assert process.stderr is not None
        assert (line, process.stderr.read(), process.wait(60)) == (line, b"", 141)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
def test_a_full_disk_is_told_in_a_sentence() -> None:
    lines = [f"clean.usda --output-format {chosen}" for chosen in FORMATS]
    lines += ["--list-rules", "--help", "--explain missing-camera"]
    with Path("/dev/full").open("wb") as full:
        processes = {line: start(*line.split(), stdout=full.fileno()) for line in lines}
        for line, process in processes.items():
            run = end(process)
            assert (line, run.code) == (line, 2)
            assert re.fullmatch(r"error: .*no space left on device\n", run.err)


@pytest.mark.skipif(os.name == "nt", reason="needs a shell")
def test_a_closed_stream_changes_no_exit_code() -> None:
    shell = ("sh", "-c")
    deaf = start("clean.usda", through=(*shell, 'exec "$0" "$@" >&-'))
    mute = start("failed.usda", "missing.usda", through=(*shell, 'exec "$0" "$@" 2>&-'))
    lost = start("--selct", through=(*shell, 'exec "$0" "$@" 2>&-'))
    assert end(deaf) == Run(2, "", "error: standard output is closed\n")
    run = end(mute)
    assert run.code == 2
    assert FAILED in run.out
    assert end(lost).code == 2


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes")
def test_ctrl_c_ends_quietly(tmp_path: Path) -> None:
    # Nobody reads the pipe, so the program waits in the midst of its work until it is interrupted.
    os.mkfifo(tmp_path / "pipe")
    process = start("missing.usda", "--output-file", str(tmp_path / "pipe"))
    assert process.stderr is not None
    assert process.stderr.readline().startswith(b"error: missing.usda")
    process.send_signal(signal.SIGINT)
    assert end(process) == Run(130, "", "")


def test_quiet_leaves_findings_and_errors(call: Main) -> None:
    assert call("clean.usda", "--quiet") == Run(0, "", "")
    run = call("failed.usda", "missing.usda", "-q", "--output-format", "concise")
    assert run.out.count("\n") == 1
    assert FAILED in run.out
    assert run.err == "error: missing.usda: no such file or folder\n"


@pytest.mark.parametrize("chosen", ["full", "concise"])
def test_verbose_tells_the_renderer_and_what_usd_said(chosen: str, call: Main) -> None:
    args = (str(BROKEN / "missing_sublayer.usda"), "clean.usda", "--output-format", chosen)
    plain, verbose = call(*args), call(*args, "-v")
    more = set(verbose.out.splitlines()) - set(plain.out.splitlines())
    assert any(line.startswith("USD: ") for line in more)
    assert "clean.usda: judged as any: no traces of a renderer." in more
    assert set(plain.out.splitlines()) <= set(verbose.out.splitlines())


@pytest.mark.parametrize("chosen", ["json", "sarif", "github", "gitlab", "junit"])
def test_beside_a_report_for_machines_verbose_speaks_on_standard_error(
    chosen: str, call: Main
) -> None:
    args = (str(BROKEN / "missing_sublayer.usda"), "clean.usda", "--output-format", chosen)
    plain, verbose = call(*args), call(*args, "-v")
    assert (verbose.code, verbose.out) == (plain.code, plain.out)
    more = set(verbose.err.splitlines()) - set(plain.err.splitlines())
    assert any(line.startswith("USD: ") for line in more)
    assert "clean.usda: judged as any: no traces of a renderer." in more


# Files


@pytest.fixture
def out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, show: Path) -> Path:
    """A current folder to write to, with a scene that fails."""
    shutil.copy(show / "failed.usda", tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_reports_are_written_to_files_beside_standard_output(out: Path, call: Main) -> None:
    written = call(
        "failed.usda",
        *("--output-file", "a.json", "--output-file", "b.sarif", "--output-file", "concise:c.txt"),
        *("--output-file", "json:d.sarif", "--output-file", "e.txt", "--output-file", "F.JSON"),
        *("--output-file", "g.xml"),
    )
    assert written.code == 1
    said = {chosen: call("failed.usda", "--output-format", chosen).out for chosen in FORMATS}
    assert written.out == said["full"]
    wanted = {
        "a.json": "json",
        "b.sarif": "sarif",
        "c.txt": "concise",
        "d.sarif": "json",
        "e.txt": "full",
        "F.JSON": "json",
        "g.xml": "junit",
    }
    assert {name: (out / name).read_text("utf-8") for name in wanted} == {
        name: said[chosen] for name, chosen in wanted.items()
    }
    assert {p.name for p in out.iterdir()} == {"failed.usda", *wanted}


def test_a_file_without_a_known_suffix_has_the_format_of_standard_output(
    out: Path, call: Main
) -> None:
    run = call("failed.usda", "--output-format", "json", "--output-file", "report")
    assert (out / "report").read_text("utf-8") == run.out


def test_a_file_is_never_colored(out: Path, call: Main) -> None:
    run = call("failed.usda", "--color", "always", "--output-file", "report")
    assert "\x1b" in run.out
    assert "\x1b" not in (out / "report").read_text("utf-8")


def test_a_file_that_cannot_be_written_costs_no_other_report(
    out: Path, call: Main, monkeypatch: pytest.MonkeyPatch
) -> None:
    replace = Path.replace

    def fails_once(file: Path, target: Path) -> Path:
        if target.name == "bad.json":
            raise OSError(28, "No space left on device")
        return replace(file, target)

    monkeypatch.setattr(Path, "replace", fails_once)
    run = call(
        *("failed.usda", "--exit-zero", "--output-file", "bad.json", "--output-file", "good.json")
    )
    assert run.code == 2
    assert run.err == "error: bad.json cannot be written: no space left on device\n"
    assert FAILED in run.out
    assert FAILED in (out / "good.json").read_text("utf-8")


def test_an_old_report_stays_whole_until_the_new_one_is(
    out: Path, call: Main, monkeypatch: pytest.MonkeyPatch
) -> None:
    old = out / "report.json"
    old.write_text("the old one", "utf-8")

    def fails(*_: object) -> Path:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(Path, "replace", fails)
        run = call("failed.usda", "--output-file", "report.json")
    assert run.code == 2
    assert run.err == "error: report.json cannot be written: no space left on device\n"
    assert old.read_text("utf-8") == "the old one"
    assert {p.name for p in out.iterdir()} == {"failed.usda", "report.json"}


@pytest.mark.skipif(os.name == "nt", reason="no such modes")
def test_a_report_keeps_the_modes_and_the_link_of_the_file(out: Path, call: Main) -> None:
    (out / "real.json").write_text("", "utf-8")
    (out / "real.json").chmod(0o604)
    (out / "link.json").symlink_to("real.json")
    call("failed.usda", "--output-file", "link.json", "--output-file", "new.json")
    assert (out / "link.json").is_symlink()
    assert FAILED in (out / "real.json").read_text("utf-8")
    assert stat.S_IMODE((out / "real.json").stat().st_mode) == 0o604
    (out / "plain").touch()
    assert (out / "new.json").stat().st_mode == (out / "plain").stat().st_mode


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes")
def test_a_named_pipe_is_written_to_not_replaced(out: Path, call: Main) -> None:
    pipe = out / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    run = call("failed.usda", "--output-file", "concise:pipe", "--output-format", "concise")
    assert os.read(reader, 65536).decode() == run.out
    os.close(reader)
    assert pipe.is_fifo()


# Environment


def test_the_environment_chooses_the_format(call: Main, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("USDRENDER_LINT_OUTPUT_FORMAT", "json")
    assert json.loads(call("clean.usda").out)["version"] == 1
    assert call("clean.usda", "--output-format", "full").out == "No findings in 1 file.\n"
    monkeypatch.setenv("USDRENDER_LINT_OUTPUT_FORMAT", "")
    assert call("clean.usda").out == "No findings in 1 file.\n"


def test_a_wrong_format_in_the_environment_is_an_error(
    call: Main, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("USDRENDER_LINT_OUTPUT_FORMAT", "xml")
    run = call("clean.usda")
    assert run.code == 2
    assert "(env var: 'USDRENDER_LINT_OUTPUT_FORMAT'): 'xml' is not one of" in run.err
    assert run.out == ""


@pytest.mark.parametrize(
    ("colored", "terminal", "option", "environment"),
    [
        (False, False, "", {}),
        (True, True, "", {}),
        (False, True, "", {"TERM": "dumb"}),
        (False, True, "", {"NO_COLOR": "1"}),
        (True, True, "", {"NO_COLOR": ""}),
        (True, False, "", {"FORCE_COLOR": "1"}),
        (True, True, "", {"FORCE_COLOR": "1", "TERM": "dumb"}),
        (False, False, "", {"FORCE_COLOR": ""}),
        (False, False, "", {"FORCE_COLOR": "1", "NO_COLOR": "1"}),
        (True, False, "always", {}),
        (True, False, "always", {"NO_COLOR": "1"}),
        (True, False, "always", {"TERM": "dumb"}),
        (False, True, "never", {}),
        (False, True, "never", {"FORCE_COLOR": "1"}),
        (False, True, "auto", {"NO_COLOR": "1"}),
    ],
)
def test_color(
    colored: bool,
    terminal: bool,
    option: str,
    environment: dict[str, str],
    call: Main,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """--color over NO_COLOR over FORCE_COLOR over a terminal that can."""
    monkeypatch.setenv("TERM", "xterm")
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(sys.stdout, "isatty", lambda: terminal)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal)
    run = call("failed.usda", "missing.usda", *(["--color", option] if option else []))
    assert ("\x1b[" in run.out, "\x1b[" in run.err) == (colored, colored)


def test_each_stream_is_colored_by_what_it_is(call: Main, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    run = call("failed.usda", "missing.usda")
    assert "\x1b[" not in run.out
    assert "\x1b[" in run.err


def test_what_machines_read_is_never_colored(call: Main) -> None:
    for chosen in set(FORMATS) - {"full", "concise"}:
        run = call("failed.usda", "--output-format", chosen, "--color", "always")
        assert "\x1b" not in run.out
        if chosen in ("json", "sarif", "gitlab"):
            json.loads(run.out)


@pytest.mark.parametrize(
    ("linked", "terminal", "option", "environment"),
    [
        (True, True, "auto", {}),
        (True, True, "always", {}),
        (False, True, "never", {}),
        (False, True, "auto", {"NO_COLOR": "1"}),
        (False, True, "always", {"TERM": "dumb"}),
        (False, False, "always", {}),
        (False, False, "auto", {"FORCE_COLOR": "1"}),
    ],
)
def test_hyperlinks_are_for_terminals(
    linked: bool,
    terminal: bool,
    option: str,
    environment: dict[str, str],
    out: Path,
    call: Main,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("TERM", "xterm")
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(sys.stdout, "isatty", lambda: terminal)
    run = call("failed.usda", "--color", option, "--output-file", "full:report.txt")
    assert ("\x1b]8;;" in run.out) == linked
    assert "\x1b" not in (out / "report.txt").read_text("utf-8")


def test_on_a_real_terminal() -> None:
    pty = pytest.importorskip("pty")
    master, slave = pty.openpty()
    process = start(
        "--explain", "missing-camera", stdout=slave, environment={"TERM": "xterm-256color"}
    )
    os.close(slave)
    said = os.read(master, 64)
    process.kill()
    process.wait(60)
    os.close(master)
    assert said.startswith(b"\x1b[1;4mmissing-camera")


# Names


def names_to_fear() -> list[str]:
    """What breaks terminals, rich's markup and emoji codes, URIs, and lines."""
    return [
        ":camera:[bold][x].usda",
        "[/bold].usda",
        "50%20off?#.usda",
        "new\nline.usda",
        "red\x1b[31m.usda",
        "right\u202eleft.usda",
        "film é 😀.usda",
    ]


@pytest.mark.skipif(os.name == "nt", reason="no such names there")
def test_names_reach_the_reader_unharmed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: Main
) -> None:
    monkeypatch.chdir(tmp_path)
    names = names_to_fear()
    for name in names:
        Path(name).parent.mkdir(exist_ok=True)
        Path(name).write_text(SCENES["failed.usda"], "utf-8")
    lines = call(".", "--output-format", "concise", "-q").out.splitlines()
    visible = {
        n.replace("\n", r"\n").replace("\x1b", r"\x1b").replace("\u202e", r"\u202e") for n in names
    }
    assert {line.partition(".usda:")[0] + ".usda" for line in lines} == visible
    assert len(lines) == len(names)
    full = call(".").out
    assert "\x1b" not in full
    assert "\u202e" not in full
    assert all(f"--> {name}:" in full for name in visible)
    found = json.loads(call(".", "--output-format", "json").out)["findings"]
    assert {finding["path"] for finding in found} == set(names)
    missing = call(*(f"no-{name}" for name in names)).err.splitlines()
    assert {line.split(": ")[1] for line in missing} == {f"no-{name}" for name in visible}


def test_usd_text_reaches_the_reader_unharmed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: Main
) -> None:
    """Neither markup nor emoji codes are read into it, and a pipe is not folded at 80 columns."""
    monkeypatch.chdir(tmp_path)
    asset = "@./:camera:/[bold]/c.usdz[sub/a.usda]@"
    comment = "x" * 60
    text = CLEAN.replace("(\n", f"(\n    subLayers = [{asset}] # {comment} [/Render/X]\n", 1)
    Path("scene.usda").write_text(text, "utf-8")
    run = call("scene.usda")
    assert run.code != 0
    assert f" 3 |     subLayers = [{asset}] # {comment} [/Render/X]\n" in run.out


# Determinism


def test_the_same_bytes_whatever_the_order_and_the_hashes(tmp_path: Path) -> None:
    seed = str(ROOT / "fixtures" / "seed")
    scenes = [*SCENES, str(BROKEN / "missing_sublayer.usda"), "missing.usda", str(BROKEN), seed]

    def begin(hashes: str, paths: list[str]) -> tuple[Path, subprocess.Popen[bytes]]:
        folder = tmp_path / hashes
        folder.mkdir()
        files = [f"--output-file={chosen}:{folder / chosen}" for chosen in FORMATS]
        return folder, start(*files, *paths, environment={"PYTHONHASHSEED": hashes})

    runs = [begin("1", scenes), begin("2", scenes[::-1]), begin("3", [*scenes, *scenes])]
    ended = [end(process) for _, process in runs]
    assert ended[0].code == 2
    assert FAILED in ended[0].out
    assert ended == [ended[0]] * 3
    written = [{c: (folder / c).read_bytes() for c in FORMATS} for folder, _ in runs]
    assert written == [written[0]] * 3
    assert written[0]["full"].decode() == ended[0].out
    found = json.loads(written[0]["json"])["findings"]
    places = [(f["path"], f["line"] or 0, f["column"] or 0, f["rule"]) for f in found]
    assert len({path for path, *_ in places}) > 5
    assert places == sorted(places)

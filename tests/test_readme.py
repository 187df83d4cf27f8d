"""What the Markdown files show is what the program does today.

A generated passage stands between `<!-- generated: NAME -->` and `<!-- end -->`, where NAME is one
of `PASSAGES`, or a command line after `$`, or `source RULE`, or `modules NAMES`. `pytest --update` rewrites them all.
"""

from __future__ import annotations

import ast
import inspect
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Callable
from itertools import groupby
from pathlib import Path
from textwrap import indent
from typing import Any

import click
import pytest
import yaml
from pxr import Sdf

from conftest import ROOT
from usdrender_lint.__main__ import main
from usdrender_lint.cli import command
from usdrender_lint.config.keys import FILE_OF_KEYS, KEYS
from usdrender_lint.config.kinds import faults
from usdrender_lint.config.schema import URL
from usdrender_lint.lint import lint
from usdrender_lint.registry import all_rules
from usdrender_lint.renderers import names, renderer
from usdrender_lint.rule import AnyRule

FILES = ("README.md", "rules/README.md", ".github/CONTRIBUTING.md")

PASSAGE = re.compile(r"(<!-- generated: ([^\n]+) -->\n)(.*?)(<!-- end -->)", re.S)


ACTION: dict[str, Any] = yaml.safe_load((ROOT / "action.yml").read_text("utf-8"))
GITLAB: dict[str, Any] = yaml.safe_load((ROOT / ".gitlab/usdrender-lint.yml").read_text("utf-8"))
HOOKS: list[dict[str, Any]] = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text("utf-8"))
REPOSITORY = "usdrender-lint/usdrender-lint"


def read(file: str) -> str:
    return (ROOT / file).read_text("utf-8")


SHOWN = [(file, found[2]) for file in FILES for found in PASSAGE.finditer(read(file))]


def by_group() -> list[tuple[str, list[AnyRule]]]:
    rules = sorted(all_rules().values(), key=lambda rule: (rule.group, rule.id))
    return [(group, list(found)) for group, found in groupby(rules, lambda rule: rule.group)]


def subjects() -> str:
    """One line a subject, with the first of its worst."""
    lines = ["| subject | rules | for example |", "|---|---:|---|"]
    for group, rules in by_group():
        first = min(rules, key=lambda rule: (not rule.default, rule.severity.rank))
        link = f"[{group}](rules/README.md#{group})"
        lines.append(f"| {link} | {len(rules)} | {cell(first.summary)} |")
    return "\n".join([f"{len(all_rules())} rules:", "", *lines, ""])


def catalogue() -> str:
    lines: list[str] = []
    for group, rules in by_group():
        lines += [f"## {group}", "", "| rule | severity | what it finds |", "|---|---|---|"]
        for rule in rules:
            when = "".join(f" *{word}*" for word in marks(rule))
            lines.append(
                f"| [{rule.id}]({rule.id}.md) | {rule.severity} | {cell(rule.summary)}{when} |"
            )
        lines.append("")
    return "\n".join(lines)


def marks(rule: AnyRule) -> list[str]:
    """When a rule runs, where that is not always."""
    found = []
    if rule.needs_scene:
        found.append("(with `--scene`)")
    elif not rule.default:
        found.append("(when selected)")
    if rule.renderers:
        found.append(f"(for {' and '.join(rule.renderers)})")
    return found


def cell(text: str) -> str:
    return text.replace("|", r"\|")


def renderers() -> str:
    lines = ["| `--renderer` | judges as |", "|---|---|"]
    lines += [f"| `{name}` | {cell(renderer(name).title)} |" for name in names()]
    return "\n".join([*lines, ""])


def source(rule_id: str) -> str:
    return f"```python\n{inspect.getsource(all_rules()[rule_id].check)}```\n"


def modules(named: str) -> str:
    """What each of them says that it answers; as seen from `.github`."""
    lines = ["| module | question |", "|---|---|"]
    for name in named.split():
        folder = ROOT / "src" / "usdrender_lint" / name
        file = folder / "__init__.py" if folder.is_dir() else folder.with_suffix(".py")
        text = ast.get_docstring(ast.parse(file.read_text("utf-8"))) or ""
        path = (folder if folder.is_dir() else file).relative_to(ROOT).as_posix()
        lines.append(f"| [{name}](../{path}) | {cell(text.partition(chr(10))[0])} |")
    return "\n".join([*lines, ""])


def configuration_mistakes() -> str:
    told = (ROOT / "tests" / "configurations" / "readme" / "told.txt").read_text("utf-8")
    return f"```text\n{told}```\n"


def keys() -> str:
    """A line for each key of a configuration."""
    lines = ["| key | default | what it means | for example |", "|---|---|---|---|"]
    for name, key in KEYS.items():
        default = "" if key.default in (None, [], {}) else f"`{json.dumps(key.default)}`"
        lines.append(f"| `{name}` | {default} | {cell(key.means)} | `{cell(key.example)}` |")
    return "\n".join([*lines, ""])


def action_inputs() -> str:
    lines = ["| input | default | |", "|---|---|---|"]
    for name, about in ACTION["inputs"].items():
        default = f"`{about['default']}`" if about["default"] else ""
        lines.append(f"| `{name}` | {default} | {cell(about['description'])} |")
    return "\n".join([*lines, ""])


PASSAGES: dict[str, Callable[[], str]] = {
    "action inputs": action_inputs,
    "subjects": subjects,
    "catalogue": catalogue,
    "renderers": renderers,
    "keys": keys,
    "configuration mistakes": configuration_mistakes,
}


@pytest.fixture
def passage(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> Callable[[str], str]:
    """What stands in a passage of that name."""
    monkeypatch.chdir(ROOT)
    monkeypatch.setenv("COLUMNS", "80")
    for name in ("NO_COLOR", "FORCE_COLOR", "USDRENDER_LINT_OUTPUT_FORMAT"):
        monkeypatch.delenv(name, raising=False)

    def output(line: str) -> str:
        program, *args = shlex.split(line)
        assert program == "usdrender-lint"
        main(args)
        said = capsys.readouterr()
        assert said.err == ""
        kind = "json" if "json" in args else "toml" if "--show-config" in args else "text"
        return f"```{kind}\n{said.out}```\n"

    def write(name: str) -> str:
        kind, _, rest = name.partition(" ")
        if kind == "$":
            return output(rest)
        if kind == "modules":
            return modules(rest)
        return source(rest) if kind == "source" else PASSAGES[name]()

    return write


@pytest.mark.parametrize(("file", "name"), SHOWN, ids=[f"{file}: {name}" for file, name in SHOWN])
def test_a_generated_passage_is_todays(
    file: str, name: str, passage: Callable[[str], str], update: bool
) -> None:
    text = read(file)
    wanted = passage(name)
    if update:
        text = PASSAGE.sub(
            lambda found: found[1] + wanted + found[4] if found[2] == name else found[0], text
        )
        (ROOT / file).write_text(text, "utf-8")
    shown = {found[2]: found[3] for found in PASSAGE.finditer(text)}
    assert shown[name] == wanted, "run pytest --update, and read what has changed"


@pytest.mark.parametrize("file", FILES)
def test_every_marker_belongs_to_a_passage(file: str) -> None:
    """One that is misspelt or never closed would leave its passage as it is for ever."""
    text = read(file)
    passages = PASSAGE.findall(text)
    assert len(re.findall("<!-- *generated", text)) == len(passages)
    assert len(re.findall("<!-- *end", text)) == len(passages)
    assert len({name for _, name, *_ in passages}) == len(passages)


def test_what_is_shown_first_is_what_is_run() -> None:
    shown = re.search(
        r"\.venv/bin/(usdrender-lint .+)\n```\n\n<!-- generated: \$ (.+) -->", read("README.md")
    )
    assert shown
    assert shown[1] == shown[2]


@pytest.mark.parametrize("file", FILES)
def test_command_lines_are_accepted(file: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """No option, rule or format is named that does not exist."""
    monkeypatch.chdir(ROOT)
    blocks = re.findall(r"^```(?:sh|yaml)\n(.*?)^```", read(file), re.S | re.M)
    lines = re.findall(r"(?:^|run: |bin/)(usdrender-lint .+)$", "".join(blocks), re.M)
    lines += re.findall(r"`(usdrender-lint [^`]+)`", read(file))
    for line in lines:
        try:
            command.make_context("usdrender-lint", shlex.split(line, comments=True)[1:])
        except click.exceptions.Exit:
            pass  # --explain has answered
        except click.ClickException as error:
            pytest.fail(f"{line}: {error.format_message()}")


def written_by_hand(file: str) -> str:
    return PASSAGE.sub("", read(file))


def blocks(kind: str, heading: str = "") -> list[str]:
    """The blocks of the README that nobody generates, of one kind, if need be below a heading."""
    text = written_by_hand("README.md")
    if heading:
        (text,) = re.findall(rf"^#+ {re.escape(heading)}\n(.*?)(?=^##|\Z)", text, re.S | re.M)
    found = re.findall(rf"^```{kind}\n(.*?)^```", text, re.S | re.M)
    assert found
    return found


@pytest.mark.parametrize("text", blocks("toml"))
def test_the_configurations_that_are_shown_are_accepted(text: str) -> None:
    assert [*faults(FILE_OF_KEYS, tomllib.loads(text), ())] == []


def test_the_configuration_names_its_schema() -> None:
    assert blocks("toml", "Configuration")[0].startswith(f"#:schema {URL}\n")


def commands_below(heading: str) -> list[list[str]]:
    """The arguments of the command lines in the blocks below a heading."""
    lines = re.findall(r"^usdrender-lint (.+)$", "".join(blocks("sh", heading)), re.M)
    assert lines
    return [shlex.split(line, comments=True) for line in lines]


@pytest.fixture
def shots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a scene that fails, for what is to be done with one's own."""
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "shots"
    folder.mkdir()
    (folder / "x.usda").write_text((ROOT / "fixtures" / "seed" / "passes.usda").read_text("utf-8"))
    return folder


def mend(shots: Path) -> None:
    (shots / "x.usda").write_bytes((ROOT / "fixtures" / "clean" / "film_shot.usda").read_bytes())


def test_a_show_is_adopted_as_shown(shots: Path) -> None:
    heading = "Adopting it on an existing show"
    assert main(["shots"]) == 1
    for args in commands_below(heading):
        assert main(args) == 0
    assert main(["shots"]) == 1
    (text,) = blocks("toml", heading)
    baseline, *others = text.splitlines(keepends=True)
    assert f"With `{baseline.strip()}` in the configuration" in read("README.md")
    configuration = shots.parent / "usdrender-lint.toml"
    configuration.write_text(baseline)
    assert main(["shots"]) == 0
    configuration.write_text("".join(others))
    assert main(["shots"]) == 1
    configuration.write_text(text)
    assert main(["shots"]) == 0


# Suppressions


@pytest.fixture
def suppressions(shots: Path) -> str:
    """The two examples, in a layer that has what they silence."""
    comment, metadata = (indent(text, "    ") for text in blocks("usda", "Suppressions"))
    clean = (ROOT / "fixtures" / "clean" / "film_shot.usda").read_text("utf-8")
    camera = re.compile(r"^ *rel camera = .*\n", re.M)
    assert len(camera.findall(clean)) == 1
    scene = camera.sub(f"    {comment}", clean)
    return scene.replace('def Scope "Render"\n{\n', f'def Scope "Render"\n{{\n{metadata}', 1)


def found_in(scene: str) -> set[str]:
    Path("shots/x.usda").write_text(scene)
    return {finding.rule.id for finding in lint(["shots"]).findings}


def test_suppressions_silence_as_shown(suppressions: str) -> None:
    assert found_in(suppressions) == set()
    assert found_in(suppressions.replace("# usdrender-lint", "#")) == {"unresolved-target"}
    assert found_in(suppressions.replace("usdrenderLint", "other")) >= {"unused-settings"}


# Elsewhere: what others run is read as they read it


def test_every_yaml_block_is_yaml() -> None:
    for text in blocks("yaml"):
        assert isinstance(yaml.safe_load(text), dict)


def test_the_hook_that_is_shown_is_there() -> None:
    (text,) = blocks("yaml", "pre-commit")
    (repo,) = yaml.safe_load(text)["repos"]
    assert repo["repo"] == f"https://github.com/{REPOSITORY}"
    (hook,) = repo["hooks"]
    assert hook["id"] in {known["id"] for known in HOOKS}
    command.make_context("usdrender-lint", [*hook["args"], "x.usda"])


def test_the_workflow_that_is_shown_fits_the_action() -> None:
    (text,) = blocks("yaml", "GitHub Action")
    workflow = yaml.safe_load(text)
    (job,) = workflow["jobs"].values()
    checkout, ours, upload = job["steps"]
    assert ours["uses"].partition("@")[0] == REPOSITORY
    assert ours["with"].keys() <= ACTION["inputs"].keys()
    options, paths = (ours["with"][name].split("\n") for name in ("options", "paths"))
    command.make_context("usdrender-lint", [*filter(None, options), *filter(None, paths)])
    assert checkout["with"] == {"lfs": True}
    assert upload["with"] == {"sarif_file": ours["with"]["sarif-file"]}
    assert upload["if"] == "${{ !cancelled() }}"
    assert workflow["permissions"] == {"contents": "read", "security-events": "write"}


def test_the_gitlab_job_that_is_included_is_there() -> None:
    included, _ = map(yaml.safe_load, blocks("yaml", "GitLab"))
    (remote,) = included.pop("include")
    assert remote == {
        "remote": f"https://raw.githubusercontent.com/{REPOSITORY}/main/.gitlab/usdrender-lint.yml"
    }
    ((name, job),) = included.items()
    assert job["variables"].keys() <= GITLAB[name]["variables"].keys()


def test_the_gitlab_job_of_ones_own_leaves_what_it_announces(shots: Path) -> None:
    _, own = map(yaml.safe_load, blocks("yaml", "GitLab"))
    (job,) = own.values()
    *before, line = job["script"]
    assert all(line.startswith("pip install ") for line in before)
    program, *args = shlex.split(line)
    assert program == "usdrender-lint"
    assert main(args) == 1
    for report in job["artifacts"]["reports"].values():
        assert Path(report).stat().st_size


def test_reports_are_written_as_shown(shots: Path) -> None:
    (args,) = commands_below("Any other CI")
    assert main(args) == 1
    assert Path("junit.xml").read_text("utf-8").startswith("<?xml")
    assert json.loads(Path("render-spec.sarif").read_text("utf-8"))["runs"]


@pytest.mark.parametrize("kind", ["sarif", "json"])
def test_a_farm_lints_as_shown(shots: Path, kind: str) -> None:
    for name in "abcdefgh":
        shutil.copy(shots / "x.usda", shots / f"{name}.usda")
    assert main(["shots", "--output-file", f"whole.{kind}"]) == 1
    names = sorted(f"{path.parent.name}/{path.name}" for path in shots.iterdir())
    Path("stages.txt").write_text("\n".join(names))
    codes, reports = [], []
    (args,) = commands_below("On a render farm")
    at, to = args.index("--shard") + 1, args.index("--output-file") + 1
    number, _, of = args[at].partition("/")
    for part in map(str, range(1, int(of) + 1)):
        args[at] = f"{part}/{of}"
        reports.append(args[to].replace(number, part).replace(".sarif", f".{kind}"))
        codes.append(main([*args[:to], reports[-1], *args[to + 1 :]]))
    assert {*codes} <= {0, 1}
    assert max(codes) == 1
    (merge,) = blocks("python", "On a render farm")
    merged, whole = (
        json.loads(python(merge, *reports).stdout),
        json.loads(Path(f"whole.{kind}").read_text("utf-8")),
    )
    assert fingerprints(merged) == fingerprints(whole)


def fingerprints(report: Any) -> list[Any]:
    if "runs" not in report:
        return sorted(finding["fingerprint"] for finding in report["findings"])
    results = [result for run in report["runs"] for result in run["results"]]
    return sorted(sorted(result["partialFingerprints"].items()) for result in results)


def python(code: str, *args: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code, *args],
        env=os.environ | {"PYTHONPATH": str(ROOT / "src")},
        capture_output=True,
        text=True,
        timeout=60,
    )


@pytest.mark.parametrize("number", [0, 1], ids=["program", "host"])
def test_a_publish_step_does_as_shown(shots: Path, number: int) -> None:
    snippet = blocks("python", "In a publish step of a pipeline")[number]
    run = python(snippet)
    assert run.returncode == 1
    assert "error shots/x.usda 50 <Render/PrimarySettings> is relative" in run.stdout
    assert run.stderr.endswith("not published\n")
    (shots / "x.usda").write_bytes(b"")
    run = python(snippet)
    assert run.returncode == 1
    assert run.stdout == ""
    mend(shots)
    run = python(snippet)
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")


def test_a_host_is_asked_what_it_holds(shots: Path) -> None:
    """Not what was last saved."""
    mend(shots)
    layer = Sdf.Layer.FindOrOpen("shots/x.usda")
    assert lint(["shots"]).findings == ()
    (settings,) = (
        spec
        for spec in layer.GetPrimAtPath("/Render").nameChildren
        if spec.typeName == "RenderSettings"
    )
    settings.relationships["camera"].targetPathList.explicitItems = ["/Gone"]
    (finding,) = lint(["shots"]).findings
    assert finding.rule.id == "unresolved-target"
    assert layer.dirty


def test_shells_are_asked_to_complete_as_shown(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    (text,) = blocks("sh", "Shell completion")
    for line in text.splitlines():
        (name, value) = re.findall(r"(_\w+)=(\w+) usdrender-lint", line)[0]
        monkeypatch.setenv(name, value)
        assert main([]) == 0
        assert "usdrender-lint" in capfd.readouterr().out


@pytest.mark.parametrize("file", FILES)
def test_options_in_the_text_exist(file: str) -> None:
    known = {name for param in command.params for name in (*param.opts, *param.secondary_opts)}
    known |= {"--help", "--update"}
    named = set(re.findall(r"`(--[a-z-]+)", read(file)))
    assert named - known == set()


@pytest.mark.parametrize("file", FILES)
def test_links_lead_somewhere(file: str) -> None:
    here = (ROOT / file).parent
    text = re.sub(r"^(`{3,}).*?^\1$", "", read(file), flags=re.M | re.S)  # no links there
    for path, anchor in re.findall(r"\]\((?!https?:)([^)#]*)(?:#([^)]+))?\)", text):
        target = here / path if path else ROOT / file
        assert target.exists(), path
        if anchor:
            headings = re.findall(r"^#+ (.+)$", target.read_text("utf-8"), re.M)
            assert anchor in [
                re.sub(r"[^a-z0-9-]", "", h.lower().replace(" ", "-")) for h in headings
            ]

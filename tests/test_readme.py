"""What the Markdown files show is what the program does today.

A generated passage stands between `<!-- generated: NAME -->` and `<!-- end -->`, where NAME is one
of `PASSAGES`, or a command line after `$`, or `source RULE`. `pytest --update` rewrites them all.
"""

from __future__ import annotations

import inspect
import json
import re
import shlex
import tomllib
from collections.abc import Callable
from itertools import groupby
from pathlib import Path

import click
import pytest

from conftest import ROOT
from usdrender_lint.__main__ import main
from usdrender_lint.cli import command
from usdrender_lint.config.keys import FILE_OF_KEYS, KEYS
from usdrender_lint.config.kinds import faults
from usdrender_lint.config.schema import URL
from usdrender_lint.registry import all_rules
from usdrender_lint.renderers import names, renderer
from usdrender_lint.rule import AnyRule

FILES = ("README.md", "rules/README.md", ".github/CONTRIBUTING.md")

PASSAGE = re.compile(r"(<!-- generated: ([^\n]+) -->\n)(.*?)(<!-- end -->)", re.S)


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


PASSAGES: dict[str, Callable[[], str]] = {
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


def test_the_configuration_that_is_shown_is_accepted() -> None:
    (text,) = re.findall(r"^```toml\n(#:schema .*?)^```", read("README.md"), re.S | re.M)
    assert text.startswith(f"#:schema {URL}\n")
    assert [*faults(FILE_OF_KEYS, tomllib.loads(text), ())] == []


def commands_below(heading: str) -> list[list[str]]:
    """The arguments of the command lines in the blocks below a heading."""
    below = read("README.md").split(f"\n### {heading}\n")[1].split("\n### ")[0]
    lines = re.findall(r"^usdrender-lint (.+)$", below, re.M)
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


def test_a_show_is_adopted_as_shown(shots: Path) -> None:
    assert main(["shots"]) == 1
    for args in commands_below("Adopting it on an existing show"):
        assert main(args) == 0
    assert main(["shots"]) == 1
    text = read("README.md")
    (line,) = set(re.findall(r"^(?:With `)?(baseline = \"[^\"]+\")", text, re.M))
    (shots.parent / "usdrender-lint.toml").write_text(line)
    assert main(["shots"]) == 0


def test_a_farm_lints_as_shown(shots: Path) -> None:
    (shots.parent / "stages.txt").write_text("shots/x.usda\n")
    codes = []
    for args in commands_below("On a render farm"):
        at = args.index("--shard") + 1
        of = args[at].partition("/")[2]
        for number in range(1, int(of) + 1):
            codes.append(main([*args[:at], f"{number}/{of}", *args[at + 1 :]]))
    assert sorted(codes) == [0] * (len(codes) - 1) + [1]


@pytest.mark.parametrize("file", FILES)
def test_options_in_the_text_exist(file: str) -> None:
    known = {name for param in command.params for name in param.opts} | {"--help", "--update"}
    named = set(re.findall(r"`(--[a-z-]+)", read(file)))
    assert named - known == set()


@pytest.mark.parametrize("file", FILES)
def test_links_lead_somewhere(file: str) -> None:
    here = (ROOT / file).parent
    for path, anchor in re.findall(r"\]\((?!https?:)([^)#]*)(?:#([^)]+))?\)", read(file)):
        target = here / path if path else ROOT / file
        assert target.exists(), path
        if anchor:
            headings = re.findall(r"^#+ (.+)$", target.read_text("utf-8"), re.M)
            assert anchor in [
                re.sub(r"[^a-z0-9-]", "", h.lower().replace(" ", "-")) for h in headings
            ]

"""Does each file get what its configuration asks for, and is a mistake in it told at its place?"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conftest import ROOT
from shows import CLEAN, FAILED, STRAY, WARNED, Call, Write, call, found, show, write
from usdrender_lint import __version__, renderers
from usdrender_lint.cli import command
from usdrender_lint.config import ConfigError, Configuration
from usdrender_lint.config.find import Configurations
from usdrender_lint.config.keys import FILE_OF_KEYS, KEYS
from usdrender_lint.config.kinds import faults
from usdrender_lint.config.own_renderers import FILE_OF_RENDERER
from usdrender_lint.config.places import places
from usdrender_lint.config.schema import URL, schema
from usdrender_lint.config.toml import load
from usdrender_lint.job import Config
from usdrender_lint.registry import all_rules, matching
from usdrender_lint.rule import Severity
from usdrender_lint.wanted import Options, baseline, wanted

__all__ = ["call", "show", "write"]  # fixtures

MISTAKES = ROOT / "tests" / "configurations"


def nearest(file: Path) -> Configuration:
    return Configurations().of(str(file.parent))


# Which file


def test_the_nearest_folder_above_each_file(call: Call, write: Write) -> None:
    write("usdrender-lint.toml", 'ignore = ["unresolved-target"]')
    write("b/usdrender-lint.toml", "")
    for name in ("a/deep/x.usda", "b/deep/x.usda", "x.usda"):
        write(name, FAILED)
    run = call("--output-format", "concise", ".")
    assert run.code == 1
    assert found(run) == ["b/deep/x.usda: unresolved-target"]


def test_it_goes_by_the_file_and_not_by_the_current_folder(
    call: Call, write: Write, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    write("usdrender-lint.toml", 'ignore = ["unresolved-target"]')
    file = write("shots/x.usda", FAILED)
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "usdrender-lint.toml").write_text('select = ["camera"]')
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert call(str(file)).code == 0
    assert call(os.path.relpath(file)).code == 0


def test_the_search_ends_with_the_repository(tmp_path: Path, write: Write) -> None:
    (tmp_path / "usdrender-lint.toml").write_text("oops")
    assert nearest(write("shots/x.usda")).file is None


def test_a_worktree_is_a_repository(tmp_path: Path) -> None:
    (tmp_path / "usdrender-lint.toml").write_text("oops")
    (tmp_path / "tree").mkdir()
    (tmp_path / "tree" / ".git").write_text("gitdir: /elsewhere")
    assert Configurations().of(str(tmp_path / "tree")).file is None


def test_the_folder_of_the_repository_itself_is_asked(write: Write) -> None:
    file = write("usdrender-lint.toml")
    assert nearest(write("shots/x.usda")).file == file


def test_a_table_in_pyproject(call: Call, write: Write) -> None:
    write("pyproject.toml", '[tool.usdrender-lint]\nignore = ["unresolved-target"]\n')
    write("x.usda", FAILED)
    assert call("x.usda").code == 0


def test_the_file_of_its_own_stands_above_pyproject(write: Write) -> None:
    write("pyproject.toml", "[tool.usdrender-lint]\noops = 1\n")
    file = write("usdrender-lint.toml")
    assert nearest(write("x.usda")).file == file


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[tool.ruff]\n",
        '[project]\nname = "usdrender-lint"\n',
        "tool = 3\n# usdrender-lint\n",
        "this is no TOML",
    ],
)
def test_a_pyproject_that_says_nothing_is_passed_over(text: str, write: Write) -> None:
    file = write("usdrender-lint.toml")
    write("shots/pyproject.toml", text)
    assert nearest(write("shots/x.usda")).file == file


def test_an_empty_table_is_a_configuration(write: Write) -> None:
    write("usdrender-lint.toml", 'ignore = ["unresolved-target"]')
    file = write("shots/pyproject.toml", "[tool.usdrender-lint]\n")
    assert nearest(write("shots/x.usda")).file == file


def test_a_link_to_a_file_is_judged_where_it_is_seen(call: Call, write: Write, show: Path) -> None:
    write("a/usdrender-lint.toml", 'ignore = ["unresolved-target"]')
    write("b/x.usda", FAILED)
    (show / "a" / "x.usda").symlink_to("../b/x.usda")
    assert call("a/x.usda").code == 0
    assert call("b/x.usda").code == 1


def test_each_folder_is_looked_at_once(write: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    write("usdrender-lint.toml")
    asked: list[str] = []
    lexists = os.path.lexists
    monkeypatch.setattr(os.path, "lexists", lambda file: asked.append(str(file)) or lexists(file))
    configurations = Configurations()
    for folder in ("a/b", "a/b", "a/c", "a"):
        configurations.of(str(write(f"{folder}/x.usda").parent))
    assert len(asked) == len(set(asked))


def test_without_one_nothing_is_parsed(call: Call, write: Write) -> None:
    """What configurations cost is paid by those who have one."""
    write("x.usda", CLEAN)
    write("pyproject.toml", "[tool.ruff]\n")
    code = (
        "import sys; from usdrender_lint.__main__ import main; main(['-q', 'x.usda']);"
        "print(*(m for m in sys.modules if m.startswith('usdrender_lint.config')"
        " or m.startswith('packaging')))"
    )
    told = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout
    assert set(told.split()) == {"usdrender_lint.config", "usdrender_lint.config.find"}


def test_help_reads_no_configuration(call: Call, write: Write) -> None:
    write("usdrender-lint.toml", "oops")
    assert call("--help").code == 0
    assert call("--version").code == 0
    assert call("--explain", "missing-camera").code == 0
    assert call("--list-rules").code == 0


# The command line and the environment


def test_a_file_named_for_all(call: Call, write: Write) -> None:
    write("usdrender-lint.toml", "oops")
    write("ci/strict.toml", 'ignore = ["unresolved-target"]')
    write("x.usda", FAILED)
    assert call("--config", "ci/strict.toml", "x.usda").code == 0


def test_the_environment_names_one(
    call: Call, write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    write("a.toml", 'ignore = ["unresolved-target"]')
    write("b.toml", "")
    write("x.usda", FAILED)
    monkeypatch.setenv("USDRENDER_LINT_CONFIG", "a.toml")
    assert call("x.usda").code == 0
    assert call("x.usda", "--config", "b.toml").code == 1
    assert call("x.usda", "--isolated").code == 1
    monkeypatch.setenv("USDRENDER_LINT_CONFIG", "")
    assert call("x.usda").code == 1


def test_of_a_file_that_the_environment_names_it_is_told_who_names_it(
    call: Call, write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    write("x.usda", CLEAN)
    monkeypatch.setenv("USDRENDER_LINT_CONFIG", "gone.toml")
    run = call("x.usda")
    assert run.code == 2
    assert "(env var: 'USDRENDER_LINT_CONFIG'): there is no file 'gone.toml'" in run.err


def test_none_is_read(call: Call, write: Write) -> None:
    write("usdrender-lint.toml", "oops")
    write("x.usda", FAILED)
    assert call("--isolated", "x.usda").code == 1


def test_to_read_none_and_one_is_too_much(call: Call, write: Write) -> None:
    write("a.toml")
    write("x.usda", CLEAN)
    run = call("--isolated", "--config", "a.toml", "x.usda")
    assert run.code == 2
    assert "--isolated and --config exclude each other" in run.err


@pytest.mark.parametrize("file", ["missing.toml", ".", ""])
def test_a_file_that_is_named_must_be_there(file: str, call: Call, write: Write) -> None:
    write("x.usda", CLEAN)
    run = call("--config", file, "x.usda")
    assert run.code == 2
    assert run.out == ""
    assert "missing.toml" in run.err or "names no file" in run.err


ABOVE = [
    ('ignore = ["unresolved-target"]', "--select default", 1),
    ('ignore = ["unresolved-target"]', "--extend-select unresolved-target", 1),
    ('ignore = ["unresolved-target"]', "--ignore missing-camera", 0),
    ('ignore = ["unresolved-target"]', "--extend-select camera", 0),
    ('severity = { unresolved-target = "off" }', "", 0),
    ('severity = { unresolved-target = "off" }', "--select unresolved-target", 1),
    ('severity = { unresolved-target = "off" }', "--extend-select unresolved-target", 1),
    ('severity = { unresolved-target = "off" }', "--severity unresolved-target=error", 1),
    ('severity = { unresolved-target = "note" }', "", 0),
    ('severity = { unresolved-target = "note" }', "--severity unresolved-target=error", 1),
    ("", "--severity unresolved-target=off", 0),
    ("", "--severity unresolved-target=off --select unresolved-target,missing-camera", 0),
    ('select = ["camera"]', "", 0),
    ('select = ["camera"]', "--extend-select unresolved-target", 1),
    ('select = ["camera"]\nextend-select = ["unresolved-target"]', "", 1),
    ('select = ["camera"]\nextend-select = ["unresolved-target"]', "--select camera", 0),
    ('extend-select = ["unresolved-target"]\nignore = ["unresolved-target"]', "", 0),
    ('fail-on = "never"', "", 0),
    ('fail-on = "never"', "--fail-on error", 1),
    ('fail-on = "error"\nseverity = { unresolved-target = "warning" }', "", 0),
    ('fail-on = "note"\nseverity = { unresolved-target = "note" }', "", 1),
    ('[per-file-ignores]\n"*.usda" = ["unresolved-target"]', "", 0),
    ('[per-file-ignores]\n"*.usda" = ["unresolved-target"]', "--select default", 0),
    ('[per-file-ignores]\n"shots/" = ["unresolved-target"]', "", 1),
]


@pytest.mark.parametrize(("text", "options", "code"), ABOVE)
def test_the_command_line_stands_above(
    text: str, options: str, code: int, call: Call, write: Write
) -> None:
    write("usdrender-lint.toml", text)
    write("x.usda", FAILED)
    assert call(*options.split(), "x.usda").code == code


def config(write: Write, text: str, options: Options | None = None) -> Config:
    write("usdrender-lint.toml", text)
    return wanted(nearest(write("x.usda")), options or Options())


@pytest.mark.parametrize("key", ["scene", "variants"])
def test_what_is_on_can_be_turned_off(key: str, call: Call, write: Write) -> None:
    def value(text: str, option: bool | None) -> bool:
        asked = config(write, text, Options(**{key: option}))
        return asked.variants if key == "variants" else asked.selection.needs_scene

    assert not value("", None)
    assert value("", True)
    assert value(f"{key} = true", None)
    assert not value(f"{key} = true", False)
    assert not value(f"{key} = false", None)
    write("usdrender-lint.toml", f"{key} = true")
    write("x.usda", CLEAN)
    assert call(f"--no-{key}", "x.usda").code == 0


def test_an_id_stands_above_its_subject_whatever_the_order(write: Write) -> None:
    for lines in (
        ['camera = "off"', 'missing-camera = "error"'],
        ['missing-camera = "error"', 'camera = "off"'],
    ):
        asked = config(write, "[severity]\n" + "\n".join(lines))
        assert asked.severities == {"missing-camera": Severity.ERROR}
        assert matching("camera") & asked.selection.told == {"missing-camera"}


def test_all_and_default_stand_below_subjects(write: Write) -> None:
    asked = config(write, 'severity = { camera = "note", ALL = "error", default = "warning" }')
    assert {asked.severities[rule] for rule in matching("camera")} == {Severity.NOTE}
    assert {asked.severities[rule] for rule in matching("default") - matching("camera")} == {
        Severity.WARNING
    }
    assert {
        asked.severities[r.id]
        for r in all_rules().values()
        if not r.default and r.group != "camera"
    } == {Severity.ERROR}


def test_nothing_selected_is_told_where_it_is_said(call: Call, write: Write) -> None:
    write("usdrender-lint.toml", 'fail-on = "note"\nselect = []\n')
    write("x.usda", CLEAN)
    run = call("x.usda")
    assert run.code == 2
    assert "no rule is selected: nothing would be linted\n  --> usdrender-lint.toml:2:10" in run.err


@pytest.mark.parametrize(
    ("args", "judge"),
    [
        ("--renderer arnold --select karma-data-type,karma-raw-source", "arnold"),
        ("--renderer any --select karma-data-type", "any"),
        ("--renderer omniverse --select empty-product-name", "omniverse"),
    ],
)
def test_rules_for_other_renderers_alone_are_no_run(
    args: str, judge: str, call: Call, write: Write
) -> None:
    write("x.usda", CLEAN)
    run = call("x.usda", *args.split())
    assert run.code == 2
    assert run.err == f"error: no rule that is selected is for {judge}: nothing would be linted\n"
    assert call("x.usda", *args.split(), "--extend-select", "unresolved-target").code == 0


def test_a_rule_that_a_renderer_leaves_out_is_for_it_where_somebody_says_how_bad_it_is(
    call: Call, write: Write
) -> None:
    write("x.usda", CLEAN)
    args = ("--renderer", "omniverse", "--select", "empty-product-name")
    assert call("x.usda", *args, "--severity", "empty-product-name=note").code == 0


def test_rules_for_another_renderer_than_the_configured_one_are_told_where_they_are_selected(
    call: Call, write: Write
) -> None:
    write("usdrender-lint.toml", 'renderer = "arnold"\nselect = ["karma-data-type"]\n')
    write("x.usda", CLEAN)
    run = call("x.usda")
    assert run.code == 2
    said = "no rule that is selected is for arnold: nothing would be linted"
    assert f"{said}\n  --> usdrender-lint.toml:2:10" in run.err


def test_that_no_selected_rule_is_for_the_renderer_of_a_stage_is_noted(
    call: Call, write: Write
) -> None:
    write("x.usda", CLEAN)
    note = "note: no rule that is selected is for the renderer that a stage was judged by"
    run = call("x.usda", "--select", "karma-data-type")
    assert (run.code, run.err) == (0, f"{note}: see --renderer\n")
    assert call("x.usda", "--select", "karma-data-type", "--renderer", "karma").err == ""
    assert call("x.usda", "--select", "karma-data-type,missing-camera").err == ""


# What extends what


def test_what_the_nearer_file_is_silent_about(call: Call, write: Write) -> None:
    write("base.toml", 'ignore = ["unresolved-target"]\nfail-on = "note"')
    write("shots/usdrender-lint.toml", 'extend = "../base.toml"')
    write("shots/x.usda", FAILED)
    assert call("shots/x.usda").code == 0
    write("shots/usdrender-lint.toml", 'extend = "../base.toml"\nignore = []')
    assert call("shots/x.usda").code == 1


def test_a_chain(write: Write) -> None:
    write(
        "a.toml",
        'select = ["camera"]\nextend-select = ["product"]\nexclude = ["a"]\nextend-exclude = ["b"]\n[severity]\ncamera = "error"\nproduct = "note"\n',
    )
    write(
        "b.toml",
        'extend = "a.toml"\nextend-select = ["var"]\nextend-exclude = ["c"]\n[severity]\ncamera = "note"\n',
    )
    file = write("usdrender-lint.toml", 'extend = "b.toml"\nextend-select = ["pass"]\n')
    configuration = nearest(file)
    asked = wanted(configuration, Options())
    chosen = set[str]().union(*map(matching, ("camera", "product", "var", "pass")))
    whole = {r.id for r in all_rules().values() if r.needs_scene}
    assert asked.selection.told == chosen - whole
    assert set(asked.severities.values()) == {Severity.NOTE}
    folder = str(file.parent)
    assert [f"{folder}/{n}" in p for p in configuration.excluded() for n in "abc"].count(True) == 3
    write("b.toml", 'extend = "a.toml"\nselect = ["var"]\nexclude = []\n')
    configuration = nearest(file)
    assert (
        wanted(configuration, Options()).selection.told
        == (matching("var") | matching("pass")) - whole
    )
    assert not any(f"{folder}/{n}" in p for p in configuration.excluded() for n in "abc")


def test_pyproject_may_be_extended(call: Call, write: Write) -> None:
    write("pyproject.toml", '[tool.usdrender-lint]\nignore = ["unresolved-target"]')
    write("shots/usdrender-lint.toml", 'extend = "../pyproject.toml"')
    write("shots/x.usda", FAILED)
    assert call("shots/x.usda").code == 0


def test_patterns_of_a_folder_above_count_from_there(write: Write) -> None:
    write("usdrender-lint.toml", 'exclude = ["/shots/old/"]')
    file = write("shots/usdrender-lint.toml", 'extend = "../usdrender-lint.toml"')
    (patterns,) = nearest(file).excluded()
    assert str(file.parent / "old" / "x.usda") in patterns


def test_patterns_of_a_folder_elsewhere_count_from_the_show(write: Write, tmp_path: Path) -> None:
    """A studio keeps one file for all its shows."""
    (tmp_path / "studio").mkdir()
    (tmp_path / "studio" / "base.toml").write_text('exclude = ["/old/"]\nroots = ["shots/*.usda"]')
    file = write("usdrender-lint.toml", 'extend = "../studio/base.toml"')
    (patterns,) = nearest(file).excluded()
    assert str(file.parent / "old" / "x.usda") in patterns
    assert wanted(nearest(file), Options()).roots == (str(file.parent / "shots/*.usda"),)


# Values


def test_scopes_are_where_render_prims_belong(call: Call, write: Write) -> None:
    write("x.usda", STRAY)
    assert found(call("--output-format", "concise", "x.usda")) == ["x.usda: misnamed-render-scope"]
    write("usdrender-lint.toml", 'scopes = ["/Renders"]')
    assert call("x.usda").code == 0
    write("x.usda", CLEAN)
    run = call("x.usda")
    assert run.code == 1
    assert "below /Renders" in run.out
    write("usdrender-lint.toml", 'scopes = ["/Render", "/Renders"]')
    assert call("x.usda").code == 0
    write("x.usda", STRAY)
    assert call("x.usda").code == 0


def test_a_scope_in_another_is_read_once(write: Write) -> None:
    asked = config(write, 'scopes = ["/Render/Passes", "/Render", "/RenderTests", "/Render"]')
    assert asked.scopes == ("/Render", "/RenderTests")


def test_a_layer_is_linted_through_the_roots(call: Call, write: Write, show: Path) -> None:
    """They count from the folder of the configuration, wherever somebody lints from."""
    write("shots/a/render.usda", FAILED)
    write(
        "shots/a/shot.usda",
        "#usda 1.0\n(\n    subLayers = [@./render.usda@, @./layout.usda@]\n)\n",
    )
    write(
        "shots/a/layout.usda",
        '#usda 1.0\ndef Xform "World"\n{\n    def Camera "cam"\n    {\n    }\n}\n',
    )
    assert call("shots/a/render.usda").code == 1
    write("usdrender-lint.toml", 'roots = ["shots/*/shot.usda"]\nbaseline = "known.json"')
    write("known.json", '[\n{"version": 1}\n]\n')
    assert "cam> does not exist" not in call("shots/a/render.usda").out
    write("shots/a/layout.usda", "#usda 1.0\n")
    run = call("shots/a/render.usda")
    assert run.code == 1
    assert "in: shots/a/shot.usda" in run.out
    assert call("--update-baseline", "shots/a/render.usda").code == 0
    assert call("shots/a/render.usda").code == 0


def test_the_required_version(call: Call, write: Write) -> None:
    write("x.usda", CLEAN)
    write("usdrender-lint.toml", f'required-version = "=={__version__}"')
    assert call("x.usda").code == 0
    write("usdrender-lint.toml", '\nrequired-version = ">=99"')
    run = call("x.usda")
    assert run.code == 2
    assert run.out == ""
    assert (
        run.err
        == f"""\
error: '>=99' is required here, and this is usdrender-lint {__version__}
  --> usdrender-lint.toml:2:20
   |
 2 | required-version = ">=99"
   |                    ^^^^^^
"""
    )


def test_what_is_ignored_of_a_file_goes_by_the_layer_that_says_it(call: Call, write: Write) -> None:
    write("assets/render.usda", FAILED)
    write(
        "shot.usda",
        '#usda 1.0\n(\n    renderSettingsPrimPath = "/Render/Primary"\n    subLayers = [@./assets/render.usda@]\n)\n',
    )
    assert call("shot.usda").code == 1
    write("usdrender-lint.toml", '[per-file-ignores]\n"assets/**" = ["property"]')
    assert call("shot.usda").code == 0


def test_a_suppression_of_what_is_ignored_of_its_file_is_not_idle(call: Call, write: Write) -> None:
    write("usdrender-lint.toml", '[per-file-ignores]\n"x.usda" = ["unresolved-target"]')
    write(
        "x.usda",
        CLEAN.replace(
            "main_cam>\n", "main_cam>  # usdrender-lint: ignore[unresolved-target] x\n", 1
        ),
    )
    assert found(
        call("--output-format", "concise", "--isolated", "--fail-on", "note", "x.usda")
    ) == ["x.usda: unused-suppression"]
    assert found(call("--output-format", "concise", "--fail-on", "note", "x.usda")) == []


def test_findings_about_suppressions_are_ignored_as_others_are(call: Call, write: Write) -> None:
    write("x.usda", CLEAN.replace("main_cam>\n", "main_cam>  # usdrender-lint: ignore\n", 1))
    assert call("--fail-on", "note", "x.usda").code == 1
    write("usdrender-lint.toml", '[per-file-ignores]\n"x.usda" = ["suppression"]')
    assert call("--fail-on", "note", "x.usda").code == 0


def test_each_file_fails_by_its_own_gate(call: Call, write: Write) -> None:
    write("a/usdrender-lint.toml", 'fail-on = "never"')
    write("a/x.usda", FAILED)
    write("b/x.usda", CLEAN)
    assert call(".").code == 0
    assert call(".", "--fail-on", "error").code == 1
    write("b/x.usda", WARNED)
    assert call(".").code == 1
    junit = call(".", "--output-format", "junit").out
    assert junit.count("<failure ") == 1


def test_a_shared_layer_fails_where_one_of_its_stages_does(call: Call, write: Write) -> None:
    write("render.usda", FAILED)
    for name, gate in (("a", "never"), ("b", "error")):
        write(f"{name}/usdrender-lint.toml", f'fail-on = "{gate}"')
        write(
            f"{name}/shot.usda",
            '#usda 1.0\n(\n    renderSettingsPrimPath = "/Render/Primary"\n    subLayers = [@../render.usda@]\n)\n',
        )
    assert call("a", "b").code == 1
    assert call("a").code == 0


def test_rules_of_all_configurations_are_in_the_report(call: Call, write: Write) -> None:
    write("a/usdrender-lint.toml", 'select = ["camera"]')
    write("b/usdrender-lint.toml", 'select = ["product"]')
    write("a/x.usda", CLEAN)
    write("b/x.usda", CLEAN)
    told = call("a", "b", "--output-format", "sarif").out
    for rule in matching("camera") | matching("product"):
        assert f'"id": "{rule}"' in told or rule in {
            r.id for r in all_rules().values() if r.needs_scene
        }


# Baselines


def test_a_baseline_stands_beside_its_configuration(
    call: Call, write: Write, show: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    write("usdrender-lint.toml", 'baseline = "lint/known.json"')
    write("lint/.keep")
    write("shots/a/x.usda", FAILED)
    run = call("--update-baseline", "shots/a/x.usda")
    assert run.code == 0
    known = (show / "lint" / "known.json").read_text()
    assert '"layer": "shots/a/x.usda"' in known
    for folder in (show, show / "shots" / "a", tmp_path):
        monkeypatch.chdir(folder)
        assert call(str(show / "shots")).code == 0
    assert call("--no-ignores", str(show)).code == 1
    assert call("--isolated", str(show)).code == 1
    assert call("--update-baseline", str(show)).code == 0
    assert (show / "lint" / "known.json").read_text() == known


def test_a_show_without_a_repository_has_a_baseline(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "other"
    (folder / "shots").mkdir(parents=True)
    (folder / "usdrender-lint.toml").write_text('baseline = "known.json"')
    (folder / "shots" / "x.usda").write_text(FAILED)
    assert call("--update-baseline", str(folder)).code == 0
    assert '"layer": "shots/x.usda"' in (folder / "known.json").read_text()
    for here in ("/", str(tmp_path), str(folder), str(folder / "shots")):
        monkeypatch.chdir(here)
        assert call(str(folder)).code == 0


def test_two_shows_in_one_run_have_a_baseline_each(call: Call, write: Write, show: Path) -> None:
    for name in "ab":
        write(f"{name}/.git/HEAD")
        write(f"{name}/usdrender-lint.toml", 'baseline = "known.json"')
        write(f"{name}/x.usda", FAILED)
    assert call("a", "--update-baseline").code == 0
    assert call("b", "--update-baseline").code == 0
    known = (show / "a" / "known.json").read_text()
    assert (show / "b" / "known.json").read_text() == known
    run = call("a", "b")
    assert run.code == 0
    assert "2 in the baseline" in run.out
    assert call("a", "b", "--update-baseline").code == 0
    assert (show / "a" / "known.json").read_text() == known
    write("a/x.usda", CLEAN)
    run = call("a", "b")
    assert run.err.count("holds 1 finding that is gone") == 1


def test_a_baseline_that_is_not_there_is_told(call: Call, write: Write) -> None:
    write("usdrender-lint.toml", 'baseline = "known.json"')
    write("x.usda", CLEAN)
    run = call("x.usda")
    assert run.code == 2
    assert "known.json: no such baseline; --update-baseline makes one" in run.err


def test_an_update_needs_a_baseline(call: Call, write: Write) -> None:
    write("x.usda", CLEAN)
    run = call("--update-baseline", "x.usda")
    assert run.code == 2
    assert "needs --baseline FILE, or one in a configuration" in run.err


def test_the_baseline_of_the_command_line_stands_above(call: Call, write: Write) -> None:
    write("usdrender-lint.toml", 'baseline = "known.json"')
    write("x.usda", FAILED)
    assert call("--update-baseline", "--baseline", "other.json", "x.usda").code == 0
    assert call("--baseline", "other.json", "x.usda").code == 0
    assert baseline(nearest(write("x.usda", FAILED))) is not None


# Renderers of one's own

OUR_RENDERER = """\
title = "Ours"
product-types = ["holdout"]

[severity]
unresolved-target = "off"

[evidence]
namespaces = ["ours"]
"""


def test_a_renderer_of_ones_own(call: Call, write: Write) -> None:
    write("usdrender-lint.toml", 'renderers = ["tools/our_renderer.toml"]')
    write("tools/our_renderer.toml", OUR_RENDERER)
    write("x.usda", FAILED)
    assert call("x.usda").code == 1
    run = call("--renderer", "our_renderer", "x.usda")
    assert run.code == 0
    assert "Judged as our_renderer: asked for." in run.out
    write(
        "usdrender-lint.toml", 'renderers = ["tools/our_renderer.toml"]\nrenderer = "our_renderer"'
    )
    assert call("x.usda").code == 0
    assert call("--renderer", "karma", "x.usda").code == 1


def test_its_traces_are_known(call: Call, write: Write) -> None:
    write("usdrender-lint.toml", 'renderers = ["our_renderer.toml"]')
    write("our_renderer.toml", OUR_RENDERER)
    write("x.usda", FAILED.replace("rel camera", "int ours:samples = 3\n        rel camera"))
    run = call("x.usda")
    assert run.code == 0
    assert "Judged as our_renderer: properties in the namespace 'ours'." in run.out


def test_a_renderer_of_another_show_is_unknown(call: Call, write: Write) -> None:
    write("a/usdrender-lint.toml", 'renderers = ["../our_renderer.toml"]')
    write("our_renderer.toml", OUR_RENDERER)
    write("a/x.usda", CLEAN)
    write("b/x.usda", CLEAN)
    assert call("--renderer", "our_renderer", "a/x.usda").code == 0
    run = call("--renderer", "our_renderer", "a/x.usda", "b/x.usda")
    assert run.code == 2
    assert run.err == "error: unknown renderer 'our_renderer'\n"


def test_what_a_file_of_a_renderer_may_say_is_what_is_read() -> None:
    documented = re.findall(r"^    \[?([a-z-]+)(?:\]| = )", renderers.__doc__ or "", re.M)
    assert sorted(FILE_OF_RENDERER.keys) == sorted(documented)
    for name in renderers.names():
        text = (Path(renderers.__file__).parent / f"{name}.toml").read_text("utf-8")
        assert [*faults(FILE_OF_RENDERER, tomllib.loads(text), ())] == []


# Mistakes


@pytest.mark.parametrize("name", sorted(path.name for path in MISTAKES.iterdir() if path.is_dir()))
def test_a_mistake_is_told_at_its_place(
    name: str,
    call: Call,
    expect_text: Callable[[Path, str], None],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    monkeypatch.chdir(MISTAKES / name)
    (tmp_path / "x.usda").write_text(CLEAN)
    file = "pyproject.toml" if Path("pyproject.toml").exists() else "usdrender-lint.toml"
    run = call("--config", file, str(tmp_path / "x.usda"))
    assert run.code == 2
    assert run.out == ""
    expect_text(MISTAKES / name / "told.txt", run.err.replace(str(MISTAKES / name), "."))


def test_a_mistake_is_told_though_other_files_are_right(call: Call, write: Write) -> None:
    write("a/usdrender-lint.toml", 'selct = ["camera"]')
    write("a/x.usda", CLEAN)
    write("b/x.usda", CLEAN)
    run = call("a", "b", "--exit-zero")
    assert run.code == 2
    assert run.out == ""
    assert "a/usdrender-lint.toml:1:1" in run.err


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"\xef\xbb\xbfselect = []", "begins with a UTF-8 byte order mark"),
        (b'# \xff\nselect = ["default"]', "not UTF-8 from here on\n  --> usdrender-lint.toml:1:3"),
        (b"select = " + b"[" * 5000 + b"]" * 5000, "nested too deeply"),
    ],
    ids=["bom", "latin", "deep"],
)
def test_what_is_no_text(data: bytes, said: str, call: Call, write: Write) -> None:
    write("usdrender-lint.toml").write_bytes(data)
    write("x.usda", CLEAN)
    run = call("x.usda")
    assert run.code == 2
    assert said in run.err


def test_a_folder_of_that_name_is_told(call: Call, write: Write, show: Path) -> None:
    (show / "usdrender-lint.toml").mkdir()
    write("x.usda", CLEAN)
    run = call("x.usda")
    assert run.code == 2
    assert "cannot be read: is a directory" in run.err


def test_a_cycle(call: Call, write: Write) -> None:
    write("usdrender-lint.toml", 'extend = "a.toml"')
    write("a.toml", '# a\nextend = "./sub/../usdrender-lint.toml"')
    write("x.usda", CLEAN)
    run = call("x.usda")
    assert run.code == 2
    assert "extends itself" in run.err
    assert "a.toml:2:10" in run.err


def test_line_breaks_of_windows_move_nothing(call: Call, write: Write) -> None:
    write("usdrender-lint.toml").write_bytes(b'# a\r\nignore = [\r\n  "camera",\r\n  "oops"]\r\n')
    write("x.usda", CLEAN)
    assert 'usdrender-lint.toml:4:3\n   |\n 4 |   "oops"]\n' in call("x.usda").err


# Places

KEY = st.one_of(
    st.text("abcABC019_-", min_size=1, max_size=6),
    st.text(st.characters(codec="utf-8", exclude_characters="\r"), max_size=6),
)
SCALAR = st.one_of(
    st.booleans(),
    st.integers(-(10**6), 10**6),
    st.text(st.characters(codec="utf-8", exclude_characters="\r"), max_size=12),
    st.datetimes(),
    st.dates(),
    st.times(),
)
VALUE = st.recursive(
    SCALAR,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(KEY, inner, max_size=3),
    max_leaves=6,
)


def quoted(text: str, draw: Callable[[Any], Any]) -> str:
    styles = ["basic"]
    if not any(c in text for c in "'\n") and all(
        (c >= " " and c != "\x7f") or c == "\t" for c in text
    ):
        styles.append("literal")
    if not any((c < " " and c not in "\n\t") or c == "\x7f" for c in text):
        styles.append("long")
        if "'''" not in text and not text.startswith("\n"):
            styles.append("long literal")
    match draw(st.sampled_from(styles)):
        case "literal":
            return f"'{text}'"
        case "long":
            inside = text.replace("\\", "\\\\").replace('"""', '""\\"')
            return f'"""\n{inside}"""'
        case "long literal":
            return f"'''{text}'''"
        case _:
            safe = "".join(f"\\u{ord(c):04X}" if c < " " or c in '"\\\x7f' else c for c in text)
            return f'"{safe}"'


def written(value: Any, draw: Callable[[Any], Any]) -> str:
    """In one of the ways that TOML has."""
    space = draw(st.sampled_from(["", " ", "\t"]))
    match value:
        case bool():
            return str(value).lower()
        case str():
            return quoted(value, draw)
        case list():
            gap = draw(st.sampled_from(["", " ", "\n  ", " # a ] comment\n"]))
            inside = f",{gap}".join(written(one, draw) for one in value)
            return f"[{gap}{inside}{',' if value and space else ''}{gap}]"
        case dict():
            pairs = (
                f"{key(name, draw)}{space}={space}{written(one, draw)}"
                for name, one in value.items()
            )
            return f"{{{space}{f',{space}'.join(pairs)}{space}}}"
        case int():
            return str(value)
        case _:
            text = value.isoformat()
            return text.replace("T", draw(st.sampled_from(["T", " "])))


def key(name: str, draw: Callable[[Any], Any]) -> str:
    bare = name.isascii() and name and all(c.isalnum() or c in "_-" for c in name)
    if bare and draw(st.booleans()):
        return name
    text = quoted(name, draw)
    while text.startswith(('"""', "'''")):
        text = (
            quoted(name, draw)
            if "\n" not in name
            else f'"{name.encode("unicode_escape").decode()}"'
        )
    return text


def leaves(value: Any, path: tuple[str | int, ...] = ()) -> Any:
    yield path, value
    if isinstance(value, dict):
        for name, one in value.items():
            yield from leaves(one, (*path, name))
    elif isinstance(value, list):
        for index, one in enumerate(value):
            yield from leaves(one, (*path, index))


@st.composite
def documents(draw: Callable[[Any], Any]) -> str:
    """Pairs, tables, and lists of tables, with comments between."""
    lines: list[str] = []
    for name, value in draw(st.dictionaries(KEY, VALUE, max_size=4)).items():
        lines.append(
            f"{key(name, draw)} = {written(value, draw)}{draw(st.sampled_from(['', '  # x = [']))}"
        )
    for name, rows in draw(
        st.dictionaries(
            st.sampled_from(["t", "t.u", "u.'v w'"]),
            st.lists(st.dictionaries(KEY, VALUE, max_size=2), max_size=3),
            max_size=2,
        )
    ).items():
        for row in rows:
            lines.append(f"[[ {'q.' + name} ]]")
            lines += [f"{key(n, draw)}={written(v, draw)}" for n, v in row.items()]
    return "\n".join(lines) + draw(st.sampled_from(["", "\n", "\n# end"]))


@settings(deadline=None, max_examples=300)
@given(documents())
def test_each_place_holds_its_key_and_its_value(text: str) -> None:
    """What stands at a place, read alone, is what the whole text means there."""
    try:
        whole = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return  # two tables of one name
    found = places(text)
    for path, value in leaves(whole):
        if path in found.values:
            stretch = found.values[path]
            assert tomllib.loads(f"_ = {text[stretch.start : stretch.end]}")["_"] == value
        else:
            assert path == () or path in found.keys
        if path and isinstance(path[-1], str):
            stretch = found.keys[path]
            assert list(tomllib.loads(f"{text[stretch.start : stretch.end]} = 0")) == [path[-1]]
    assert set(found.values) <= {path for path, _ in leaves(whole)}


# The list of keys


@pytest.mark.parametrize("name", KEYS)
def test_the_example_of_a_key_is_accepted(name: str, call: Call, write: Write) -> None:
    write("base/usdrender-lint.toml")
    write("tools/our_renderer.toml", OUR_RENDERER)
    example = KEYS[name].example.replace('"../', '"base/')
    file = write("usdrender-lint.toml", f"{name} = {example}")
    assert isinstance(wanted(nearest(file), Options()), Config)


def test_the_options_of_keys_exist() -> None:
    known = {name for param in command.params for name in param.opts}
    assert {key.option for key in KEYS.values() if key.option} <= known


# For editors

SCHEMA = ROOT / "src" / "usdrender_lint" / "usdrender-lint.schema.json"


def test_the_schema_is_made_of_the_keys(expect_text: Callable[[Path, str], None]) -> None:
    expect_text(SCHEMA, json.dumps(schema(), indent=1, ensure_ascii=False) + "\n")


def test_the_schema_is_where_its_name_says() -> None:
    assert URL.endswith(f"/main/{SCHEMA.relative_to(ROOT).as_posix()}")


def test_the_schema_is_one() -> None:
    jsonschema.Draft7Validator.check_schema(schema())


@pytest.mark.parametrize("name", KEYS)
def test_the_schema_takes_what_the_program_takes(name: str) -> None:
    jsonschema.validate(tomllib.loads(f"{name} = {KEYS[name].example}"), schema())
    if KEYS[name].default is not None:
        jsonschema.validate({name: KEYS[name].default}, schema())


WRONG = [
    ("oops", 1),
    ("select", "default"),
    ("select", ["camra"]),
    ("ignore", [1]),
    ("severity", {"camera": "fatal"}),
    ("severity", {"camra": "error"}),
    ("severity", ["camera"]),
    ("fail-on", "warn"),
    ("variants", "yes"),
    ("scopes", "/Render"),
    ("per-file-ignores", {"a": "camera"}),
    ("per-file-ignores", {"a": ["camra"]}),
    ("baseline", 1),
]


@pytest.mark.parametrize(("name", "value"), WRONG)
def test_the_schema_refuses_what_the_program_refuses(name: str, value: object) -> None:
    assert [*faults(FILE_OF_KEYS, {name: value}, ())]
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({name: value}, schema())


@pytest.mark.parametrize(
    ("written", "told"),
    [
        ("fail-on = error", 'error is no value: did you mean "error"?'),
        ("ignore = [unused-settings]", 'unused-settings is no value: did you mean "unused-settings"?'),
        ("scene = True", "True is no value: did you mean true?"),
    ],
)  # fmt: skip
def test_a_value_without_quotes(tmp_path: Path, written: str, told: str) -> None:
    file = tmp_path / "usdrender-lint.toml"
    file.write_text(f"{written}\n")
    with pytest.raises(ConfigError) as refused:
        load(file)
    (wrong,) = refused.value.wrongs
    assert wrong.message == f"not TOML: {told}"
    assert wrong.span is not None
    assert wrong.span.line == 1

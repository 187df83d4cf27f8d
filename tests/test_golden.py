"""Whole reports of every format, to be read in a review. `pytest --update` writes them."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from conftest import ROOT
from usdrender_lint import cli, lint
from usdrender_lint.__main__ import main
from usdrender_lint.formats import FORMATS

GOLDEN = ROOT / "tests" / "golden"

SCENES = {
    "layered": "fixtures/bad/layered/shot.usda",
    "binary": "fixtures/formats/scene.usdc",
    "packaged": "fixtures/formats/scene.usdz",
}
RULES = (
    "unresolved-target",
    "wrong-target-type",
    "dead-target",
    "duplicate-product-name",
    "invalid-resolution",
    "proxy-with-render",
    "dangling-over",
    "per-product-view",
    "default-settings-in-sublayer",
    "default-settings-unresolved",
)
"""A few of each severity, some with related places: a new rule changes no report here."""

SUFFIXES = {"json": "json", "sarif": "sarif", "gitlab": "gitlab.json", "junit": "junit.xml"}


@pytest.mark.parametrize("chosen", FORMATS)
@pytest.mark.parametrize("scene", SCENES)
def test_report(
    scene: str,
    chosen: str,
    expect_text: Callable[[Path, str], None],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(ROOT)
    # A release changes no report here either.
    monkeypatch.setattr(lint, "__version__", "0.0.0")
    args = ["--color", "never", "--output-format", chosen, "--select", ",".join(RULES)]
    assert main([*args, SCENES[scene]]) == cli.FINDINGS
    said = capsys.readouterr()
    assert said.err == ""
    text = without_pages(said.out) if chosen == "sarif" else said.out
    expect_text(GOLDEN / f"{scene}.{SUFFIXES.get(chosen, f'{chosen}.txt')}", text)


def without_pages(text: str) -> str:
    """Of each rule the id: its page is in the report, and would change it with every word."""
    report = json.loads(text)
    for run in report["runs"]:
        driver = run["tool"]["driver"]
        driver["rules"] = [rule["id"] for rule in driver["rules"]]
    return json.dumps(report, indent=2, ensure_ascii=False) + "\n"


def test_no_report_is_left_over() -> None:
    wanted = {f"{s}.{SUFFIXES.get(f, f'{f}.txt')}" for s in SCENES for f in FORMATS}
    assert {file.name for file in GOLDEN.iterdir()} == wanted

"""The scenes under `fixtures`: what is right is met with silence, what is wrong is found at its mark."""

from __future__ import annotations

from pathlib import Path

import pytest

from conftest import ROOT
from usdrender_lint.job import Config
from usdrender_lint.lint import lint
from usdrender_lint.results import Report
from usdrender_lint.rule import Severity
from usdrender_lint.testing import Mark, marked, marks_in, marks_of

FIXTURES = ROOT / "fixtures"


def roots(kind: str) -> list[Path]:
    """Root layers of a folder: files at its top, and `shot.usda` of its subfolders."""
    folder = FIXTURES / kind
    return sorted([*folder.glob("*.usd*"), *folder.glob("*/shot.usda")])


def ids(files: list[Path]) -> list[str]:
    return [f.relative_to(FIXTURES).as_posix() for f in files]


def lint_one(file: Path) -> Report:
    return lint([str(file)], Config(), cwd=ROOT)


@pytest.mark.parametrize("file", roots("clean"), ids=ids(roots("clean")))
def test_clean(file: Path) -> None:
    """Nothing above a note, and nothing left out."""
    report = lint_one(file)
    loud = [f"{f.rule.id}: {f.message}" for f in report.findings if f.severity != Severity.NOTE]
    assert loud == []
    assert report.problems == ()


@pytest.mark.parametrize(
    "file", [*roots("seed"), *roots("bad")], ids=ids([*roots("seed"), *roots("bad")])
)
def test_marked(file: Path, update: bool) -> None:
    """The marks of a scene's text layers are all there is to find."""
    folder = file.parent
    layers = [file] if folder.name in ("seed", "bad") else sorted(folder.rglob("*.usda"))
    report = lint_one(file)
    found = sorted(marks_of(report.findings, folder))
    if update:
        for layer in layers:
            name = layer.relative_to(folder).as_posix()
            own = [m for m in found if m.file == name]
            layer.write_text(marked(layer.read_text("utf-8"), own), "utf-8")
    wanted = sorted(
        mark
        for layer in layers
        for mark in marks_in(layer.relative_to(folder).as_posix(), layer.read_text("utf-8"))
    )
    assert [str(m) for m in found] == [str(m) for m in wanted]
    assert report.problems == ()


@pytest.mark.parametrize("other", ["scene_text.usd", "scene.usdc", "scene.usdz"])
def test_formats_agree(other: str) -> None:
    """One scene says the same in every format, but for lines."""

    def said(name: str) -> list[tuple[str, ...]]:
        report = lint_one(FIXTURES / "formats" / name)
        assert report.problems == ()
        return sorted(
            (f.rule.id, f.severity, f.message, f.prim_path, f.property or "", f.target or "")
            for f in report.findings
        )

    assert said(other) == said("scene.usda")


def test_formats_marks(update: bool) -> None:
    """The text of the scene is marked, and its twin named `.usd` holds the same bytes."""
    scene, twin = (FIXTURES / "formats" / n for n in ("scene.usda", "scene_text.usd"))
    found = sorted(marks_of(lint_one(scene).findings, scene.parent))
    if update:
        text = marked(scene.read_text("utf-8"), found)
        scene.write_text(text, "utf-8")
        twin.write_text(text, "utf-8")
    wanted: list[Mark] = sorted(marks_in(scene.name, scene.read_text("utf-8")))
    assert [str(m) for m in found] == [str(m) for m in wanted]
    assert twin.read_bytes() == scene.read_bytes()

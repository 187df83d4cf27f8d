"""A show in a folder of its own, and the program run in it."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from usdrender_lint.__main__ import main
from usdrender_lint.testing import BASE

HEADER = '#usda 1.0\n(\n    renderSettingsPrimPath = "/Render/Primary"\n)\n'
CLEAN = BASE.replace("#usda 1.0\n", HEADER, 1)
FAILED = CLEAN.replace("camera = </World/main_cam>", "camera = </World/cam>")
WARNED = BASE
STRAY = CLEAN.replace('"Render"', '"Renders"').replace("/Render/", "/Renders/")


@dataclass(frozen=True)
class Run:
    code: int
    out: str
    err: str


Call = Callable[..., Run]
Write = Callable[..., Path]


@pytest.fixture
def call(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, show: Path) -> Call:
    monkeypatch.chdir(show)
    for name in os.environ:
        if name.startswith("USDRENDER_LINT_") or name in ("NO_COLOR", "FORCE_COLOR"):
            monkeypatch.delenv(name)

    def run(*args: str) -> Run:
        code = main(args)
        said = capsys.readouterr()
        return Run(code, said.out, said.err)

    return run


@pytest.fixture
def show(tmp_path: Path) -> Path:
    """The folder of a show; what stands above it is not asked."""
    folder = (tmp_path / "show").resolve()
    (folder / ".git").mkdir(parents=True)
    return folder


@pytest.fixture
def write(show: Path) -> Write:
    def make(name: str, text: str = "") -> Path:
        file = show / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, "utf-8")
        return file

    return make


def found(run: Run) -> list[str]:
    """`path: rule` of each finding of a concise report."""
    lines = [line for line in run.out.splitlines() if "[" in line]
    return [f"{line.split(':')[0]}: {line.split('[')[1].split(']')[0]}" for line in lines]

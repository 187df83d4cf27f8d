"""Does the hook work in somebody else's repository, as pre-commit itself runs it?"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from conftest import ROOT
from usdrender_lint.discover import USD_SUFFIXES

(HOOK,) = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text("utf-8"))
GOOD = (ROOT / "fixtures/clean/film_shot.usda").read_text("utf-8")
BAD = GOOD.replace("rel camera = </", "rel camera = </Gone/", 1)


def git(*arguments: str, cwd: Path) -> str:
    identity = ("-c", "user.name=A", "-c", "user.email=a@example.org")
    done = subprocess.run(
        ["git", *identity, *arguments], cwd=cwd, capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("suffix", USD_SUFFIXES)
def test_the_hook_is_given_every_file_that_the_program_reads(suffix: str) -> None:
    assert re.search(HOOK["files"], f"shots/sh010/render{suffix}")
    assert not re.search(HOOK["files"], f"shots/sh010/render{suffix}.bak")


def test_its_own_configuration_runs_the_same_hook() -> None:
    ours = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text("utf-8"))
    (own,) = [h for repo in ours["repos"] for h in repo["hooks"] if h["id"] == HOOK["id"]]
    for key in ("entry", "require_serial"):
        assert own[key] == HOOK[key]
    assert own["files"].endswith(HOOK["files"])


@pytest.fixture(scope="module")
def show(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A repository with one good layer, one bad, and one that is not ours to judge."""
    folder = tmp_path_factory.mktemp("show")
    git("init", "--quiet", cwd=folder)
    (folder / "good.usda").write_text(GOOD, "utf-8")
    (folder / "bad.usda").write_text(BAD, "utf-8")
    (folder / "notes.txt").write_text("no layer", "utf-8")
    git("add", ".", cwd=folder)
    git("commit", "--quiet", "-m", "Begin", cwd=folder)
    return folder


def test_try_repo(show: Path, tmp_path: Path) -> None:
    if not shutil.which("git") or not (ROOT / ".git").exists():
        pytest.skip("pre-commit takes a hook from a git repository only")
    environment = os.environ | {"PRE_COMMIT_HOME": str(tmp_path / "cache"), "NO_COLOR": "1"}
    environment.pop("PYTHONPATH", None)

    def hook(*files: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            # As of the last commit: only so are the three runs given one environment.
            [
                *(sys.executable, "-m", "pre_commit", "try-repo", str(ROOT), HOOK["id"]),
                *("--ref", "HEAD", "--files", *files),
            ],
            cwd=show,
            env=environment,
            capture_output=True,
            text=True,
            timeout=600,
        )

    failed = hook("good.usda", "bad.usda", "notes.txt")
    if "No matching distribution found" in failed.stdout:
        pytest.skip("no package registry")
    assert failed.returncode == 1, failed.stdout
    assert re.search(r"usdrender-lint\.+Failed", failed.stdout)
    assert "--> bad.usda:" in failed.stdout
    assert "in 2 files." in failed.stdout

    passed = hook("good.usda")
    assert passed.returncode == 0, passed.stdout
    assert re.search(r"usdrender-lint\.+Passed", passed.stdout)

    passed_over = hook("notes.txt")
    assert passed_over.returncode == 0, passed_over.stdout
    assert "(no files to check)Skipped" in passed_over.stdout

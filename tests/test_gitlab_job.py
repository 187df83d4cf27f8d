"""Does the job for GitLab CI leave the two reports that it announces?"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from conftest import ROOT

JOB = yaml.safe_load((ROOT / ".gitlab/usdrender-lint.yml").read_text("utf-8"))["usdrender-lint"]


@pytest.mark.parametrize(
    ("paths", "code"), [("fixtures/clean/film_shot.usda", 0), ("fixtures/clean fixtures/seed", 1)]
)
def test_its_script(tmp_path: Path, paths: str, code: int) -> None:
    if not (sh := shutil.which("sh")):
        pytest.skip("sh is not on the PATH")
    program = tmp_path / "usdrender-lint"
    program.write_text(f'#!{sh}\nexec "{sys.executable}" -m usdrender_lint "$@"\n', "utf-8")
    program.chmod(0o755)
    (tmp_path / "fixtures").symlink_to(ROOT / "fixtures")
    (script,) = JOB["script"]
    search = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        [sh, "-e", "-c", script],
        cwd=tmp_path,
        env=os.environ
        | JOB["variables"]
        | {"USDRENDER_LINT_PATHS": paths, "PATH": search, "PYTHONPATH": str(ROOT / "src")},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == code, done.stderr
    reports = JOB["artifacts"]["reports"]
    told = json.loads((tmp_path / reports["codequality"]).read_text("utf-8"))
    assert bool(told) == bool(code)
    assert (tmp_path / reports["junit"]).read_text("utf-8").startswith("<?xml")

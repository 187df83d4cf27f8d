"""Is the GitHub Action safe with whatever its inputs hold, and does its script do what they say?"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from conftest import ROOT

ACTION: dict[str, Any] = yaml.safe_load((ROOT / "action.yml").read_text("utf-8"))
STEPS = ACTION["runs"]["steps"]
(LINT,) = [step for step in STEPS if step.get("id") == "lint"]
CLEAN = "fixtures/clean/film_shot.usda"
BAD = "fixtures/seed/camera.usda"


def test_no_input_is_pasted_into_a_script() -> None:
    for step in STEPS:
        assert "${{" not in step.get("run", "")
        for key in step:
            assert key in {"name", "id", "uses", "with", "run", "shell", "env"}


def test_every_input_is_used_and_every_one_that_is_used_is_declared() -> None:
    text = (ROOT / "action.yml").read_text("utf-8")
    assert {*re.findall(r"inputs\.([a-z-]+)", text)} == {*ACTION["inputs"]}


def lint(folder: Path, **inputs: str) -> tuple[int, str, str]:
    """Exit code, standard output, and what the step hands on, for these inputs."""
    if not (bash := shutil.which("bash")):
        pytest.skip("bash is not on the PATH")
    program = folder / "usdrender-lint"
    program.write_text(f'#!{bash}\nexec "{sys.executable}" -m usdrender_lint "$@"\n', "utf-8")
    program.chmod(0o755)
    given = {name: str(about.get("default", "")) for name, about in ACTION["inputs"].items()}
    given |= {name.replace("_", "-"): value for name, value in inputs.items()}
    names = {
        env: re.fullmatch(r"\$\{\{ inputs\.(.+) \}\}", text) for env, text in LINT["env"].items()
    }
    done = subprocess.run(
        [bash, "-e", "-c", LINT["run"]],
        cwd=ROOT,
        env=os.environ
        | {env: given[match[1]] for env, match in names.items() if match}
        | {
            "USDRENDER_LINT": str(program),
            "GITHUB_OUTPUT": str(folder / "output"),
            "PYTHONPATH": str(ROOT / "src"),
        },
        capture_output=True,
        text=True,
        timeout=120,
    )
    return done.returncode, done.stdout, (folder / "output").read_text("utf-8")


def test_findings_become_annotations_and_fail_the_step(tmp_path: Path) -> None:
    code, out, handed_on = lint(tmp_path, paths=f"{BAD}\n{CLEAN}\n")
    assert code == 1
    assert out.startswith("::error file=")
    assert handed_on == "exit-code=1\n"


def test_a_report_beside_the_log(tmp_path: Path) -> None:
    sarif = tmp_path / "with a space.sarif"
    code, out, handed_on = lint(
        tmp_path, paths=CLEAN, options="--fail-on=error\n--quiet", sarif_file=str(sarif)
    )
    assert (code, out, handed_on) == (0, "", "exit-code=0\n")
    assert sarif.exists()


def test_what_is_incomplete_is_told_as_such(tmp_path: Path) -> None:
    code, _, handed_on = lint(tmp_path, paths="gone.usda", annotations="false")
    assert (code, handed_on) == (2, "exit-code=2\n")


@pytest.mark.parametrize(
    "nasty", ["$(touch {})", "`touch {}`", "; touch {}", "'; touch {} #", "--output-file={}"]
)
def test_nothing_in_a_path_is_run(tmp_path: Path, nasty: str) -> None:
    touched = tmp_path / "touched"
    code, _, _ = lint(tmp_path, paths=nasty.format(touched))
    assert code == 2
    assert not touched.exists()

"""Does Microsoft's SARIF Multitool, with GitHub's ingestion rules on, find anything to say?

The Multitool is a program of 95 MB from the npm registry. It is installed once, into the cache of
pytest; without npm, or without the registry, the test is skipped and says so.
"""

from __future__ import annotations

import copy
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pytest

from conftest import ROOT

PACKAGE = "@microsoft/sarif-multitool"
GITHUB_RULES = (
    "GH1001.ProvideRequiredLocationProperties",
    "GH1002.InlineThreadFlowLocations",
    "GH1003.ProvideRequiredRegionProperties",
    "GH1004.ReviewArraysThatExceedConfigurableDefaults",
    "GH1005.LocationsMustBeRelativeUrisOrFilePaths",
    "GH1006.ProvideCheckoutPath",
    "GH1007.ProvideFullyFormattedMessageStrings",
    "GH1011.GhasReferenceFinalSchema",
    "GH1013.GhProvideRequiredSarifLogProperties",
    "GH1014.GhasProvideRequiredRunProperties",
    "GH1015.GhasProvideRequiredResultProperties",
    "GH1016.GhasProvideRequiredLocationProperties",
    "GH1017.GhasProvideRequiredPhysicalLocationProperties",
    "GH1018.GhasProvideToolDriver",
    "GH2012.GhasProvideRequiredReportingDescriptorProperties",
)
"""What GitHub asks of an upload. The Multitool leaves some off unless a configuration names them."""


@pytest.fixture(scope="module")
def multitool(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    npm = shutil.which("npm")
    if npm is None:
        pytest.skip("npm is not on the PATH")
    cache = getattr(request.config, "cache", None)
    folder = cache.mkdir("multitool") if cache else tmp_path_factory.mktemp("multitool")
    if not (program := _program(folder)):
        why = _install(npm, folder)
        if not (program := _program(folder)):
            pytest.skip(f"{PACKAGE} cannot be installed: {why}")
    program.chmod(0o755)  # npm 11 does not run the script of the package that does this
    return program


def _install(npm: str, folder: Path) -> str:
    """What npm says. Without a registry it would try again for minutes."""
    patience = ("--fetch-retries", "0", "--fetch-timeout", "20000")
    command = [npm, "install", "--no-audit", "--no-fund", *patience, "--prefix", str(folder)]
    try:
        done = subprocess.run([*command, PACKAGE], capture_output=True, text=True, timeout=120)
    except subprocess.TimeoutExpired:
        return "npm takes too long"
    return done.stderr.strip()[-200:]


def _program(folder: Path) -> Path | None:
    scope = folder / "node_modules" / "@microsoft"
    names = ("Sarif.Multitool", "Sarif.Multitool.exe")
    return next((p for name in names for p in scope.glob(f"sarif-multitool-*/{name}")), None)


@pytest.fixture(scope="module")
def rules(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("multitool") / "rules.json"
    options = {f"{rule}.Options": {"RuleEnabled": "Error"} for rule in GITHUB_RULES}
    file.write_text(json.dumps(options), "utf-8")
    return file


def said_about(multitool: Path, rules: Path, *logs: Path) -> list[dict[str, Any]]:
    """Its errors and warnings. Its exit code is 0 whatever it finds, also for what is no JSON.

    It asks the network for something that it does not need: the proxy that is none spares the wait.
    """
    told = logs[0].with_suffix(".told")
    subprocess.run(
        [
            *(multitool, "validate", *logs, "--rule-kind", "Sarif;Ghas", "--config", rules),
            *("--level", "Error;Warning", "--output", told, "--log", "ForceOverwrite"),
        ],
        check=True,
        capture_output=True,
        env=os.environ | dict.fromkeys(("HTTP_PROXY", "HTTPS_PROXY"), "http://127.0.0.1:9"),
        timeout=300,
    )
    (run,) = json.loads(told.read_text("utf-8-sig"))["runs"]
    (invocation,) = run["invocations"]
    return [*run.get("results", []), *invocation.get("toolExecutionNotifications", [])]


def report(folder: Path, arguments: Iterable[str]) -> Path:
    file = folder / "report.sarif"
    command = [sys.executable, "-m", "usdrender_lint", "--output-file", str(file), *arguments]
    environment = os.environ | {"PYTHONPATH": str(ROOT / "src")}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, timeout=300)
    assert done.returncode in {0, 1, 2}, done.stderr
    return file


def test_nothing_about_all_fixtures_and_a_file_outside_of_the_repository(
    tmp_path: Path, multitool: Path, rules: Path
) -> None:
    outside = tmp_path / "outside" / "shot.usda"
    outside.parent.mkdir()
    outside.write_bytes((ROOT / "fixtures/bad/twenty.usda").read_bytes())
    file = report(tmp_path, ["fixtures", str(outside), "--variants", "--scene"])

    assert len(json.loads(file.read_text("utf-8"))["runs"][0]["results"]) > 100
    assert said_about(multitool, rules, file) == []


def test_nothing_about_a_clean_run(tmp_path: Path, multitool: Path, rules: Path) -> None:
    file = report(tmp_path, ["fixtures/clean/film_shot.usda"])

    assert json.loads(file.read_text("utf-8"))["runs"][0]["results"] == []
    assert said_about(multitool, rules, file) == []


DAMAGES: dict[str, Callable[[dict[str, Any]], object]] = {
    "GH1015": lambda run: run["results"][0]["locations"].clear(),
    "GH2012": lambda run: run["tool"]["driver"]["rules"][0].pop("shortDescription"),
    "GH1006": lambda run: run["results"][0]["locations"][0]["physicalLocation"].update(
        artifactLocation={"uri": "file:///elsewhere/a.usda"}
    ),
}


def test_it_would_tell(tmp_path: Path, multitool: Path, rules: Path) -> None:
    good = json.loads(report(tmp_path, ["fixtures/seed/camera.usda"]).read_text("utf-8"))
    files = []
    for rule, damage in DAMAGES.items():
        log = copy.deepcopy(good)
        damage(log["runs"][0])
        files.append(tmp_path / f"{rule}.sarif")
        files[-1].write_text(json.dumps(log), "utf-8")

    assert {told["ruleId"] for told in said_about(multitool, rules, *files)} >= {*DAMAGES}

"""What does a run cost, beside the least that USD itself needs to open the same stage?

    python tests/benchmarks/shots.py STAGES
    python tests/benchmarks/bench.py STAGES [--runs N] [--only TEXT] [--update-readme]

Whole processes are measured, from start to exit, with what their own children
used: wall time, user + system time, peak memory. The floor is a Python that only
imports `pxr.Usd` and opens the stage masked to /Render (for `--help` and its
like: a Python that does nothing). Floor and tool take turns within one run, so
that a change in the machine's mood meets both; the medians are shown. Wall time is
what people wait for, and means something only on a machine that does nothing else;
processor time is what a farm pays. The table in the README shows both; nobody writes
it by hand.

This process stays small on purpose, and never imports `pxr`: a child's peak
memory cannot be read lower than that of the parent it was started from.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from statistics import median

MANIFEST = "stages.json"
"""What `shots.py` writes: the cases and their roots."""

MASKED_OPEN = """
import sys
from pxr import Usd
for path in sys.argv[1:]:
    Usd.Stage.OpenMasked(path, Usd.StagePopulationMask(["/Render"]))
"""

# Python keeps what it compiled for the next run, as it does of an installed package.
ENVIRONMENT = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
TOOL = (sys.executable, "-m", "usdrender_lint")
WHOLE_OPEN = """
import sys
from pxr import Usd
stage = Usd.Stage.Open(sys.argv[1])
for prim in stage.Traverse():
    pass
"""
INFORMATION = {
    "--help": 0,
    "--version": 0,
    "--list-rules": 0,
    "--explain dead-target": 0,
    "--fail-on nothing": 2,
}
"""What needs no stage, and the exit code of each."""

README = Path(__file__).resolve().parents[2] / "README.md"
TABLE = re.compile(
    r"(<!-- written by tests/benchmarks/bench.py -->\n).*?(<!-- until here -->)", re.S
)

_RSS_UNIT = 1 if sys.platform == "darwin" else 1024


@dataclass(frozen=True, slots=True)
class Case:
    name: str
    floor: tuple[str, ...]
    tool: tuple[str, ...]
    accepted: frozenset[int]
    """Exit codes of the tool that mean a whole run."""


@dataclass(frozen=True, slots=True)
class Sample:
    """One process."""

    wall: float
    cpu: float
    peak: float
    """In MB."""


class MeasureError(Exception):
    """A process did not end as it should: what it cost means nothing."""


def measure(command: Sequence[str], accepted: frozenset[int] = frozenset({0})) -> Sample:
    with tempfile.TemporaryFile() as complaints:
        start = time.perf_counter()
        process = subprocess.Popen(
            command, stdout=subprocess.DEVNULL, stderr=complaints, env=ENVIRONMENT
        )
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.perf_counter() - start
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode not in accepted:
            complaints.seek(0)
            last = complaints.read().decode(errors="replace").strip().rpartition("\n")[2]
            raise MeasureError(f"exit {process.returncode}: {last or 'no message'}")
    cpu = usage.ru_utime + usage.ru_stime
    return Sample(wall, cpu, usage.ru_maxrss * _RSS_UNIT / 1_000_000)


def compare(case: Case, runs: int) -> tuple[Sample, Sample]:
    """Medians of floor and tool, taken in turns, after one of each that warms the caches."""
    floors: list[Sample] = []
    tools: list[Sample] = []
    for run in range(-1, runs):
        floor = measure(case.floor)
        tool = measure(case.tool, case.accepted)
        if run >= 0:
            floors.append(floor)
            tools.append(tool)
    return _median(floors), _median(tools)


def cases(stages: Path) -> list[Case]:
    listed = json.loads((stages / MANIFEST).read_text())["stages"]
    nothing = (sys.executable, "-c", "pass")
    information = [
        Case(f"`{options}`", nothing, (*TOOL, *options.split()), frozenset({code}))
        for options, code in INFORMATION.items()
    ]
    opened = [_stage_case(name, stages / path) for name, path in listed.items()]
    folders = [case for case in opened if case.name.startswith("folder")]
    return [
        *information,
        *opened,
        *(_with(case, option) for case in folders for option in ("-j 1", "-j 2")),
        *(_with(case, "--scene", WHOLE_OPEN) for case in opened if "flat" in case.name),
    ]


def _stage_case(name: str, path: Path) -> Case:
    roots = sorted(path.rglob("*.usda")) if path.is_dir() else [path]
    floor = (sys.executable, "-c", MASKED_OPEN, *map(str, roots))
    return Case(name, floor, (*TOOL, str(path)), frozenset({0, 1}))


def _with(case: Case, option: str, floor: str = MASKED_OPEN) -> Case:
    """The same with an option, for which the floor may be another one."""
    tool = (*TOOL, *option.split(), case.tool[-1])
    least = (*case.floor[:2], floor, *case.floor[3:])
    return Case(f"{case.name}, `{option}`", least, tool, case.accepted)


def _median(samples: Sequence[Sample]) -> Sample:
    return Sample(
        median(s.wall for s in samples),
        median(s.cpu for s in samples),
        median(s.peak for s in samples),
    )


def table_row(name: str, floor: Sample, tool: Sample) -> str:
    cells = (
        name,
        f"{floor.wall:.3f} s (cpu {floor.cpu:.3f})",
        f"{tool.wall:.3f} s (cpu {tool.cpu:.3f})",
        f"{tool.wall / floor.wall:.2f} (cpu {tool.cpu / floor.cpu:.2f})",
        f"{tool.peak:.0f} (floor {floor.peak:.0f})",
    )
    return "| " + " | ".join(cells) + " |"


def readme_table(measured: Sequence[tuple[str, Sample, Sample]], runs: int) -> str:
    rows = [
        "| what is linted | bare usd-core | usdrender-lint | ratio | of processor time | peak memory, bare | peak memory |",
        "|---|---:|---:|---:|---:|---:|---:|",
    ]
    for name, floor, tool in measured:
        cells = (
            name,
            f"{floor.wall:.2f} s",
            f"{tool.wall:.2f} s",
            f"{tool.wall / floor.wall:.2f}",
            f"{tool.cpu / floor.cpu:.2f}",
            f"{floor.peak:.0f} MB",
            f"{tool.peak:.0f} MB",
        )
        rows.append("| " + " | ".join(cells) + " |")
    versions = ", ".join(f"{name} {version(name)}" for name in ("usd-core", "click"))
    about = (
        f"Medians of {runs} runs: time of whole processes, their start included, on "
        f"{os.cpu_count()} cores of {_processor()}, {platform.system()}, "
        f"Python {platform.python_version()}, {versions}."
    )
    return "\n".join([*rows, "", about, ""])


def _processor() -> str:
    try:
        told = Path("/proc/cpuinfo").read_text("utf-8")
    except OSError:
        return platform.processor() or platform.machine()
    named = re.search(r"^model name\s*:\s*(.+)$", told, re.M)
    return named[1] if named else platform.machine()


def main() -> int:
    parser = argparse.ArgumentParser(description="Measure usdrender-lint beside bare usd-core.")
    parser.add_argument("stages", type=Path, help="the folder that shots.py wrote")
    parser.add_argument("--runs", type=int, default=7, metavar="N", help="7 by default")
    parser.add_argument(
        "--only", default="", metavar="TEXT", help="only cases with this in the name"
    )
    parser.add_argument(
        "--update-readme", action="store_true", help="write the table into the README, if all ran"
    )
    arguments = parser.parse_args()
    if arguments.update_readme and arguments.only:
        parser.error("--update-readme needs all cases: without --only")
    if arguments.runs < 1:
        parser.error("--runs must be at least 1")
    if not (arguments.stages / MANIFEST).is_file():
        parser.error(f"no {MANIFEST} in {arguments.stages}: run shots.py first")

    try:
        measure((*TOOL, "--version"))
    except MeasureError as error:
        print(f"the tool does not run: {error}", file=sys.stderr)
        return 2

    failures = 0
    measured: list[tuple[str, Sample, Sample]] = []
    print(
        f"Medians of {arguments.runs} runs, Python {platform.python_version()}, "
        f"{os.cpu_count()} cores, {platform.system()} {platform.machine()}.\n"
    )
    print("| case | floor | tool | ratio | peak MB |")
    print("|---|---|---|---|---|", flush=True)
    for case in cases(arguments.stages):
        if arguments.only not in case.name:
            continue
        try:
            floor, tool = compare(case, arguments.runs)
        except MeasureError as error:
            failures += 1
            print(f"| {case.name} | failed | {error} | | |", flush=True)
        else:
            measured.append((case.name, floor, tool))
            print(table_row(case.name, floor, tool), flush=True)
    if arguments.update_readme and not failures:
        table = readme_table(measured, arguments.runs)
        text = README.read_text("utf-8")
        README.write_text(TABLE.sub(lambda m: m[1] + table + m[2], text), "utf-8")
    return 2 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

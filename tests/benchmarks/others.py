"""How many of the mistakes on the rules' pages do other checkers of USD tell?

    python tests/benchmarks/others.py [--nvidia PATH/TO/nvidia_usd_validate] [--update-readme]

Of each page the first bad and the first good scene are shown to each of them. A mistake counts as
told if it says of the bad scene anything at all that it does not say of the good one.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from pxr import Usd, UsdValidation

from usdrender_lint import __version__
from usdrender_lint.diagnostics import Diagnostics
from usdrender_lint.pages import pages, parse
from usdrender_lint.registry import all_rules
from usdrender_lint.testing import files_of, lint_files, renderer_of

Checker = Callable[[Path], set[str]]

README = Path(__file__).resolve().parents[2] / "README.md"
TABLE = re.compile(
    r"(<!-- written by tests/benchmarks/others.py -->\n).*?(<!-- until here -->)", re.S
)


def scenes(folder: Path) -> Iterator[tuple[str, Path, Path]]:
    """Rule, root layer of the bad scene, root layer of the good one."""
    for rule_id, text in sorted(pages().items()):
        page = parse(text)
        mains = []
        for kind in ("Bad", "Good"):
            where = folder / rule_id / kind.lower()
            for name, layer in files_of(page.cases(kind)[0]).items():
                (where / name).parent.mkdir(parents=True, exist_ok=True)
                (where / name).write_text(layer, "utf-8")
            mains.append(where / "main.usda")
        yield rule_id, mains[0], mains[1]


def opening(main: Path) -> set[str]:
    """What USD says when the stage is opened whole."""
    with Diagnostics() as said:
        try:
            Usd.Stage.Open(str(main))
        except Exception as error:  # noqa: BLE001 whatever it is, it is told
            return {str(error)}
        said.collect()
    return set(said.messages)


def openusd(main: Path) -> set[str]:
    """All validators of OpenUSD's own framework, which usdchecker runs."""
    try:
        stage = Usd.Stage.Open(str(main))
    except Exception as error:  # noqa: BLE001
        return {str(error)}
    found = CONTEXT.Validate(stage)
    return {f"{error.GetName()} {error.GetMessage()}" for error in found}


CONTEXT = UsdValidation.ValidationContext(
    UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
)


NVIDIA = """
import json, sys
from usd_validation_nvidia import ValidationEngine
for line in sys.stdin:
    found = ValidationEngine().validate(line.rstrip()).issues()
    told = [f"{issue.rule and issue.rule.__name__} {issue.message}" for issue in found]
    print(json.dumps(told), flush=True)
"""
"""What its program does, without a start of half a second for each scene."""


def nvidia(program: str) -> Checker:
    python = str(Path(program).with_name("python"))
    running = subprocess.Popen(
        [python, "-c", NVIDIA], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )

    def check(main: Path) -> set[str]:
        assert running.stdin
        assert running.stdout
        print(main, file=running.stdin, flush=True)
        return set(json.loads(running.stdout.readline()))

    return check


def nvidia_version(program: str) -> str:
    done = subprocess.run([program, "--version"], capture_output=True, text=True, check=True)
    return done.stdout.split()[-1]


def ours(rule_id: str, main: Path) -> set[str]:
    rule = all_rules()[rule_id]
    files = {
        file.relative_to(main.parent).as_posix(): file.read_text("utf-8")
        for file in main.parent.rglob("*")
        if file.is_file()
    }
    _, found = lint_files(files, rules=["default", rule_id], renderer=renderer_of(rule))
    return {str(mark) for mark in found if mark.rule == rule_id}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--nvidia", metavar="PROGRAM")
    parser.add_argument("--update-readme", action="store_true", help="write the table into it")
    options = parser.parse_args()
    if options.update_readme and not options.nvidia:
        parser.error("--update-readme needs --nvidia")
    usd = f"usd-core {'.'.join(map(str, Usd.GetVersion()[1:]))}"
    checkers: dict[str, Checker] = {
        f"{usd}, opening the stage": opening,
        f"{usd}, the validators of `usdchecker`": openusd,
    }
    if options.nvidia:
        checkers[f"usd-validation-nvidia {nvidia_version(options.nvidia)}"] = nvidia(options.nvidia)
    ourselves = f"usdrender-lint {__version__}"
    told: dict[str, list[str]] = {name: [] for name in (ourselves, *checkers)}
    count = 0
    with tempfile.TemporaryDirectory() as made:
        for rule_id, bad, good in scenes(Path(made)):
            count += 1
            for name, check in checkers.items():
                clean = {text.replace(str(good.parent), "") for text in check(good)}
                if {text.replace(str(bad.parent), "") for text in check(bad)} - clean:
                    told[name].append(rule_id)
            if ours(rule_id, bad) and not ours(rule_id, good):
                told[ourselves].append(rule_id)
    lines = [f"| checker | tells, of {count} mistakes | which |", "|---|---:|---|"]
    for name, rules in told.items():
        which = "all" if len(rules) == count else ", ".join(rules)
        lines.append(f"| {name} | {len(rules)} | {which} |")
    table = "\n".join([*lines, ""])
    print(table, end="")
    if options.update_readme:
        text = README.read_text("utf-8")
        README.write_text(TABLE.sub(lambda m: m[1] + table + m[2], text), "utf-8")


if __name__ == "__main__":
    main()

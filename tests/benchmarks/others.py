"""How many of the mistakes on the rules' pages do other checkers of USD tell?

    python tests/benchmarks/others.py [--nvidia PATH/TO/nvidia_usd_validate]

Of each page the first bad and the first good scene are shown to each of them. A mistake counts as
told if it says of the bad scene anything at all that it does not say of the good one.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from pxr import Usd, UsdValidation

from usdrender_lint import __version__
from usdrender_lint.pages import pages, parse
from usdrender_lint.registry import all_rules
from usdrender_lint.stage import Diagnostics
from usdrender_lint.testing import files_of, lint_files, renderer_of

Checker = Callable[[Path], set[str]]


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


def nvidia(program: str) -> Checker:
    def check(main: Path) -> set[str]:
        done = subprocess.run([program, str(main)], capture_output=True, text=True)
        said = f"{done.stdout}\n{done.stderr}"
        return {line for line in said.splitlines() if re.search(r"\[\w+\]|Error", line)}

    return check


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
    options = parser.parse_args()
    checkers: dict[str, Checker] = {
        f"usd-core {'.'.join(map(str, Usd.GetVersion()[1:]))}, opening the stage": opening,
        "its validators, as usdchecker runs them": openusd,
    }
    if options.nvidia:
        checkers["usd-validation-nvidia"] = nvidia(options.nvidia)
    told: dict[str, list[str]] = {name: [] for name in (*checkers, "us")}
    count = 0
    with tempfile.TemporaryDirectory() as made:
        for rule_id, bad, good in scenes(Path(made)):
            count += 1
            for name, check in checkers.items():
                clean = {text.replace(str(good.parent), "") for text in check(good)}
                if {text.replace(str(bad.parent), "") for text in check(bad)} - clean:
                    told[name].append(rule_id)
            if ours(rule_id, bad) and not ours(rule_id, good):
                told["us"].append(rule_id)
    print(f"usdrender-lint {__version__}, {count} mistakes, Python {sys.version.split()[0]}")
    for name, rules in told.items():
        few = f": {', '.join(rules)}" if len(rules) < 20 else ""
        print(f"{len(rules):4}  {name}{few}")


if __name__ == "__main__":
    main()

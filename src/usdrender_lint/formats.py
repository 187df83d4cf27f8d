"""Which report is made, in which format, for whom?"""

from __future__ import annotations

import os
import sys
from importlib import import_module
from pathlib import Path

from .console import terminal_width, use_color
from .pages import pages
from .records import dataclass
from .results import Report

FORMATS = ("full", "concise", "json", "sarif", "github", "gitlab", "junit")
WITH_DETAILS = ("full", "concise")
"""Those that have a place for what `--verbose` tells; beside the others it goes to standard error."""
BY_SUFFIX = {".sarif": "sarif", ".json": "json", ".xml": "junit"}


@dataclass(frozen=True, slots=True)
class Style:
    """What a person asked for about the reports, beside their format."""

    statistics: bool
    quiet: bool
    verbose: bool


def prepare(chosen: str) -> None:
    """Load what will be needed: there is time for it while others lint."""
    import_module(f"{__package__}.report.{chosen}")


def render(report: Report, chosen: str, color: str | None, style: Style) -> str:
    """`color` None: for a file."""
    quiet, verbose = style.quiet, style.verbose
    match chosen:
        case "json":
            from .report import json

            return json.render(report)
        case "sarif":
            from .report import sarif

            return sarif.render(report, pages())
        case "github":
            from .report import github

            return github.render(report, quiet=quiet)
        case "gitlab":
            from .report import gitlab

            return gitlab.render(report)
        case "junit":
            from .report import junit

            return junit.render(report)
        case _ if style.statistics:
            from .report import statistics

            return statistics.render(report, color=use_color(color), verbose=verbose, quiet=quiet)
        case "concise":
            from .report import concise

            return concise.render(
                report, color=use_color(color), verbose=verbose, quiet=quiet, base=Path.cwd()
            )
        case _:
            from .report import full

            terminal = color is not None and sys.stdout.isatty()
            return full.render(
                report,
                color=use_color(color),
                width=terminal_width() if terminal else None,
                verbose=verbose,
                quiet=quiet,
                base=Path.cwd(),
                links=terminal and use_color(color) and os.environ.get("TERM") != "dumb",
            )

"""What does SARIF tell of the tool: its rules, with their pages, and what may keep a run from being whole?"""

from __future__ import annotations

import re
from collections.abc import Mapping

from ..pages import MalformedPageError, parse
from ..results import Report
from ..rule import AnyRule, Severity
from . import HOME, NAME, page_url
from .sarif_tables import Json

MAX_DESCRIPTION = 1024
"""GitHub refuses the whole upload for one longer description."""


PRECISION = {Severity.ERROR: "very-high", Severity.WARNING: "high", Severity.NOTE: "medium"}
"""GitHub sorts by it. An error follows from how values are read, a warning guesses what was meant."""
PROBLEM_SEVERITY = {
    Severity.ERROR: "error",
    Severity.WARNING: "warning",
    Severity.NOTE: "recommendation",
}


def driver(report: Report, pages: Mapping[str, str]) -> Json:
    return {
        "name": NAME,
        "fullName": f"{NAME} {report.version}",
        "version": report.version,
        "semanticVersion": report.version,
        "informationUri": HOME,
        "rules": [_descriptor(rule, pages.get(rule.id, "")) for rule in report.rules],
        "notifications": [
            *(_notification_descriptor(kind) for kind in kinds_of(report)),
            *([_SKIPPED_RULE] if report.skipped else []),
        ],
    }


def _descriptor(rule: AnyRule, page: str) -> Json:
    page = _with_absolute_links(page)
    return {
        "id": rule.id,
        "name": _pascal(rule.id),
        "shortDescription": {"text": _cut(rule.summary)},
        "fullDescription": {"text": _cut(_why(page) or rule.summary)},
        "help": {"text": _plain(page) or rule.summary, "markdown": page or rule.summary},
        "helpUri": page_url(rule.id),
        "defaultConfiguration": {"level": rule.severity.value},
        "properties": {
            "precision": PRECISION[rule.severity],
            "problem.severity": PROBLEM_SEVERITY[rule.severity],
            "tags": list(dict.fromkeys(filter(None, ("usd", "render", rule.group)))),
        },
    }


def _notification_descriptor(kind: str) -> Json:
    """GitHub's validation asks of notifications what it asks of rules."""
    text = f"The run is incomplete: {kind.replace('-', ' ')}."
    return {
        "id": kind,
        "name": _pascal(kind),
        "shortDescription": {"text": text},
        "fullDescription": {"text": text},
        "help": {"text": "What could be linted is reported all the same. The exit code is 2."},
        "defaultConfiguration": {"level": "error"},
    }


_SKIPPED_RULE: Json = {
    "id": "skipped-rule",
    "name": "SkippedRule",
    "shortDescription": {"text": "A rule was asked for and did not run."},
    "fullDescription": {"text": "A rule was asked for and did not run; the message says why."},
    "help": {"text": "Rules that need the whole stage run with --scene, or selected by name."},
    "defaultConfiguration": {"level": "note"},
}


def kinds_of(report: Report) -> list[str]:
    return sorted({problem.kind for problem in report.problems})


def _pascal(kebab: str) -> str:
    return "".join(word.capitalize() for word in kebab.split("-"))


def _with_absolute_links(page: str) -> str:
    """Pages link to their neighbours in the same folder, which a scanner's web page has not."""
    return re.sub(r"\]\(([a-z0-9-]+)\.md\)", lambda link: f"]({page_url(link[1])})", page)


def _why(page: str) -> str:
    """The first paragraph of prose, on one line."""
    try:
        paragraph = parse(page).why.partition("\n\n")[0]
    except MalformedPageError:  # of a rule that is not ours: its result must still be told
        return ""
    return _plain(" ".join(paragraph.split()))


def _plain(markdown: str) -> str:
    """Without the marks of Markdown; usda in a fenced block stays as it is."""
    parts = re.split(r"^```.*\n", markdown, flags=re.MULTILINE)
    return "".join(_plain_prose(p) if i % 2 == 0 else p for i, p in enumerate(parts)).strip()


def _plain_prose(markdown: str) -> str:
    headless = re.sub(r"^#+ ", "", markdown, flags=re.MULTILINE)
    # Code comes first: a path expression such as `/World//*` is no emphasis.
    marks = r"`([^`]+)`|\[([^\]]+)\]\([^)]*\)|(?:\*\*|\*)([^*\s][^*\n]*)(?:\*\*|\*)"
    return re.sub(marks, lambda m: m[1] or _plain_prose(m[2] or m[3]), headless)


def _cut(text: str) -> str:
    if len(text) <= MAX_DESCRIPTION:
        return text
    return text[: MAX_DESCRIPTION - 1].rpartition(" ")[0] + "…"

"""What does a CI server that only knows tests show? The report as JUnit's XML.

A suite is a linted stage, a test case what one rule says of one layer in it: servers follow
a case by its class and name through builds ("failing since ..."), so these hold no line, no
number and no message, and no two cases of a suite share them. A case has one failure, since
most servers read no second one; its text holds all findings.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from xml.etree import ElementTree

from ..printable import escaped
from ..results import Located, Problem, Report
from ..rule import Severity
from . import NAME
from .concise import line
from .full import Ink, shown

Suite = defaultdict[tuple[str, str, str], list[Located | Problem]]
"""What belongs to a case, by its class, its name, and the file."""

WITHOUT_FINDINGS = "render-spec"
"""The case of a stage about which there is nothing to say: a suite without cases is an error to some."""


def render(report: Report) -> str:
    """Findings that fail the run are failures, as they are for the exit code: a red test in a green
    job helps nobody. The others stand in the output of a case that passes.

    XML has no way to hold most control characters: they are written as in `full`, `\\x1b`.
    """
    suites: defaultdict[str, Suite] = defaultdict(lambda: defaultdict(list))
    for root in report.files:
        suites[root] = defaultdict(list)
    for finding in report.findings:
        at = finding.location
        # What holds in several stages is told of each: a suite is the whole truth about its stage.
        for root in finding.roots or (at.path,):
            suites[root][shown(at), finding.rule.id, at.path].append(finding)
    for problem in report.problems:
        suites[problem.path][escaped(problem.path), problem.kind, problem.path].append(problem)
    top = ElementTree.Element("testsuites", {"name": NAME})
    top.extend(_suite(root, suite, report.gate(root)) for root, suite in sorted(suites.items()))
    _count(top)
    ElementTree.indent(top)
    text = ElementTree.tostring(top, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _suite(root: str, suite: Suite, fails: Severity | None) -> ElementTree.Element:
    element = ElementTree.Element("testsuite", {"name": escaped(root) or NAME})
    for (layer, name, file), told in sorted(suite.items()):
        element.append(_case(layer or NAME, name, file, told, fails))
    if not suite:
        element.append(_case(escaped(root), WITHOUT_FINDINGS, root, (), fails))
    _count(element)
    return element


def _case(
    layer: str, name: str, file: str, told: Sequence[Located | Problem], fails: Severity | None
) -> ElementTree.Element:
    place = {"file": escaped(file)} if file else {}
    case = ElementTree.Element("testcase", {"name": name, "classname": layer, **place})
    problems = [one for one in told if isinstance(one, Problem)]
    findings = [one for one in told if isinstance(one, Located)]
    failures = [f for f in findings if fails is not None and f.severity.rank <= fails.rank]
    if problems:
        _say(case, "error", problems, problems[0].kind, map(_problem, problems))
    elif failures:
        worst = min(failures, key=lambda finding: finding.severity.rank)
        _say(case, "failure", failures, worst.severity, map(_finding, findings))
    elif findings:
        ElementTree.SubElement(case, "system-out").text = "\n".join(map(_finding, findings))
    return case


def _say(
    case: ElementTree.Element,
    tag: str,
    told: Sequence[Located | Problem],
    kind: str,
    lines: Iterable[str],
) -> None:
    more = f" (and {len(told) - 1} more)" if len(told) > 1 else ""
    message = escaped(told[0].message) + more
    ElementTree.SubElement(case, tag, {"message": message, "type": kind}).text = "\n".join(lines)


def _finding(finding: Located) -> str:
    text = line(finding, Ink(False), with_roots=False)  # the suite is the stage
    return f"{text}\n  help: {escaped(finding.help)}" if finding.help else text


def _problem(problem: Problem) -> str:
    return ": ".join(escaped(part) for part in (problem.path, problem.message) if part)


def _count(element: ElementTree.Element) -> None:
    for name, tag in (("tests", "testcase"), ("failures", "failure"), ("errors", "error")):
        element.set(name, str(sum(1 for _ in element.iter(tag))))

"""Does a rule do what its page says? For the authors of rules, here and elsewhere.

A page's *Bad* and *Good* blocks are tests. A block that begins with `#usda` is a root layer as it
stands; any other gets `HEADER` before it, and so stands as a stronger layer over `BASE`, showing
only what matters. `base.usda` is there for whatever layer asks for it. Marks say what is to be found at the end of which line:

    rel camera = </World/cam1>  # error: camera </World/cam1> does not exist

In a file that shows several rules a mark names its rule, `# error: [unresolved-target] camera ...`,
and a mark that cannot stand at its line names it: `# at line 1: warning: ...`.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from .job import Config
from .lazily import lazily
from .lint import lint
from .model import Suppressions
from .pages import Case, Page
from .registry import all_rules, select
from .results import Located, Report
from .rule import AnyRule, Severity

HEADER = """\
#usda 1.0
(
    renderSettingsPrimPath = "/Render/Primary"
    subLayers = [@./base.usda@]
)
"""

BASE = """\
#usda 1.0
def Scope "Render"
{
    def RenderSettings "Primary"
    {
        rel camera = </World/main_cam>
        rel products = </Render/Beauty>
        uniform int2 resolution = (1920, 1080)
    }
    def RenderProduct "Beauty"
    {
        token productName = "/shots/sh010/beauty.exr"
        rel orderedVars = </Render/Vars/color>
    }
    def Scope "Vars"
    {
        def RenderVar "color"
        {
            uniform token dataType = "color3f"
            uniform string sourceName = "Ci"
        }
    }
}
def Xform "World"
{
    def Camera "main_cam"
    {
        float focalLength = 35
    }
    def Xform "sets"
    {
        def Sphere "table"
        {
        }
    }
    def Xform "characters"
    {
        def Sphere "hero"
        {
        }
    }
    def DistantLight "sun"
    {
    }
}
"""

MARK = lazily(
    r"\#[ ](?:at[ ]line[ ](?P<line>\d+):[ ])?(?P<severity>error|warning|note):"
    r"(?:[ ]\[(?P<rule>[a-z0-9-]+)\])?[ \t]*(?P<text>.*?)"
    r"(?=\s*\#[ ](?:at[ ]line|error:|warning:|note:)|\s*$)"
)


@dataclass(frozen=True, slots=True, order=True)
class Mark:
    """One finding: what a text says is to be found, or what was found."""

    file: str
    line: int
    severity: str
    rule: str
    text: str

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.severity}: [{self.rule}] {self.text}"


def marks_in(file: str, text: str, rule: str | None = None) -> Iterator[Mark]:
    """The marks of a text; `rule` for those that name none."""
    for number, line in enumerate(text.splitlines(), 1):
        for found in MARK.finditer(line):
            named = found["rule"] or rule or ""
            yield Mark(file, int(found["line"] or number), found["severity"], named, found["text"])


def marks_of(findings: Iterable[Located], folder: Path) -> Iterator[Mark]:
    """Findings as marks; files below `folder` by their path from it."""
    for finding in findings:
        file = Path(finding.location.file)
        name = file.relative_to(folder).as_posix() if file.is_relative_to(folder) else str(file)
        line = finding.location.span.line if finding.location.span else 0
        yield Mark(name, line, finding.severity.value, finding.rule.id, finding.message)


def marked(text: str, found: Iterable[Mark], rule: str | None = None) -> str:
    """The text with its marks replaced by what was found; `rule` needs no name in them.

    No line moves: what cannot be said at line 1, which is the header's, is said at line 2, and
    marks that stood apart from their line stay where they were.
    """
    lines = text.split("\n")
    apart = {1: 2}
    for number, line in enumerate(lines, 1):
        apart.update({int(m["line"]): number for m in MARK.finditer(line) if m["line"]})
        lines[number - 1] = MARK.sub("", line).rstrip() if MARK.search(line) else line
    for mark in sorted(found):
        number = apart.get(mark.line, mark.line)
        at = f"at line {mark.line}: " if number != mark.line else ""
        name = f"[{mark.rule}] " if mark.rule != rule else ""
        before = lines[number - 1]
        gap = "  " if before.strip() and not before.endswith("#") else ""
        lines[number - 1] = f"{before}{gap}# {at}{mark.severity}: {name}{mark.text}"
    return "\n".join(lines)


def as_layer(text: str) -> str:
    """A block of a page as a root layer."""
    return text if text.startswith("#usda") else HEADER + text


def lint_files(
    files: Mapping[str, str],
    *,
    rules: Iterable[str] = ("default",),
    renderer: str = "auto",
    folder: Path | None = None,
) -> tuple[Report, list[Mark]]:
    """Write the files, lint `main.usda`, and say what was found as marks."""
    with tempfile.TemporaryDirectory() as made:
        where = (folder or Path(made)).resolve()
        for name, text in files.items():
            file = where / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, "utf-8")
        main = where / "main.usda"
        report = lint([str(main)], Config(select(rules), renderer=renderer), cwd=where)
        return report, sorted(marks_of(report.findings, where))


def files_of(case: Case) -> dict[str, str]:
    """All files of a case, with the base that its main layer may sublayer."""
    main = as_layer(case.main)
    files = {"main.usda": main, **case.files}
    if "base.usda" in main:
        files.setdefault("base.usda", BASE)
    return files


def renderer_of(rule: AnyRule) -> str:
    """By which renderer its page is judged: a rule for some of them speaks nowhere else."""
    return rule.renderers[0] if rule.renderers else "auto"


def lint_bad(rule: AnyRule, files: Mapping[str, str]) -> tuple[Report, list[Mark]]:
    """What the rule says with no other beside it; but whether a suppression is of any use is told
    only where the rules run that it may silence."""
    rules = ["default", rule.id] if rule.on is Suppressions else [rule.id]
    report, found = lint_files(files, rules=rules, renderer=renderer_of(rule))
    return report, [mark for mark in found if mark.rule == rule.id]


def check_page(page: Page) -> list[str]:
    """What a rule's page promises and the rule does not keep; empty when all is true."""
    rule = all_rules()[page.title]
    complaints: list[str] = []
    for case in page.cases("Bad"):
        complaints.extend(_check_bad(rule, case))
    for case in page.cases("Good"):
        complaints.extend(_check_good(rule, case))
    return complaints


def _check_bad(rule: AnyRule, case: Case) -> Iterator[str]:
    files, renderer = files_of(case), renderer_of(rule)
    wanted = sorted(m for name, text in files.items() for m in marks_in(name, text, rule.id))
    report, found = lint_bad(rule, files)
    yield from (f"not reported: {m}" for m in wanted if m not in found)
    yield from (f"not marked: {m}" for m in found if m not in wanted)
    yield from (f"incomplete: {p.message}" for p in report.problems if not wanted)
    if not wanted:
        yield f"the bad block at line {case.line} has no mark"
    _, everything = lint_files(files, rules=["default", rule.id], renderer=renderer)
    places = {(m.file, m.line) for m in wanted}
    for mark in everything:
        if mark.rule != rule.id and (mark.file, mark.line) in places:
            yield f"a second finding at the same place: {mark}"


def _check_good(rule: AnyRule, case: Case) -> Iterator[str]:
    report, found = lint_files(
        files_of(case), rules=["default", rule.id], renderer=renderer_of(rule)
    )
    yield from (
        f"reported in the good block: {m}"
        for m in found
        if m.severity != Severity.NOTE or m.rule == rule.id
    )
    yield from (f"incomplete: {p.message}" for p in report.problems)
    yield from (f"USD says of the good block: {said}" for said in report.chatter)

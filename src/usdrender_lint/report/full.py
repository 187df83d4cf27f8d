"""How does a person read a report? As pictures of the source, and a summary.

Without rich: names and lines of USD files must arrive unchanged, which rich's
markup, emoji codes and wrapping work against, and what color needs is six SGR codes.
All functions return whole lines, with the last line break.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from functools import lru_cache
from pathlib import Path, PurePath

from ..printable import escaped
from ..records import dataclass
from ..results import Located, Location, Place, Problem, Report, Span
from ..rule import Severity
from . import page_url

PIPED_WIDTH = 160
TAB = " " * 4
SHOWN_ROOTS = 3
DRAWN_PLACES = 2

BOLD = "1"
FAINT = "2"
CYAN = "36"
SEVERITY_SGR = {Severity.ERROR: "1;31", Severity.WARNING: "1;33", Severity.NOTE: "1;36"}


@dataclass(frozen=True, slots=True)
class Ink:
    """Colors a piece of text, or leaves it alone."""

    color: bool

    def __call__(self, sgr: str, text: str) -> str:
        return f"\x1b[{sgr}m{text}\x1b[0m" if self.color and text else text


@dataclass(frozen=True, slots=True)
class _Look:
    """What the pictures of one report have in common."""

    ink: Ink
    width: int
    bar: str
    cut: str
    base: Path
    links: bool


def render(
    report: Report,
    *,
    color: bool,
    width: int | None = None,
    unicode: bool = False,
    verbose: bool = False,
    quiet: bool = False,
    base: Path | None = None,
    links: bool = False,
) -> str:
    """All findings, an empty line between them, then the summary unless `quiet`.

    `width` is the terminal's; None means that the text goes elsewhere. Paths are
    shown relative to `base`, by default the current directory. `unicode` allows
    the gutter characters that not every terminal has, `links` makes the names of
    rules lead to their pages.
    """
    bar, cut = ("│", "…") if unicode else ("|", "...")
    look = _Look(Ink(color), width or PIPED_WIDTH, bar, cut, base or Path.cwd(), links)
    parts = ["\n".join(_finding(finding, look)) + "\n" for finding in report.findings]
    if not quiet:
        parts.append(summary(report, verbose=verbose))
    return "\n".join(parts)


def summary(report: Report, *, verbose: bool = False) -> str:
    """How much was looked at, what came of it, and what is missing."""
    lines = [counts(report)]
    if verbose:
        lines[:0] = details(report)
    if judged := _judged(report):
        lines.append(judged)
    if not report.complete:
        lines.append(_incomplete(report.problems))
    return "".join(f"{line}\n" for line in lines)


def details(report: Report) -> list[str]:
    """What USD said, which renderer each stage was judged by, and which rules were left out."""
    skipped = (escaped(f"Skipped {s.rule}: {s.reason}.") for s in report.skipped)
    return [*_chatter(report.chatter), *_choices(report), *skipped]


def problems(report: Report, color: bool) -> str:
    """What kept the run from being complete, a line each, for standard error."""
    error = Ink(color)(SEVERITY_SGR[Severity.ERROR], "error")
    return "".join(
        f"{': '.join((error, *map(escaped, filter(None, (p.path, p.message)))))}\n"
        for p in report.problems
    )


def fault(place: str, span: Span | None, source: str | None, message: str, *, color: bool) -> str:
    """A mistake in a file that is no layer, for standard error."""
    look = _Look(Ink(color), PIPED_WIDTH, "|", "...", Path.cwd(), False)
    sgr = SEVERITY_SGR[Severity.ERROR]
    lines = [f"{look.ink(sgr, 'error')}{look.ink(BOLD, f': {escaped(message)}')}"]
    margin = max(2, len(str(span.line)) if span else 0)
    arrow = look.ink(FAINT, "-->")
    lines.append(f"{' ' * margin}{arrow} {escaped(place)}{position(span)}")
    if span and source is not None:
        lines.append(f"{' ' * margin} {look.ink(FAINT, look.bar)}")
        lines += _source(source, span, "", sgr, margin, look)
    return "".join(f"{line}\n" for line in lines)


def shown(location: Location, base: Path | None = None) -> str:
    """The layer's file as seen from `base`, or as the report has it; and the member of a package."""
    path = escaped((base and _below(location.file, base)) or location.path)
    return f"{path}[{escaped(location.member)}]" if location.member else path


def position(span: Span | None) -> str:
    return f":{span.line}:{span.column}" if span else ""


def spec(prim_path: str, property: str | None) -> str:
    """`</Prim.property>`; nothing for what a layer says about itself."""
    if prim_path == "/" and not property:
        return ""
    return f"<{escaped(f'{prim_path}.{property}' if property else prim_path)}>"


def plural(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def _finding(finding: Located, look: _Look) -> Iterator[str]:
    at = finding.location
    sgr = SEVERITY_SGR[finding.severity]
    drawn = _drawn_places(finding)
    spans = [span for span in (at.span, *(place.location.span for place in drawn)) if span]
    # Two at least, so that the arrows of one file stand below each other.
    margin = max([2, *(len(str(span.line)) for span in spans)])
    rule = _link(finding.rule.id, page_url(finding.rule.id)) if look.links else finding.rule.id
    yield (
        look.ink(sgr, f"{finding.severity}[{rule}]")
        + look.ink(BOLD, f": {escaped(finding.message)}")
    )
    yield _arrow(finding, margin, look)
    if at.span and at.source is not None:
        yield f"{' ' * margin} {look.ink(FAINT, look.bar)}"
        yield from _source(at.source, at.span, finding.label, sgr, margin, look)
    for name, text, place in _remarks(finding, look.base):
        yield f"{' ' * margin} {look.ink(FAINT, '=')} {look.ink(CYAN, f'{name}:')} {text}"
        if place in drawn and place.location.span and place.location.source:
            span, source = place.location.span, place.location.source
            yield from _source(source, span, "", CYAN, margin, look)


def _drawn_places(finding: Located) -> list[Place]:
    """Related places whose line is shown: a few, of what must be mended, and no line twice."""
    if finding.severity is Severity.NOTE:
        return []
    seen = {_line_of(finding.location)}
    found = []
    for place in finding.related:
        if place.location.source and place.location.span and _line_of(place.location) not in seen:
            seen.add(_line_of(place.location))
            found.append(place)
    return found[:DRAWN_PLACES]


def _line_of(at: Location) -> tuple[object, ...]:
    return at.file, at.member, at.span and at.span.line


def _link(text: str, url: str) -> str:
    """A hyperlink of the terminal (OSC 8)."""
    return f"\x1b]8;;{url}\x1b\\{text}\x1b]8;;\x1b\\"


def _arrow(finding: Located, margin: int, look: _Look) -> str:
    at = finding.location
    place = f"{shown(at, look.base)}{position(at.span)}"
    parts = [place, spec(finding.prim_path, finding.property)]
    line = f"{' ' * margin}{look.ink(FAINT, '-->')} {'  '.join(filter(None, parts))}"
    return line if at.span else f"{line}      {look.ink(FAINT, _why_no_line(at))}"


def _why_no_line(at: Location) -> str:
    is_text = (at.member or at.path).endswith(".usda")
    return "(no line)" if is_text else "(binary layer, no line)"


def _remarks(finding: Located, base: Path) -> Iterator[tuple[str, str, Place | None]]:
    if finding.help:
        yield "help", escaped(finding.help), None
    for place in finding.related:
        yield "related", _related(place, base), place
    if len(finding.roots) == 1 and finding.chain:
        yield "in", _roots(finding, base) + _way(finding, base), None
    elif finding.roots and finding.roots != (finding.location.path,):
        yield "in", _roots(finding, base), None
    if finding.variants:
        yield "variants", variants_shown(finding), None


def variants_shown(finding: Located) -> str:
    """The selections in which a finding holds, as Sdf writes them."""
    return ", ".join(
        escaped(f"<{one.removesuffix('}')}={choice or '(none)'}}}>")
        for one, chosen in finding.variants
        for choice in chosen
    )


def _related(place: Place, base: Path) -> str:
    at = place.location
    parts = (
        f"{shown(at, base)}{position(at.span)}",
        spec(place.prim_path, place.property),
        escaped(place.message),
    )
    return " ".join(filter(None, parts))


def roots_shown(finding: Located, base: Path | None = None) -> str:
    """The stages in which a finding holds; nothing where that is its own layer alone."""
    return "" if finding.roots in ((), (finding.location.path,)) else _roots(finding, base)


def _roots(finding: Located, base: Path | None) -> str:
    names = [_root_shown(root, finding.location, base) for root in finding.roots[:SHOWN_ROOTS]]
    more = len(finding.roots) - SHOWN_ROOTS
    return ", ".join(names) + (f" and {more} more" if more > 0 else "")


def _way(finding: Located, base: Path) -> str:
    """Over which layers the root comes to the opinion."""
    return "".join(
        f" -> ({step.arc}) {_root_shown(step.path, finding.location, base)}"
        for step in finding.chain
    )


def _root_shown(root: str, location: Location, base: Path | None) -> str:
    """A root is known by its shown path alone; the layer's two paths tell where that begins."""
    file = PurePath(location.file).as_posix()
    top = file.removesuffix(f"/{location.path}")
    if base is None or top == file:
        return escaped(root)
    return escaped(_below(str(PurePath(top, root)), base) or root)


@lru_cache
def _below(file: str, base: Path) -> str | None:
    path = PurePath(file)
    return path.relative_to(base).as_posix() if path.is_relative_to(base) else None


def _source(
    source: str, span: Span, label: str, sgr: str, margin: int, look: _Look
) -> Iterator[str]:
    room = max(20, look.width - margin - len(" | "))
    line, offset, length = _excerpt(source.rstrip("\r\n"), span, room, look.cut)
    bar = look.ink(FAINT, look.bar)
    number = look.ink(FAINT, f"{span.line:>{margin}}")
    carets = look.ink(sgr, f"{'^' * length} {escaped(label)}".rstrip())
    yield f"{number} {bar} {line}".rstrip()
    yield f"{' ' * margin} {bar} {' ' * offset}{carets}"


def _excerpt(source: str, span: Span, room: int, cut: str) -> tuple[str, int, int]:
    """What fits of the line, and the carets' offset and length in terminal cells."""
    first = min(span.column - 1, len(source))
    last = max(first, min(span.end_column - 1, len(source)))
    lo, hi = 0, len(source)
    if hi > room or _cells(_drawn(source)) > room:
        lo, hi = _window(source, first, last, room - 2 * len(cut))
    before = (cut if lo else "") + _drawn(source[lo:first])
    after = _drawn(source[first:hi]) + (cut if hi < len(source) else "")
    length = _cells(_drawn(source[first : min(last, hi)]))
    return before + after, _cells(before), max(1, length)


def _window(source: str, first: int, last: int, room: int) -> tuple[int, int]:
    """A range that has at most `room` cells: the span, then as much on either side.

    Grown from the span because a line may be megabytes of array.
    """
    lo = hi = first
    while hi < last and (cells := _cells(_drawn(source[hi]))) <= room:
        hi, room = hi + 1, room - cells
    grows = hi == last
    while grows:
        grows = False
        if lo and (cells := _cells(_drawn(source[lo - 1]))) <= room:
            lo, room, grows = lo - 1, room - cells, True
        if hi < len(source) and (cells := _cells(_drawn(source[hi]))) <= room:
            hi, room, grows = hi + 1, room - cells, True
    return lo, hi


def _drawn(source: str) -> str:
    """A piece of a source line as the terminal gets it."""
    return source if source.isprintable() else escaped(source.replace("\t", TAB))


def _cells(text: str) -> int:
    """How many columns of a terminal a printable text takes."""
    if text.isascii():
        return len(text)
    # Only here: it is a shared library that most reports do without.
    from unicodedata import category, east_asian_width

    return sum(
        0 if category(char) in ("Mn", "Me") else 2 if east_asian_width(char) in "WF" else 1
        for char in text
    )


def counts(report: Report) -> str:
    """How much was looked at and found; nothing in it but numbers and words of this program."""
    files = plural(len(report.files), "file")
    if report.through:
        files += f", seen through {plural(len(report.through), 'stage')}"
    files += _hidden(report)
    if not report.findings:
        return f"No findings in {files}." if report.files else "Nothing was linted."
    each = ", ".join(plural(n, severity) for severity, n in report.counts.items() if n)
    return f"{plural(len(report.findings), 'finding')} ({each}) in {files}."


def _hidden(report: Report) -> str:
    in_baseline = f"{report.in_baseline} in the baseline" if report.in_baseline else ""
    ignored = f"{report.ignored} ignored" if report.ignored else ""
    parts = ", ".join(filter(None, (in_baseline, ignored)))
    return f"; {parts}" if parts else ""


def _judged(report: Report) -> str | None:
    """By which renderer; None where the schema alone was the judge."""
    roots = Counter(choice.name for choice in report.renderers)
    if not roots.keys() - {"any"}:
        return None
    if len(roots) > 1:
        counts = (f"{escaped(name)} ({plural(n, 'file')})" for name, n in sorted(roots.items()))
        return f"Judged as {listed(counts)}; -v says why."
    reasons = {choice.reason for choice in report.renderers}
    because = f": {_clause(reasons.pop())}" if len(reasons) == 1 else "; -v says why"
    return f"Judged as {escaped(report.renderers[0].name)}{because}."


def _choices(report: Report) -> Iterator[str]:
    for choice in report.renderers:
        yield escaped(f"{choice.root}: judged as {choice.name}: {_clause(choice.reason)}.")


def _chatter(chatter: Iterable[str]) -> Iterator[str]:
    for text in chatter:
        yield from (f"USD: {escaped(line)}" for line in text.splitlines())


def _incomplete(problems: tuple[Problem, ...]) -> str:
    causes = []
    if unread := [p for p in problems if not p.rule]:
        # A folder without USD files is no file, and a missing path is anybody's guess.
        vague = any(p.kind in ("missing-path", "no-usd-files") for p in unread)
        paths = plural(len({p.path for p in unread}), "path" if vague else "file")
        causes.append(f"{plural(len(unread), 'error')} kept {paths} from being linted")
    if crashed := [p for p in problems if p.rule]:
        rules = plural(len({p.rule for p in crashed}), "rule")
        causes.append(f"{rules} failed on {plural(len({p.path for p in crashed}), 'file')}")
    return f"The run is incomplete: {' and '.join(causes)} (see above)."


def listed(names: Iterable[str]) -> str:
    """`a, b and c`."""
    *others, last = names
    return f"{', '.join(others)} and {last}" if others else last


def _clause(reason: str) -> str:
    return escaped(reason.rstrip("."))

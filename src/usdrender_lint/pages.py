"""What does the page of a rule say, and what does it show?

A page is at once documentation, the text of `--explain` and the rule's test: so its
form is fixed, and `parse` refuses whatever a test would otherwise pass over in silence.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import takewhile
from pathlib import Path

from .lazily import lazily
from .model import Layer, Suppressions
from .records import dataclass
from .rule import AnyRule

SECTIONS = ("Bad", "Good", "When to ignore it", "See also")

_ID = lazily(r"[a-z0-9]+(-[a-z0-9]+)*")
_FENCE = lazily(r"```(\w*)")
_CLOSE = "```"
_NAME = lazily(r"`([^`]+)`:")
_TITLE = lazily(r"# (\S.*)")
_HEADING = lazily(r"## (\S.*)")
_FACTS = lazily(r"\*[^*]+\*")

Line = tuple[int, str]
"""A line's number in the page, from 1, and its text."""


class UnknownPageError(LookupError):
    """No page has that name."""


class MalformedPageError(ValueError):
    """A page has not the form that all pages have."""


@dataclass(frozen=True, slots=True)
class Case:
    """One scene of a page."""

    main: str
    """The unnamed block."""
    files: dict[str, str]
    """The named blocks after it, by name."""
    line: int
    """Of the page, where the text of `main` begins."""


@dataclass(frozen=True, slots=True)
class Section:
    text: str
    cases: tuple[Case, ...]


@dataclass(frozen=True, slots=True)
class Page:
    title: str
    facts: str
    """The generated line, with its asterisks."""
    why: str
    sections: dict[str, Section]

    def cases(self, section: str) -> tuple[Case, ...]:
        return self.sections[section].cases


def page_text(rule_id: str) -> str:
    """The page of one rule, as Markdown."""
    # Proven to be an id first: as a part of a path it could lead anywhere.
    path = _folder() / f"{rule_id}.md"
    if not (_ID.fullmatch(rule_id) and path.is_file()):
        raise UnknownPageError(f"There is no page for {rule_id!r} in {_folder()}.")
    return path.read_text(encoding="utf-8")


def pages() -> dict[str, str]:
    """All pages by rule id, sorted."""
    found = sorted(path for path in _folder().glob("*.md") if _ID.fullmatch(path.stem))
    return {path.stem: path.read_text(encoding="utf-8") for path in found}


def _folder() -> Path:
    """In a wheel the pages are package data; from source they stand in the repository."""
    here = Path(__file__).resolve()
    shipped = here.parent / "pages"
    return shipped if shipped.is_dir() else here.parents[2] / "rules"


def facts_line(rule: AnyRule) -> str:
    """The line below a page's title."""
    whose = f" for {' and '.join(rule.renderers)}" if rule.renderers else ""
    facts = (
        rule.severity,
        rule.group,
        _need(rule),
        (rule.only_when or "on by default") + whose,
        f"since {rule.since}",
    )
    return f"*{' · '.join(filter(None, facts))}*"


def _need(rule: AnyRule) -> str:
    if rule.needs_scene:
        return "the whole stage"
    return "one layer" if rule.on in (Layer, Suppressions) else "the render scope"


def parse(text: str) -> Page:
    """A page in parts; `MalformedPageError` names the line that is wrong."""
    head, *rest = _split(list(enumerate(text.split("\n"), 1)))
    title, facts, why = _head(head)
    sections = [_section(lines) for lines in rest]
    headings = [heading for heading, _ in sections]
    if headings != list(SECTIONS):
        raise MalformedPageError(
            f"{title}: the sections must be {', '.join(SECTIONS)}; here are {', '.join(headings) or 'none'}."
        )
    return Page(title, facts, why, dict(sections))


def _split(lines: list[Line]) -> list[list[Line]]:
    """The lines before the first section, then those of each section, its heading first."""
    parts: list[list[Line]] = [[]]
    fenced = 0
    for number, line in lines:
        # Within a fence `## ` is a comment of usda.
        if fenced:
            if line == _CLOSE:
                fenced = 0
            elif _FENCE.fullmatch(line):
                break
        elif _FENCE.fullmatch(line):
            fenced = number
        elif _HEADING.fullmatch(line):
            parts.append([])
        parts[-1].append((number, line))
    if fenced:
        raise _wrong(fenced, "this block is never closed")
    return parts


def _head(lines: list[Line]) -> tuple[str, str, str]:
    said = [(number, line) for number, line in lines if line.strip()]
    if not said or not (title := _TITLE.fullmatch(said[0][1])):
        raise _wrong(1, "a page begins with '# rule-id'")
    if len(said) < 2 or not _FACTS.fullmatch(said[1][1]):
        raise _wrong(said[0][0] + 2, "the line of facts is missing: '*error · ... · since 0.1*'")
    number, facts = said[1]
    why = _text(lines[number:])
    if not why:
        raise _wrong(number, "below the facts a page says why")
    return title[1], facts, why


def _section(lines: list[Line]) -> tuple[str, Section]:
    heading, body = lines[0][1].removeprefix("## "), lines[1:]
    return heading, Section(_text(body), _cases(body))


def _text(lines: list[Line]) -> str:
    return "\n".join(line for _, line in lines).strip()


def _cases(lines: list[Line]) -> tuple[Case, ...]:
    cases: list[Case] = []
    for number, name, text in _blocks(lines):
        if name is None:
            cases.append(Case(text, {}, number + 1))
        elif not cases:
            raise _wrong(number, f"{name} belongs to an unnamed block, which must stand before it")
        elif name in cases[-1].files:
            raise _wrong(number, f"this scene has a {name} already")
        else:
            cases[-1] = replace(cases[-1], files={**cases[-1].files, name: text})
    return tuple(cases)


def _blocks(lines: list[Line]) -> Iterator[tuple[int, str | None, str]]:
    """Line of the fence, name and text of each usda block."""
    name: str | None = None
    rest = iter(lines)
    for number, line in rest:
        if fence := _FENCE.fullmatch(line):
            text = "".join(f"{inner}\n" for inner in _until_closed(rest))
            if fence[1] == "usda":
                yield number, name, text
            elif name:
                raise _wrong(number, f"the block of {name} must be marked as usda")
            name = None
        elif named := _NAME.fullmatch(line):
            name = named[1]
        elif name and line:
            raise _wrong(number, f"a block must follow the name {name}")
    if name:
        raise _wrong(lines[-1][0], f"a block must follow the name {name}")


def _until_closed(lines: Iterator[Line]) -> Iterator[str]:
    return (line for _, line in takewhile(lambda numbered: numbered[1] != _CLOSE, lines))


def _wrong(line: int, message: str) -> MalformedPageError:
    return MalformedPageError(f"line {line}: {message}.")

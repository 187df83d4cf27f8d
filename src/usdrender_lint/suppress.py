"""Which findings are silenced, and which suppressions silence nothing?"""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from .lazily import lazily
from .model import Extent, Flaw, Site, Suppression, Suppressions
from .records import dataclass
from .registry import all_rules
from .results import Located, Location, Span, Verdict
from .rule import AnyRule, Context, Severity
from .run import Crash, Rules, run

if TYPE_CHECKING:
    from .usda import Comment

MARK = "usdrender-lint:"

_SAID = lazily(
    # The header of a layer is a comment by its mark.
    r"(?:#(?:usda|sdf)[ \t]+[\d.]+[ \t]*)?(?:#+|//+|/\*+)[ \t]*" + re.escape(MARK) + r"[ \t]*"
    r"(?P<word>[\w-]*)[ \t]*(?P<list>\[(?P<rules>[^\]]*)(?P<closed>\])?)?"
)
_RULE = lazily(r"[^\s,]+")
_VARIANTS = lazily(r"(?:\{[^}]*\})+")

Key = tuple[str, ...]
"""Names a suppression within a run, whatever stage it was met in."""


@dataclass(frozen=True, slots=True)
class Ignore:
    """A suppression with its place, and what it reaches."""

    said: Suppression
    location: Location
    lines: range = range(0)
    """Of the text, if it is a comment about a line."""
    reaches: str = ""
    """The composed prim or property, if it is metadata of one."""

    @property
    def key(self) -> Key:
        at, site = self.location, self.said.site
        # One file may be met by the names of several links.
        file = os.path.realpath(at.file)
        return (file, at.member or "", site.spec or "", site.field or "", self.said.rule)

    def silences(self, finding: Located) -> bool:
        """Whether one that the finding's layer or the prims above it hold is meant for it."""
        if self.said.flaw or self.said.rule != finding.rule.id:
            return False
        match self.said.extent:
            case Extent.PRIM:
                return finding.prim_path == self.reaches or finding.prim_path.startswith(
                    f"{self.reaches}/"
                )
            case Extent.PROPERTY:
                return f"{finding.prim_path}.{finding.property}" == self.reaches
            case Extent.LAYER:
                return True
            case Extent.LINE | Extent.NEXT_LINE:
                span = finding.location.span
                return span is not None and span.line in self.lines


def in_comment(comment: Comment, file: str) -> Iterator[tuple[Suppression, Span, range]]:
    """What a comment says, where it says so, and the lines that this is about."""
    match = _SAID.match(comment.text)
    if not match:
        return
    lines = range(comment.line, (comment.below or comment.line) + 1)
    extent = Extent.LINE if comment.below is None else Extent.NEXT_LINE
    if match["word"] == "ignore-file":
        extent = Extent.LAYER
    for rule, flaw, (start, end) in _rules_of(match):
        field = f"comment:{comment.line}:{comment.column}"
        path = _VARIANTS.sub("/", comment.path)
        site = Site(path.rstrip("/") or "/", field, rule or None, file, comment.path)
        span = Span(comment.line, comment.column + start, comment.column + end)
        yield Suppression(site, extent, rule, flaw), span, lines


def _rules_of(match: re.Match[str]) -> Iterator[tuple[str, Flaw | None, tuple[int, int]]]:
    """Each rule that a comment names, or what is there instead."""
    what = "word" if match["word"] or not match["list"] else "list"
    if match[what] not in ("ignore", "ignore-file", ""):
        yield match[what], Flaw.UNKNOWN_WORD, match.span(what)
    elif match["list"] and not match["closed"]:
        yield "", Flaw.NOT_CLOSED, (match.start("word"), match.end("rules"))
    else:
        named = list(_RULE.finditer(match["rules"] or ""))
        for rule in named:
            start = match.start("rules") + rule.start()
            yield rule[0], _flaw_of(rule[0]), (start, start + len(rule[0]))
        if not named:
            whole = "list" if match["list"] else "word"
            yield "", Flaw.NO_RULE, (match.start("word"), match.end(whole))


def in_metadata(
    site: Site, extent: Extent, key: str, names: tuple[str, ...] | None
) -> Iterator[Suppression]:
    """What one entry of the dictionary `usdrenderLint` says."""

    def suppression(rule: str, flaw: Flaw | None) -> Suppression:
        return Suppression(replace(site, target=rule or None), extent, rule, flaw, in_comment=False)

    if key not in ("", "ignore", "reason"):
        yield suppression(key, Flaw.UNKNOWN_WORD)
    elif key != "reason" and names is None:
        yield suppression("", Flaw.NO_LIST)
    elif key == "ignore" and names is not None:
        yield from (suppression(name, _flaw_of(name)) for name in names)
        if not names:
            yield suppression("", Flaw.NO_RULE)


def _flaw_of(rule: str) -> Flaw | None:
    rules = all_rules()
    if rule in rules:
        return None
    is_group = rule in ("ALL", "default") or any(r.group == rule for r in rules.values())
    return Flaw.GROUP if is_group else Flaw.UNKNOWN_RULE


def judge(finding: Located, ignores: Iterable[Ignore]) -> tuple[Located, set[Key]]:
    """The finding with its verdict, and every suppression that silences it."""
    silencing = [ignore for ignore in ignores if ignore.silences(finding)]
    if not silencing:
        return finding, set()
    by_comment = any(ignore.said.in_comment for ignore in silencing)
    verdict = Verdict.BY_COMMENT if by_comment else Verdict.BY_METADATA
    return replace(finding, verdict=verdict), {ignore.key for ignore in silencing}


def is_about_suppressions(rule: AnyRule) -> bool:
    return rule.on is Suppressions


def findings_of(
    ignores: Mapping[str, tuple[Ignore, ...]],
    needed: Collection[Key],
    ran: Mapping[str, frozenset[str]],
    rules: Iterable[AnyRule],
    context: Context,
    severities: Mapping[str, Severity],
) -> tuple[list[Located], list[tuple[str, Crash]]]:
    """What there is to say about the suppressions of each file, by its shown path.

    Only when all stages are linted it is known which of them were `needed`.
    """
    own = Rules(rule for rule in rules if is_about_suppressions(rule))
    findings: list[Located] = []
    crashes: list[tuple[str, Crash]] = []
    for file, found in ignores.items():
        by_site = {ignore.said.site: ignore for ignore in found}
        said = tuple(
            replace(i.said, idle=_is_idle(i, needed, ran.get(file, frozenset())))
            for i in by_site.values()
        )
        subject = Suppressions(file, Site("/"), said, tuple(all_rules()))
        told, crashed = run(own, [subject], context)
        crashes.extend((file, crash) for crash in crashed)
        for one in told:
            site, finding = one.finding.at.site, one.finding
            severity = severities.get(one.rule.id, finding.severity or one.rule.severity)
            located = Located(
                one.rule,
                severity,
                finding.message,
                finding.label,
                finding.help,
                by_site[site].location,
                site.prim_path,
                site.property_name,
                site.target,
                roots=(file,),
            )
            findings.append(judge(located, found)[0])
    return findings, crashes


def _is_idle(ignore: Ignore, needed: Collection[Key], ran: frozenset[str]) -> bool:
    rule = ignore.said.rule
    if ignore.said.flaw or rule not in ran or is_about_suppressions(all_rules()[rule]):
        return False
    return ignore.key not in needed

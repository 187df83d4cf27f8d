"""Where is it? From the site of a finding to a layer, a line and a column."""

from __future__ import annotations

from pxr import Sdf, Usd

from .discover import Shown
from .lazily import lazily
from .model import HasSite, Site
from .packages import split_package
from .printable import escaped
from .reach import way_to
from .read.expressions import broken_at
from .read.text import Texts
from .results import Located, Location, Opinion, Place, Span, Step
from .rule import AnyRule, Finding, Renderer, Severity
from .run import Told
from .sites import Spot, Translation, find, into_layer
from .unopened import ParseProblem

_HEAD, _TAIL = 60, 30
_LONG = lazily(r"'([^']{120,})'")
"""A value in quotes that nobody would read to its end."""
SYNTAX = "syntax"
"""Field of a site that means the place where a layer stops being usda."""

_PATH = lazily(r"<(/[\w/.:]+)>")
"""As messages write that of a prim or a property."""


class Locator:
    """Places for the findings of one stage."""

    def __init__(
        self,
        stage: Usd.Stage | None,
        root: str,
        texts: Texts,
        shown: Shown,
        unparsed: list[ParseProblem],
    ) -> None:
        self._stage = stage
        self._file = root
        self._root = shown(root)
        self._texts = texts
        self._shown = shown
        self._unparsed = {p.file: p for p in unparsed}
        self._chains: dict[tuple[str, str], tuple[Step, ...]] = {}

    def locate(self, told: Told, severity: Severity) -> Located:
        finding, site = told.finding, told.finding.at.site
        message = _shortened(escaped(finding.message))
        spot = self._spot(site)
        return Located(
            told.rule,
            severity,
            message,
            escaped(finding.label),
            escaped(finding.help),
            self._location(site, spot),
            site.prim_path,
            site.property_name,
            site.target,
            tuple(self._place(at, text) for at, text in finding.related),
            (self._root,),
            opinion=self._opinion(site, spot, message),
            chain=self._chain(site, spot),
            property_kind=self._property_kind(site),
        )

    def _opinion(self, site: Site, spot: Spot | None, message: str) -> Opinion | None:
        if self._stage is None or spot is None:
            return None
        translate = into_layer(self._stage, site, spot)
        if translate is None:
            return None
        path, target = translate(site.prim_path), spot.target or site.target
        if (path, target) == (site.prim_path, site.target):
            return None
        return Opinion(path, target, _translated(message, translate))

    def _chain(self, site: Site, spot: Spot | None) -> tuple[Step, ...]:
        if site.spec and site.field == SYNTAX and (layer := Sdf.Layer.Find(site.layer or "")):
            spot = Spot(layer, site.spec)
        if self._stage is None or spot is None:
            return ()
        key = site.prim_path, spot.layer.identifier
        if key not in self._chains:
            steps = way_to(self._stage, site, spot)
            self._chains[key] = tuple(Step(arc, self._name(layer)) for arc, layer in steps)
        return self._chains[key]

    def _name(self, layer: Sdf.Layer) -> str:
        at = self._in_file(self._texts.file_of(layer), None)
        return f"{at.path}[{at.member}]" if at.member else at.path

    def _place(self, at: HasSite, text: str) -> Place:
        site = at.site
        location, kind = self.location(site), self._property_kind(site)
        return Place(escaped(text), location, site.prim_path, site.property_name, kind)

    def _property_kind(self, site: Site) -> str:
        if self._stage is None or site.property_name is None:
            return ""
        found = self._stage.GetObjectAtPath(f"{site.prim_path}.{site.property_name}")
        kinds = {Usd.Attribute: "attribute", Usd.Relationship: "relationship"}
        return kinds.get(type(found), "")

    def location(self, site: Site) -> Location:
        return self._location(site, self._spot(site))

    def _location(self, site: Site, spot: Spot | None) -> Location:
        if spot is not None:
            return self._spot_location(spot)
        if site.field == SYNTAX and site.layer is not None:
            return self._parse_location(site.layer, site)
        return self._in_file(site.layer or "", None)

    def _spot(self, site: Site) -> Spot | None:
        """None where there is no stage, or a text that USD could not read."""
        if self._stage is None or (site.field == SYNTAX and site.layer is not None):
            return None
        return find(self._stage, site)

    def _spot_location(self, spot: Spot) -> Location:
        if spot.layer.anonymous:  # its name would be an address in memory
            return Location(self._file, self._root)
        text = self._texts.of(spot.layer)
        span = text.span(spot.path, spot.field, spot.target) if text else None
        source = text.line(span.line) if text and span else None
        return self._in_file(self._texts.file_of(spot.layer), span, source)

    def _parse_location(self, file: str, site: Site) -> Location:
        text = self._texts.of_file(file)
        if text is None:
            return self._in_file(file, None)
        if site.spec:  # an expression: its property is known
            start = broken_at(site.target) if site.target else None
            span = (
                None if start is None else text.in_expression(site.spec, site.target or "", start)
            )
            span = span or text.span(site.spec, "default")
            return self._in_file(file, span, text.line(span.line) if span else None)
        problem = self._unparsed[file]
        if not problem.line:
            return self._in_file(file, None)
        source = text.line(problem.line)
        at_most = max(1, len(source))  # the end of a line is shown at its last character
        column = len(source.encode()[: problem.column - 1].decode(errors="replace")) + 1
        column = min(column, at_most)
        end = min(len(source) + 1, column + 1)
        return self._in_file(file, Span(problem.line, column, max(end, column)), source)

    def _in_file(self, file: str, span: Span | None, source: str | None = None) -> Location:
        file, member = split_package(self._texts.full_name(file))
        return Location(file, self._shown(file), member, span, source)


def _translated(message: str, translate: Translation) -> str:
    return _PATH.sub(lambda found: f"<{translate(found[1])}>", message)


def _shortened(message: str) -> str:
    """Without the middle of a long value: the place shows all of it."""
    return _LONG.sub(lambda value: f"'{value[1][:_HEAD]} ... {value[1][-_TAIL:]}'", message)


def severity_of(
    rule: AnyRule, finding: Finding, renderer: Renderer, chosen: dict[str, Severity]
) -> Severity | None:
    """What the person says stands above what the renderer does, above what the rule says.

    None: off for this renderer.
    """
    if rule.id in chosen:
        return chosen[rule.id]
    if rule.id in renderer.severities:
        return renderer.severities[rule.id]
    return finding.severity or rule.severity

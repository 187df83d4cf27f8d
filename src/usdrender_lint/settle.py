"""Which findings only repeat the cause that another one names?"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import field, replace

from .model import HasSite, Site
from .records import dataclass
from .run import Told


def settle(told: Iterable[Told]) -> list[Told]:
    """Without the findings that another one supersedes.

    A rule names the rules it supersedes; whether a finding is superseded is decided by place: it
    stands at, below, or leads to the object of the finding that names the cause.
    """
    everything = list(told)
    causes: dict[str, _Causes] = {}
    for one in everything:
        places = one.finding.explains or (one.finding.at,)
        for rule_id in one.rule.supersedes:
            known = causes.setdefault(rule_id, _Causes())
            for place in places:
                known.add(place.site)
    return [
        t
        for t in everything
        if t.rule.id not in causes or not causes[t.rule.id].cover(t.finding.at.site)
    ]


def unique(told: Iterable[Told]) -> list[Told]:
    """What several subjects say alike is said once, with all that is related to it."""
    found: dict[tuple[object, ...], Told] = {}
    related: dict[tuple[object, ...], dict[tuple[HasSite, str], None]] = {}
    for one in told:
        key = one.rule.id, one.finding.at.site, one.finding.message
        found.setdefault(key, one)
        related.setdefault(key, {}).update(dict.fromkeys(one.finding.related))
    return [_relating(one, tuple(related[key])) for key, one in found.items()]


def _relating(one: Told, related: tuple[tuple[HasSite, str], ...]) -> Told:
    if len(related) == len(one.finding.related):  # nobody says more
        return one
    return replace(one, finding=replace(one.finding, related=related))


@dataclass(slots=True)
class _Causes:
    """The places of all findings that supersede those of one rule: thousands may meet thousands."""

    prims: set[str] = field(default_factory=set)
    properties: dict[tuple[str, str], set[str | None]] = field(default_factory=dict)
    """With the targets that are named; None for the property as a whole."""

    def add(self, site: Site) -> None:
        if site.property_name is None:
            self.prims.add(site.path)
        else:
            self.properties.setdefault(_composed(site), set()).add(site.target)

    def cover(self, site: Site) -> bool:
        """A prim covers what stands at, below or leads to it; a property what is said of it."""
        if "/" in self.prims or not self.prims.isdisjoint(_at_and_above(site.path)):
            return True
        if site.target is not None and not self.prims.isdisjoint(_at_and_above(site.target)):
            return True
        targets = self.properties.get(_composed(site))
        if targets is None:
            return False
        return site.target is None or None in targets or site.target in targets


def _composed(site: Site) -> tuple[str, str]:
    """Prim and property, whether or not the site is that of one layer."""
    return site.prim_path, site.property_name or ""


def _at_and_above(path: str) -> Iterator[str]:
    while path:
        yield path
        path = path[: max(path.rfind("/"), path.rfind("."), 0)]

"""Which findings only repeat the cause that another one names?"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from .model import Site
from .run import Told


def settle(told: Iterable[Told]) -> list[Told]:
    """Without the findings that another one supersedes.

    A rule names the rules it supersedes; whether a finding is superseded is decided by place: it
    stands at, below, or leads to the object of the finding that names the cause.
    """
    everything = list(told)
    stronger = [t for t in everything if t.rule.supersedes]
    return [t for t in everything if not any(_explains(s, t) for s in stronger)]


def unique(told: Iterable[Told]) -> list[Told]:
    """What several subjects say alike is said once, with all that is related to it."""
    found: dict[tuple[object, ...], Told] = {}
    for one in told:
        key = one.rule.id, one.finding.at.site, one.finding.message
        if known := found.get(key):
            related = dict.fromkeys((*known.finding.related, *one.finding.related))
            one = replace(known, finding=replace(known.finding, related=tuple(related)))
        found[key] = one
    return list(found.values())


def _explains(cause: Told, other: Told) -> bool:
    if other.rule.id not in cause.rule.supersedes:
        return False
    places = cause.finding.explains or (cause.finding.at,)
    return any(_covers(place.site, other.finding.at.site) for place in places)


def _covers(cause: Site, other: Site) -> bool:
    if cause.path == "/":
        return True
    if cause.property_name is None:
        return _at_or_below(other.path, cause.path) or (
            other.target is not None and _at_or_below(other.target, cause.path)
        )
    if _composed(cause) != _composed(other):
        return False
    return cause.target is None or other.target is None or cause.target == other.target


def _composed(site: Site) -> tuple[str, str]:
    """Prim and property, whether or not the site is that of one layer."""
    return site.prim_path, site.property_name or ""


def _at_or_below(path: str, above: str) -> bool:
    return path == above or path.startswith((above + "/", above + "."))

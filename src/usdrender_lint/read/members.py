"""What do the collections of passes name? They decide over the scene, and it is not opened for them.

A member is populated without what lies below it: that tells whether it exists, whether it is an
instance, and what its children are called. Other collections that one takes in are populated with
their prim, so that USD can evaluate them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import fields
from itertools import count

from pxr import Sdf, Usd

from ..likeness import most_alike
from ..model import Candidate, Member, Site, State, Target
from ..stage import ROUNDS, Opened, kinds_of, promised, render_prims, targets_of, widen
from .groups import is_group, matching
from .patterns import Node, tree
from .prims import collections_among

_PREFIX = "collection:"
_GUESSES = 64
PROPERTIES = (
    "excludes",
    "expansionRule",
    "includeRoot",
    "includes",
    "membershipExpression",
    "mode",
)


def collection_names(authored: Iterable[str]) -> frozenset[str]:
    """Of collections that some layer says anything about, by the names of a prim's properties."""
    return frozenset(name for one in authored if (name := collection_name(one)))


def collection_name(property_name: str) -> str:
    """`collection:lights:key:includes` belongs to `lights:key`."""
    if not property_name.startswith(_PREFIX):
        return ""
    return property_name.removeprefix(_PREFIX).rpartition(":")[0]


def applied_collections(prim: Usd.Prim) -> tuple[str, ...]:
    """Built in, or by `apiSchemas`."""
    return collections_among(prim.GetAppliedSchemas())


def collection_of(path: Sdf.Path) -> str | None:
    """The name of the collection that a path means, if it means one."""
    return path.name.removeprefix(_PREFIX) if Usd.CollectionAPI.IsCollectionAPIPath(path) else None


def raw_targets(prim: Usd.Prim, name: str) -> list[Sdf.Path]:
    """Of includes or excludes, which USD does not forward."""
    relationship = prim.GetRelationship(name)
    if not relationship:
        return []
    return targets_of(relationship)


def composed_tree(prim: Usd.Prim, name: str) -> Node | None:
    """The membership expression of a collection, relative patterns made absolute."""
    attribute = prim.GetAttribute(f"{_PREFIX}{name}:membershipExpression")
    value = attribute.Get() if attribute else None
    return tree(value) if isinstance(value, Sdf.PathExpression) else None


def taken_in(prim: Usd.Prim, name: str) -> Iterator[tuple[str, str, str]]:
    """Prim and name of each collection that one takes in, and the include that says so; that is
    empty for a reference in the expression."""
    for target in raw_targets(prim, f"{_PREFIX}{name}:includes"):
        if other := collection_of(target):
            yield str(target.GetPrimPath()), other, str(target)
    found = composed_tree(prim, name)
    for path, other in found.references() if found else ():
        if other != "_":  # the weaker expression, where there is none
            yield path or str(prim.GetPath()), other, ""


def widen_to_members(opened: Opened) -> None:
    """Populate what the collections of passes name, until nothing new turns up."""
    for round_ in count():
        wanted: set[str] = set()
        seen: set[tuple[str, str]] = set()
        for prim in (p for p in render_prims(opened) if "RenderPass" in kinds_of(p)):
            for name in collection_names(prim.GetAuthoredPropertyNames()):
                wanted.update(_named(prim, name))
                wanted.update(_others(prim, name, seen, ahead=round_ >= ROUNDS))
        if not widen(opened, sorted(wanted)):
            return


def _named(prim: Usd.Prim, name: str) -> Iterator[str]:
    for side in ("includes", "excludes"):
        yield from map(str, raw_targets(prim, f"{_PREFIX}{name}:{side}"))
    found = composed_tree(prim, name)
    for pattern, adds in found.patterns() if found else ():
        yield pattern.prefix
        if adds and pattern.bare:
            # What stands on the last level is read off the level above.
            yield from matching(prim.GetStage(), pattern.parts[:-1])[1]


def _others(prim: Usd.Prim, name: str, seen: set[tuple[str, str]], *, ahead: bool) -> Iterator[str]:
    """Prims of the collections that this one takes in, and those take in, as far as populated;
    `ahead`: and as far as the layers alone promise."""
    pending = [(prim, name)]
    while pending:
        for path, other, _ in taken_in(*pending.pop()):
            yield path
            there = prim.GetStage().GetPrimAtPath(path)
            if there and (path, other) not in seen:
                seen.add((path, other))
                pending.append((there, other))
            if not there and ahead:
                first = Sdf.Path(path).AppendProperty(f"{_PREFIX}{other}")
                yield from map(str, promised(prim.GetStage(), first, ":includes"))


def members(stage: Usd.Stage, targets: Iterable[Target]) -> Iterator[Member]:
    """Of those that are missing so many are compared with what is there."""
    missing = 0
    for target in targets:
        missing += target.state is State.MISSING
        yield member(stage, target, guess=missing <= _GUESSES)


def member(stage: Usd.Stage, target: Target, *, guess: bool = True) -> Member:
    """What more there is to know about a prim that a collection names."""
    known = {f.name: getattr(target, f.name) for f in fields(Target)}
    path = Sdf.Path(target.path).GetPrimPath()
    prim = stage.GetPrimAtPath(path)
    if prim:
        return Member(
            **known,
            instance=_instance(prim),
            invisible=_invisible(prim),
            is_group=is_group(prim),
        )
    # Only a damaged crate holds a relative one, above which there is always another.
    if target.state is not State.MISSING or not path.IsAbsolutePath():
        return Member(**known)
    above = path.GetParentPath()
    while not (prim := stage.GetPrimAtPath(above)):
        above = above.GetParentPath()
    known["candidates"] = tuple(_candidates(prim, path)) if guess else ()
    return Member(**known, nearest=str(above))


def _candidates(above: Usd.Prim, path: Sdf.Path) -> Iterator[Candidate]:
    """Children of the prim above that may have been meant, best first."""

    wanted = path.MakeRelativePath(above.GetPath()).GetPrefixes()[0].name
    for _, name in most_alike(wanted, above.GetPrimIndex().ComputePrimChildNames()[0], 5):
        found = str(above.GetPath().AppendChild(name))
        yield Candidate(found, "", Site(found))


def _instance(prim: Usd.Prim) -> str | None:
    while prim.IsInstanceProxy():
        prim = prim.GetParent()
    return str(prim.GetPath()) if prim.IsInstance() else None


def _invisible(prim: Usd.Prim) -> str | None:
    while not prim.IsPseudoRoot():
        shown = prim.GetAttribute("visibility")
        if shown and not shown.ValueMightBeTimeVarying() and shown.Get() == "invisible":
            return str(prim.GetPath())
        prim = prim.GetParent()
    return None

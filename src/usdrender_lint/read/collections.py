"""What does a collection of a render pass come to, by USD's own evaluation?"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

from pxr import Sdf, Tf, Usd

from ..lazily import lazily
from ..model import Collection, Gives, Lost, Member, OtherCollection, Pattern, Rel, Site, State
from ..records import dataclass
from ..sites import node_of, out_of_namespace_of
from .groups import cut_groups
from .members import (
    applied_collections,
    collection_names,
    collection_of,
    composed_tree,
    member,
    members,
    taken_in,
)
from .patterns import STRETCH, Node, Parsed, tree
from .predicates import means_groups, read_predicates
from .prims import Asked
from .targets import Targets, arc_field
from .values import plain_expression, plain_text, read_attr

_MANY = 64
_QUOTED = lazily(r'"(\w+)"')
"""USD puts the arguments of predicates in quotes, where people do not."""


def read_collections(
    pass_: Asked, targets: Targets, needed: Iterable[str]
) -> tuple[Collection, ...]:
    """The collections of a pass that some layer says anything about, built-in or applied.

    `needed`: paths of the render spec that may be members, too.
    """
    prim = pass_.prim
    names = sorted(collection_names(pass_.authored).intersection(pass_.schema.collections))
    found = [_Reader(prim, pass_, name, targets).read() for name in names]
    asked = [*needed, *(m.path for c in found for m in c.members)]
    paths = {above for path in asked for above in Sdf.Path(path).GetPrimPath().GetPrefixes()}
    return tuple(replace(c, **_held(Usd.CollectionAPI(prim, c.name), paths)) for c in found)


def _held(collection: Usd.CollectionAPI, paths: set[Sdf.Path]) -> dict[str, Any]:
    """Which of the paths are members, and which have members below them."""
    query = membership(collection)
    if query is None:
        return {}
    if query.UsesPathExpansionRuleMap():
        rules = query.GetAsPathExpansionRuleMap().items()
        included = [Sdf.Path(path) for path, expands in rules if expands != "exclude"]
        reached = {above for path in included for above in path.GetPrefixes()[:-1]} & paths
    else:
        found = tree(collection.ResolveCompleteMembershipExpression())
        reached = {p for p in paths if found and found.may_hold_below(str(p))}
    return {
        "held": frozenset(str(p) for p in paths if query.IsPathIncluded(p)),
        "reached": frozenset(map(str, reached)),
    }


def membership(collection: Usd.CollectionAPI) -> Any:
    """USD's query; None where it raises, or would crash when asked."""
    try:
        found = tree(collection.ResolveCompleteMembershipExpression())
        if found and any(p.crashes for p, _ in found.patterns()):
            return None
        return collection.ComputeMembershipQuery()
    except Tf.ErrorException:  # an unknown predicate, or a relationship written as an attribute
        return None


@dataclass(frozen=True, slots=True)
class _Reader:
    """One collection, read."""

    prim: Usd.Prim
    asked: Asked
    name: str
    targets: Targets

    def read(self) -> Collection:
        prim, asked, prefix = self.prim, self.asked, f"collection:{self.name}"
        mode = read_attr(asked, f"{prefix}:mode", plain_text, "")
        includes, excludes = self._rel(f"{prefix}:includes"), self._rel(f"{prefix}:excludes")
        api = Usd.CollectionAPI(prim, self.name)
        counts, problem = _evaluate(api, mode.value, includes, excludes)
        expression = read_attr(asked, f"{prefix}:membershipExpression", plain_expression, "")
        site, specs = replace(expression.site, field="default"), self._specs()
        patterns = tuple(self._patterns(site, specs))
        return Collection(
            self.name,
            Site(f"{prim.GetPath()}.{prefix}"),
            mode,
            read_attr(asked, f"{prefix}:expansionRule", plain_text, ""),
            read_attr(asked, f"{prefix}:includeRoot", bool, False),
            includes,
            excludes,
            expression,
            counts,
            problem,
            patterns,
            tuple(self._others(site, specs)),
            tuple(_members(includes, patterns if counts else None)),
            (*includes.lost, *excludes.lost, *self._lost(site, specs)),
        )

    def _rel(self, name: str) -> Rel:
        rel = self.targets.rel(self.asked, name)
        stage = self.prim.GetStage()
        return replace(rel, targets=tuple(members(stage, rel.targets)))

    def _tree(self) -> Node | None:
        return composed_tree(self.prim, self.name)

    def _patterns(self, site: Site, specs: list[Sdf.AttributeSpec]) -> Iterator[Pattern]:
        whole, written_at = self._tree(), self._written_at(site, specs)
        found = list(whole.patterns()) if whole else []
        relative: dict[str, str] | None = None
        for index, (parsed, adds) in enumerate(found):
            text = _QUOTED.sub(r"\1", parsed.text)
            at = written_at.get(parsed.text) or replace(site, target=text)
            start = self._start(parsed, at)
            written = None
            if start.state is State.MISSING or self._is_own(parsed):
                relative = self._relative(specs) if relative is None else relative
                written = relative.get(parsed.text)
            # Each is held against all others: a list of thousands is no person's oversight.
            few = adds and index < _MANY
            cut = cut_groups(self.prim.GetStage(), parsed, whole) if few and whole else ()
            conditions = [p for c in parsed.conditions for p in read_predicates(c)]
            yield Pattern(
                text,
                start.site,
                start,
                adds,
                parsed.names_all,
                parsed.below,
                parsed.crashes,
                written,
                tuple(cut),
                adds and _names_groups(parsed, [p for p, more in found if more]),
                tuple(conditions),
            )

    def _start(self, parsed: Parsed, site: Site) -> Member:
        if parsed.prefix == "/":
            return Member("/", State.LIVE, site)
        path = str(Sdf.Path(parsed.prefix).GetPrimPath())
        return member(self.prim.GetStage(), self.targets.one(path, site, ""))

    def _written_at(self, at: Site, specs: list[Sdf.AttributeSpec]) -> dict[str, Site]:
        """For each composed pattern the opinion that says it, in the words of its layer."""
        found: dict[str, Site] = {}
        for spec in specs:
            written = tree(spec.default)
            for parsed, _ in written.patterns() if written else ():
                path = self._out_of(spec, parsed.prefix)
                if not path.isEmpty:
                    composed = str(path) + parsed.text.removeprefix(parsed.prefix)
                    text = _QUOTED.sub(r"\1", parsed.text)
                    found.setdefault(composed, _of_spec(at, spec, text))
        return found

    def _is_own(self, parsed: Parsed) -> bool:
        return bool(Sdf.Path(parsed.prefix).HasPrefix(self.prim.GetPath()))

    def _specs(self) -> list[Sdf.AttributeSpec]:
        """Opinions about the expression that take part, strongest first."""
        attribute = self.prim.GetAttribute(f"collection:{self.name}:membershipExpression")
        found = []
        for spec in attribute.GetPropertyStack(Usd.TimeCode.Default()) if attribute else ():
            value = spec.default if isinstance(spec, Sdf.AttributeSpec) else None
            if isinstance(value, Sdf.PathExpression):
                found.append(spec)
                if not value.ContainsWeakerExpressionReference():
                    break
        return found

    def _lost(self, at: Site, specs: list[Sdf.AttributeSpec]) -> Iterator[Lost]:
        """Patterns that lead out of the layer that is brought in: nothing stands in their place."""
        for spec in specs:
            whole, node = tree(spec.default), node_of(self.prim, spec)
            if whole is None or node is None:
                continue
            for parsed, _ in whole.patterns():
                if self._out_of(spec, parsed.prefix).isEmpty:
                    site = _of_spec(at, spec, parsed.text)
                    into = str(node.GetIntroPath())
                    yield Lost(parsed.text, site, into, arc_field(node))

    def _out_of(self, spec: Sdf.AttributeSpec, prefix: str) -> Sdf.Path:
        path = Sdf.Path(prefix)
        return path if prefix == "/" else out_of_namespace_of(self.prim, spec, path)

    def _relative(self, specs: list[Sdf.AttributeSpec]) -> dict[str, str]:
        """Composed patterns that are written relative, and how: the parser makes them absolute, and
        so does every view and copy of a layer. But nobody writes the path of the pass itself: a
        pattern that begins with it was relative."""
        found: dict[str, str] = {}
        for spec in specs:
            anchor = spec.path.GetPrimPath().StripAllVariantSelections()
            said = tree(spec.default)
            for parsed, _ in said.patterns() if said else ():
                if Sdf.Path(parsed.prefix).HasPrefix(anchor):
                    prefix = self._out_of(spec, parsed.prefix)
                    as_written = parsed.text.removeprefix(str(anchor)).lstrip("/") or "."
                    found[str(prefix) + parsed.text.removeprefix(parsed.prefix)] = as_written
        return found

    def _others(self, site: Site, specs: list[Sdf.AttributeSpec]) -> Iterator[OtherCollection]:
        prim = self.prim
        for path, name, include in taken_in(prim, self.name):
            if include:
                written = include
                at = Site(
                    f"{prim.GetPath()}.collection:{self.name}:includes", "targetPaths", include
                )
            else:
                written = f"%{'' if path == str(prim.GetPath()) else path}:{name}"
                at = self._taken_in_at(site, specs, path, name) or replace(site, target=written)
            there = prim.GetStage().GetPrimAtPath(path)
            gives = self._gives(path, name, by_include=bool(include))
            opinions = bool(there) and name in collection_names(there.GetAuthoredPropertyNames())
            applied = applied_collections(there) if there else ()
            yield OtherCollection(path, name, written, at, gives, applied, opinions)

    def _taken_in_at(
        self, at: Site, specs: list[Sdf.AttributeSpec], path: str, name: str
    ) -> Site | None:
        """The opinion whose expression takes in another collection, in the words of its layer."""
        for spec in specs:
            written = tree(spec.default)
            for there, called in written.references() if written else ():
                own = there or str(spec.path.GetPrimPath().StripAllVariantSelections())
                if called == name and str(self._out_of(spec, own)) == path:
                    return _of_spec(at, spec, f"%{there}:{called}")
        return None

    def _gives(self, path: str, name: str, *, by_include: bool) -> Gives:
        there = self.prim.GetStage().GetPrimAtPath(path)
        if not there:
            state = self.targets.one(path, Site(path), "").state
            return Gives.NO_PRIM if state is State.MISSING else Gives.UNKNOWN
        if name not in applied_collections(there):
            return Gives.UNKNOWN if self.targets.hiding(path) else Gives.NO_COLLECTION
        other = Usd.CollectionAPI(there, name)
        try:
            by_relationships = other.IsInRelationshipsMode()
        except Tf.ErrorException:
            return Gives.UNKNOWN
        if by_include:
            has_expression = composed_tree(there, name) is not None
            wrong = has_expression and not by_relationships
        else:
            wrong = by_relationships
        return Gives.WRONG_MODE if wrong else Gives.MEMBERS


def _of_spec(at: Site, spec: Sdf.AttributeSpec, text: str) -> Site:
    return replace(at, target=text, layer=spec.layer.identifier, spec=str(spec.path))


def _names_groups(parsed: Parsed, adding: list[Parsed]) -> bool:
    """By its last condition it names groups only, and no other pattern what is below them."""
    return (
        parsed.text.endswith("}")
        and not parsed.is_property
        and means_groups(parsed.conditions[-1])
        and not any(p is not parsed and STRETCH in p.parts for p in adding)
    )


def _members(includes: Rel, patterns: Iterable[Pattern] | None) -> Iterator[Member]:
    if patterns is None:
        for target in includes.targets:
            if isinstance(target, Member) and not collection_of(Sdf.Path(target.path)):
                yield target
    else:
        yield from (p.start for p in patterns if p.adds and p.names_all and p.start.path != "/")


def _evaluate(
    collection: Usd.CollectionAPI, mode: str, includes: Rel, excludes: Rel
) -> tuple[bool, str | None]:
    if any(r.written_as_attribute for r in (includes, excludes)):
        return False, None  # USD raises when asked; the kind of property is the fault
    try:
        # `mode = "relationship"` without targets answers False though the expression is ignored (26.11).
        by_relationships = mode == "relationship" or collection.IsInRelationshipsMode()
        valid, reason = collection.Validate()
    except Tf.ErrorException:
        return mode != "relationship", None  # an unknown predicate: nobody can evaluate it
    return not by_relationships, None if valid else _in_plain_words(reason)


def _in_plain_words(reason: str) -> str:
    return re.sub(r"\s+", " ", reason).strip().rstrip(".")

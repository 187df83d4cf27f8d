"""What do the relationships of render prims lead to?"""

from __future__ import annotations

from bisect import bisect_left
from collections import deque
from collections.abc import Iterable, Iterator
from itertools import takewhile

from pxr import Pcp, Sdf, Usd

from ..likeness import most_alike
from ..model import EXPECTED, RENDER_TYPES, Candidate, Clobbered, Lost, Rel, Site, State, Target
from ..records import dataclass
from ..sites import node_of, out_of_namespace_of
from ..stage import (
    Opened,
    kinds_of,
    leads,
    listed_by,
    relationship_at,
    render_prims,
    targets_of,
    widen,
)
from .arcs import Failures
from .parts import Part
from .prims import Asked, Opinion, Prims, state_of, type_is_known
from .specs import children_of, there
from .text import Texts

_FIELD_OF_ARC = {
    Pcp.ArcTypePayload: "payload",
    Pcp.ArcTypeInherit: "inheritPaths",
    Pcp.ArcTypeSpecialize: "specializes",
}
_BEST = 5
"""Prims that may have been meant, of which so many are told."""
_MANY = 64
"""Children of one prim that are looked at for a prim that may have been meant."""
_SPECS = 4000
"""Specs of the root layer stack that are looked through for cameras: about 30 ms."""

# Looked up on an object, USD checks the object first, which takes longer than these do.
_relationship = Usd.Prim.GetRelationship
_type_name = Usd.Prim.GetTypeName


@dataclass(frozen=True, slots=True)
class _Found:
    """What stands at a path."""

    state: State
    type_name: str = ""
    isa: frozenset[str] = frozenset()
    type_known: bool = True
    because: str | None = None


@dataclass(frozen=True, slots=True)
class _Followed:
    """What an authored relationship leads to, in paths."""

    raw: list[Sdf.Path] | None
    """As it says; None if some layer authors it as an attribute."""
    ends: tuple[tuple[Sdf.Path, Sdf.Path, str], ...] = ()
    """The entry that begins a chain, the end of it, and the relationship that names this."""
    through: frozenset[Sdf.Path] = frozenset()
    """All relationships that it leads through."""


class Targets:
    """Answers for one stage; made when the mask holds every target.

    Looking for prims that may have been meant widens the mask, which may replace prims: so that is
    done once, here, before anybody reads.
    """

    def __init__(self, opened: Opened, failures: Failures, texts: Texts, part: Part) -> None:
        self._opened = opened
        self._stage: Usd.Stage = opened.stage
        self._failures = failures
        self._texts = texts
        self._part = part
        self._meant: dict[str, str] = {}
        self._candidates: dict[tuple[str, str], tuple[Candidate, ...]] = {}
        self._censuses: dict[str, _Census] = {}
        self._looked: dict[Sdf.Path, _Found] = {}
        self._followed: dict[tuple[Sdf.Path, str], _Followed | None] = {}
        self._survey()
        self.prims = Prims(opened)

    def rel(self, prim: Asked, name: str) -> Rel:
        """The relationship `name` of a render prim, forwarded, with what was lost on the way."""
        path = f"{prim.path}.{name}"
        site = Site(path, "targetPaths")
        hidden = self._failures.hiding(path) is not None
        followed = self._follow(prim, name)
        if followed is None:
            return Rel(name, site, maybe_more=hidden)
        if followed.raw is None:
            return Rel(name, Site(path), authored=True, written_as_attribute=True)
        expected = EXPECTED.get(name)
        targets: dict[Sdf.Path, Target] = {}
        for first, last, via in followed.ends:
            if last not in targets:
                entry = Site(path, "targetPaths", str(first))
                targets[last] = self._target(prim, last, via, entry, expected)
        said = prim.opinions(name)
        return Rel(
            name,
            site,
            any(one.spec.HasInfo("targetPaths") for one in said),
            tuple(targets.values()),
            tuple(_lost(prim, path, said)) if prim.has_arcs else (),
            tuple(_clobbered(prim, path, said, followed.raw)) if len(said) > 1 else (),
            maybe_more=hidden,
            forwarding=tuple(sorted(map(str, followed.through))),
            dead_ends=() if targets else tuple(self._dead_ends(followed.raw)),
        )

    def _follow(self, prim: Asked, name: str) -> _Followed | None:
        """None: no layer says anything about the relationship."""
        if name not in prim.authored:
            return None
        key = prim.at, name
        if key not in self._followed:
            said = _relationship(prim.prim, name)
            self._followed[key] = self._forwarded(name, listed_by(said)) if said else None
        return self._followed[key]

    def _forwarded(self, name: str, raw: list[Sdf.Path] | None) -> _Followed:
        if raw is None:
            return _Followed(None)
        if name not in EXPECTED:
            # The includes and excludes of a collection are not forwarded by USD.
            return _Followed(raw, tuple((path, path, "") for path in raw))
        through: set[Sdf.Path] = set()
        ends = [(first, *end) for first in raw for end in self._forward(first, through)]
        return _Followed(raw, tuple(ends), frozenset(through))

    def _dead_ends(self, raw: list[Sdf.Path]) -> Iterator[Site]:
        """Where chains of relationships end that lead to nothing."""
        pending, seen = deque(path for path in raw if path.IsPropertyPath()), set[Sdf.Path]()
        while pending:
            path = pending.popleft()
            if path in seen:
                continue
            seen.add(path)
            relationship = self._stage.GetRelationshipAtPath(path)
            further = targets_of(relationship) if relationship else []
            if not any(target not in seen for target in further):
                yield Site(str(path), "targetPaths", str(further[0]) if further else None)
            pending += [target for target in further if target not in seen]

    def hiding(self, path: str) -> str | None:
        """The asset that did not open, behind which more of a prim may be."""
        return self._failures.hiding(path)

    def one(self, path: str, site: Site, expected: str) -> Target:
        """The prim that a string names, such as the default settings."""
        found = self._look(Sdf.Path(path))
        candidates = self._candidates.get((path, expected), ())
        return Target(
            path,
            found.state,
            site,
            found.type_name,
            found.isa,
            found.type_known,
            because=found.because,
            candidates=candidates,
            only_in=self._variant_with(Sdf.Path(path)) if found.state is State.MISSING else "",
        )

    def suggested(self, path: str, site: Site, expected: str) -> Target:
        """As `one`, and where it is broken prims that may have been meant."""
        at = Sdf.Path(path)
        found = self._look(at)
        if found.state is not State.LIVE or expected not in found.isa:
            self._suggest(at, expected)
        return self.one(path, site, expected)

    def _target(
        self,
        owner: Asked,
        path: Sdf.Path,
        via: str,
        site: Site,
        expected: str | None,
    ) -> Target:
        found = self._look(path)
        spelt = str(path)
        missing = found.state is State.MISSING
        written: str | None = None
        relative = False
        meant = self._meant.get(spelt) if not via else None
        candidates = self._candidates.get((spelt, expected or ""), ())
        if missing and not via and path.HasPrefix(owner.at) and path.GetPrimPath() != owner.at:
            written = self._texts.written_target(self._stage, site)
            # A layer that was saved again shows the whole path, as a binary one does.
            relative = meant is not None and (written is None or written.startswith("/"))
        return Target(
            spelt,
            found.state,
            site,
            found.type_name,
            found.isa,
            found.type_known,
            path.IsPropertyPath(),
            via,
            Site(via, "targetPaths", spelt) if via else None,
            written if written is not None and not written.startswith("/") else None,
            relative,
            meant,
            found.because,
            candidates,
            self._variant_with(path) if missing else "",
            missing
            and not candidates
            and (self._part.is_library or (self._part.is_part and expected == "Camera"))
            # Nobody looks for anything but its own vars below a render prim.
            and not (expected == "Camera" and path.HasPrefix(owner.at)),
        )

    def _forward(self, first: Sdf.Path, seen: set[Sdf.Path]) -> Iterator[tuple[Sdf.Path, str]]:
        """As `GetForwardedTargets()`, but with the relationship that names each. A cycle leads
        nowhere, and what was forwarded once brings nothing new."""
        pending = [(first, "")]
        while pending:
            path, via = pending.pop()
            relationship = relationship_at(self._stage, path)
            if not relationship:
                yield path, via
            elif path not in seen:
                seen.add(path)
                pending += [(target, str(path)) for target in reversed(targets_of(relationship))]

    def _look(self, path: Sdf.Path) -> _Found:
        found = self._looked.get(path)
        if found is None:
            found = self._looked[path] = self._look_at(path)
        return found

    def _look_at(self, path: Sdf.Path) -> _Found:
        prim = self._stage.GetPrimAtPath(path.GetPrimPath())
        if not prim:
            return self._look_nowhere(path)
        type_name = _type_name(prim)
        found = _Found(state_of(prim), type_name, kinds_of(prim), type_is_known(prim))
        unclear = found.state is State.OVER or (found.state is State.LIVE and not type_name)
        if unclear and (asset := self._failures.hiding(str(path))):
            return _Found(State.UNKNOWN, type_name, found.isa, found.type_known, asset)
        if found.state is State.INACTIVE:
            above = prim
            while above.GetParent() and not above.GetParent().IsActive():
                above = above.GetParent()
            if above != prim:
                return _Found(State.INACTIVE, type_name, found.isa, True, str(above.GetPath()))
        if path.IsPropertyPath():
            # For a path within a property, as of a connection, USD has no object at all.
            found_property = self._stage.GetPropertyAtPath(path)
            if not found_property or not found_property.IsDefined():
                return _Found(State.MISSING)
        return found

    def _look_nowhere(self, path: Sdf.Path) -> _Found:
        prim = self._nearest(path.GetPrimPath().GetParentPath())
        above = prim.GetPath()
        if not prim.IsPseudoRoot() and not prim.IsActive():
            # Below an inactive prim nothing is composed: the specs tell whether something is there.
            for spec in prim.GetPrimStack():
                beneath = path.GetPrimPath().ReplacePrefix(above, spec.path)
                if found := spec.layer.GetPrimAtPath(beneath):
                    name = str(found.typeName)
                    isa = frozenset({name})
                    return _Found(State.INACTIVE, name, isa, True, str(prim.GetPath()))
        if asset := self._failures.hiding(str(path)):
            return _Found(State.UNKNOWN, because=asset)
        return _Found(State.MISSING)

    def _variant_with(self, path: Sdf.Path) -> str:
        """The variant that would bring a prim which is not there."""
        wanted = path.GetPrimPath()
        populated = [prim for prim in self._down_to(wanted) if prim.GetPath() != wanted]
        for prim in reversed(populated):
            above = prim.GetPath()
            for spec in prim.GetPrimStack():
                for name in spec.variantSets.keys():  # noqa: SIM118 no dictionary of Python's
                    selected = prim.GetVariantSet(name).GetVariantSelection()
                    for variant in spec.variantSets[name].variants.keys():  # noqa: SIM118 neither
                        inside = spec.path.AppendVariantSelection(name, variant)
                        at = wanted.ReplacePrefix(above, inside)
                        if variant != selected and spec.layer.GetPrimAtPath(at):
                            return f"variant '{variant}' of '{name}' on <{above}>"
        return ""

    def _nearest(self, path: Sdf.Path) -> Usd.Prim:
        """The prim at the path, else the closest one above it that is on the stage."""
        *_, nearest = self._stage.GetPseudoRoot(), *self._down_to(path)
        return nearest

    def _down_to(self, path: Sdf.Path) -> Iterator[Usd.Prim]:
        """The prims on the way to a path that are on the stage, from the top: what stands below one
        that is not there is not asked for, however long the path is."""
        prims = map(self._stage.GetPrimAtPath, path.GetPrefixes())
        return takewhile(bool, prims)

    def _survey(self) -> None:
        """Before anything is read: what stands where broken targets may have been meant."""
        broken: list[tuple[Sdf.Path, Sdf.Path, str]] = []
        for owner, name, raw in leads(self._opened):
            followed = self._followed[owner, name] = self._forwarded(name, raw)
            for _, last, _ in followed.ends:
                if self._is_broken(last, EXPECTED[name]):
                    broken.append((owner, last, EXPECTED[name]))
        if broken:
            self._mend(broken)

    def _mend(self, broken: list[tuple[Sdf.Path, Sdf.Path, str]]) -> None:
        self._widen_to_meant(broken)
        self._widen_to_kin(path for _, path, _ in broken)
        # Each is compared with every prim of the type: nobody mends more than so many at once.
        for _, path, expected in broken[:_MANY]:
            self._suggest(path, expected)
        # Cameras are suggested that only a spec told of: what is wrong with them is read, too.
        cameras = (found[:1] for (_, kind), found in self._candidates.items() if kind == "Camera")
        self._widen([best.path for found in cameras for best in found])

    def _is_broken(self, path: Sdf.Path, expected: str) -> bool:
        found = self._look(path)
        if found.state is State.UNKNOWN:
            # A layer that is missing may bring it; but perhaps it is only misspelt.
            there = self._stage.GetPrimAtPath(path.GetPrimPath())
            return not there and self._failures.only_a_layer_hides(str(path))
        return found.state is State.MISSING or expected not in found.isa

    def _widen_to_meant(self, broken: list[tuple[Sdf.Path, Sdf.Path, str]]) -> None:
        """`<Render/S>` on `/Render/A` is `/Render/A/Render/S`: was `/Render/S` meant?"""
        from_root = {
            str(path): str(path.ReplacePrefix(owner, Sdf.Path.absoluteRootPath))
            for owner, path, _ in broken
            if path.HasPrefix(owner) and path.GetPrimPath() != owner
        }
        self._widen(sorted(from_root.values()))
        for path, meant in from_root.items():
            if self._look(Sdf.Path(meant)).state is not State.MISSING:
                self._meant[path] = meant

    def _widen_to_kin(self, paths: Iterable[Sdf.Path]) -> None:
        """Siblings of what is missing, its place after relocation, children of what is of the wrong type."""
        kin: list[str] = []
        parents: dict[Sdf.Path, Usd.Prim] = {}  # of thousands that are missing most share one
        for path in paths:
            if moved := self._relocated(path.GetPrimPath()):
                kin.append(moved)
            prim = self._nearest(path.GetPrimPath())
            parents.setdefault(prim.GetPath(), prim)
        for above, prim in parents.items():
            names = prim.GetPrimIndex().ComputePrimChildNames()[0]
            if len(names) <= _MANY:
                kin.extend(str(above.AppendChild(name)) for name in names)
        self._widen(kin)

    def _widen(self, wanted: Iterable[str]) -> None:
        if widen(self._opened, wanted):
            self._looked.clear()

    def _suggest(self, path: Sdf.Path, expected: str) -> None:
        """Note prims of the type that may have been meant by `path`, best first."""
        key = (str(path), expected)
        if key in self._candidates or expected == "":
            return
        if expected not in self._censuses:
            self._censuses[expected] = _Census(self._census(expected))
        best = self._censuses[expected].nearest(path)
        moved = self._relocated(path.GetPrimPath())
        best.sort(key=lambda c: c.path != moved)
        self._candidates[key] = tuple(best[:_BEST])

    def _relocated(self, path: Sdf.Path) -> str:
        """Where a prim stands that a layer relocates: at its old path it reads as missing."""
        for layer in self._stage.GetLayerStack(includeSessionLayers=False):
            for source, target in layer.relocates:
                if not target.isEmpty and path.HasPrefix(source):
                    return str(path.ReplacePrefix(source, target))
        return ""

    def _census(self, expected: str) -> Iterable[Candidate]:
        found = {
            str(p.GetPath()): Candidate(
                str(p.GetPath()), str(p.GetTypeName()), Site(str(p.GetPath()))
            )
            for p in self._of_type(expected)
            if state_of(p) is State.LIVE
        }
        if expected == "Camera":
            for layer in self._stage.GetLayerStack(includeSessionLayers=False):
                for path in _camera_specs(layer):
                    found.setdefault(path, Candidate(path, "Camera", Site(path)))
        return found.values()

    def _of_type(self, expected: str) -> Iterable[Usd.Prim]:
        if expected in RENDER_TYPES:
            prims = (p for p in render_prims(self._opened) if not p.IsInstanceProxy())
        else:
            prims = self._opened.stage.TraverseAll()
        return (p for p in prims if expected in kinds_of(p))


class _Census:
    """All prims of one type, to be looked through for those that may have been meant."""

    def __init__(self, found: Iterable[Candidate]) -> None:
        self._all = sorted(found, key=lambda c: c.path)
        self._named: dict[str, list[Candidate]] = {}
        for one in self._all:
            self._named.setdefault(one.path.rpartition("/")[2].lower(), []).append(one)

    def nearest(self, path: Sdf.Path) -> list[Candidate]:
        """Best first: of the same name, below what was named as the camera below an Xform is, of a
        name most like it."""
        name, below = path.GetPrimPath().name, f"{path}/"
        found = {c.path: c for c in self._named.get(name.lower(), [])[:_BEST]}
        start = bisect_left(self._all, below, key=lambda c: c.path)
        for one in self._all[start : start + _BEST]:
            if one.path.startswith(below):
                found.setdefault(one.path, one)
        for _, alike in most_alike(name, self._named, _BEST):
            found.update({c.path: c for c in self._named[alike][:_BEST] if c.path not in found})
        found.pop(str(path), None)  # a layer has it, and another relocates it
        return list(found.values())


def arc_field(node: Pcp.NodeRef) -> str:
    """The field of a prim spec that makes an arc of this kind."""
    return _FIELD_OF_ARC.get(node.arcType, "references")


def _lost(owner: Asked, path: str, said: list[Opinion]) -> Iterator[Lost]:
    prim = owner.prim
    for spec in (one.spec for one in said if one.is_relationship):
        operation = spec.targetPathList
        for written in operation.GetAddedOrExplicitItems():
            if out_of_namespace_of(prim, spec, written).isEmpty:
                layer, entry = spec.layer.identifier, str(written)
                site = Site(path, "targetPaths", entry, layer, str(spec.path))
                arc = node_of(prim, spec)
                into = str(arc.GetIntroPath()) if arc is not None else owner.path
                field = arc_field(arc) if arc is not None else "references"
                yield Lost(entry, site, into, field)
        if operation.isExplicit:
            return  # what weaker layers list is replaced anyway


def _clobbered(
    prim: Asked, at: str, said: list[Opinion], raw: list[Sdf.Path]
) -> Iterator[Clobbered]:
    """What layers below an explicit list name, and the list does not."""
    replaced = False
    for spec in (one.spec for one in said if one.is_relationship):
        if replaced:
            for written in spec.targetPathList.GetAddedOrExplicitItems():
                path = out_of_namespace_of(prim.prim, spec, written)
                if not path.isEmpty and path not in raw:
                    layer, entry = spec.layer.identifier, str(written)
                    site = Site(at, "targetPaths", entry, layer, str(spec.path))
                    yield Clobbered(str(path), site)
        elif spec.HasInfo("targetPaths") and spec.targetPathList.isExplicit:
            replaced = True


def _camera_specs(layer: Sdf.Layer) -> Iterator[str]:
    pending = there(layer.rootPrims)
    for _ in range(_SPECS):
        if not pending:
            return
        spec = pending.pop()
        if spec.specifier == Sdf.SpecifierClass or not spec.active:
            continue
        if spec.typeName == "Camera" and spec.specifier == Sdf.SpecifierDef:
            yield str(spec.path)
        pending.extend(children_of(spec))

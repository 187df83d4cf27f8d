"""What does the whole scene hold that the render spec speaks of?

Everything here costs a walk over all prims, so it is asked only for rules `on=Scene`; and what the
layers do not mention at all, by their text or their tokens, is not walked for.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import field
from functools import cache
from typing import TypeVar

from pxr import Sdf, Usd

from ..crate import tokens_of
from ..model import (
    BindingUse,
    Pass,
    PassView,
    PurposeUse,
    RenderScope,
    Scene,
    Site,
)
from ..records import dataclass
from .collections import membership
from .metadata import KEY, opinion_of
from .text import text_of

T = TypeVar("T")

_GIVEN = frozenset({"accelerations", "normals", "points", "velocities", "widths"})
"""What geometry hands to a renderer as a primvar, though no layer calls it one."""

_LIGHT_TYPES = frozenset(
    {
        "CylinderLight",
        "DiskLight",
        "DistantLight",
        "DomeLight",
        "DomeLight_1",
        "GeometryLight",
        "PluginLight",
        "PortalLight",
        "RectLight",
        "SphereLight",
    }
)
_LIGHT_SCHEMAS = frozenset({"LightAPI", "MeshLightAPI", "VolumeLightAPI"})
_BINDING = "material:binding"


def read_scene(stage: Usd.Stage, scope: RenderScope) -> Scene:
    """`stage` is opened whole."""
    primvars = {v.source_name.value for v in scope.vars if v.source_type.value == "primvar"}
    asked = ("purpose", _BINDING, *_LIGHT_SCHEMAS, *map(_primvar, primvars))
    words = _Words(stage, asked)
    watching = [p for p in scope.passes if p.live and _hides(p)]
    walked = _walk(stage, words, for_passes=bool(watching))
    return Scene(
        scope.root,
        Site("/"),
        scope,
        tuple(PurposeUse(p, seen.count, _site(seen)) for p, seen in walked.purposes.items()),
        tuple(BindingUse(b, seen.count, _site(seen)) for b, seen in walked.bindings.items()),
        frozenset(_primvars(stage, primvars, words)),
        tuple(_pass_view(stage, one, walked) for one in watching if walked.lights),
        tuple(
            opinion_of(layer, counts=False)
            for layer in _beyond_the_layer_stack(stage)
            if layer.pseudoRoot.HasInfo(KEY)
        ),
    )


def _primvars(stage: Usd.Stage, asked: Iterable[str], words: _Words) -> Iterator[str]:
    """Those of which some prim has a value."""
    # As for what a renderer draws: the prototypes of an instancer may stand in an `over`.
    drawn = Usd.PrimIsActive & Usd.PrimIsLoaded & ~Usd.PrimIsAbstract
    tops = [*stage.GetPseudoRoot().GetFilteredChildren(drawn), *stage.GetPrototypes()]
    has = Usd.Prim.HasAttribute
    for name in asked:
        attribute = _primvar(name)
        if name in _GIVEN or (
            words.mention(attribute)
            and any(
                has(prim, attribute) and prim.GetAttribute(attribute).HasAuthoredValue()
                for top in tops
                for prim in Usd.PrimRange(top, drawn)
            )
        ):
            yield name


class _Words:
    """Which words the layers of a stage mention: each layer is looked through once for all of them."""

    def __init__(self, stage: Usd.Stage, asked: Iterable[str]) -> None:
        layers = [layer for layer in stage.GetUsedLayers() if not layer.empty]
        missing, self._mentioned = {*asked}, set[str]()
        for file in sorted({layer.realPath for layer in layers}):
            if missing:
                self._mentioned.update(_mentioned(file, missing))
                missing -= self._mentioned

    def mention(self, *words: str) -> bool:
        """False only if no layer can hold any of them."""
        return not self._mentioned.isdisjoint(words)


def _mentioned(file: str, words: set[str]) -> Iterable[str]:
    text = text_of(file) if file else None
    if text is not None:
        return [word for word in words if word.encode() in text]
    tokens = tokens_of(file) if file else None
    if tokens is None:  # nobody knows
        return words
    return [word for word in words if b"\0" + word.encode() in tokens]


@dataclass(slots=True)
class _Seen:
    """How many there are, and the first of them."""

    first: Sdf.Path
    count: int = 0


@dataclass(slots=True)
class _Walked:
    purposes: dict[str, _Seen] = field(default_factory=dict)
    bindings: dict[frozenset[str], _Seen] = field(default_factory=dict)
    lights: list[Sdf.Path] = field(default_factory=list)
    geometry: list[Sdf.Path] = field(default_factory=list)


_UNBOUND = frozenset[str]()
_DEEPEST = 4095


def _walk(stage: Usd.Stage, words: _Words, *, for_passes: bool) -> _Walked:
    """Asks a prim as little as it can: every question takes several times as long as the step from
    one prim to the next. Where nothing is to be learned, no step is taken."""
    found = _Walked()
    inherits = words.mention("purpose", _BINDING)
    if not inherits and not for_passes:
        return found
    lit = for_passes and words.mention(*_LIGHT_SCHEMAS)
    kinds: dict[str, str] = {}
    # What is inherited, by depth: the purpose, and the purposes that materials are bound for.
    purpose_above = [""] * (_DEEPEST + 1)
    bound_above = [_UNBOUND] * (_DEEPEST + 1)
    purpose, bound = "", _UNBOUND
    for prim in stage.Traverse():
        if inherits:
            depth = prim.GetPath().pathElementCount
            if depth >= _DEEPEST:
                continue
            purpose, bound = purpose_above[depth - 1], bound_above[depth - 1]
            for name in prim.GetAuthoredPropertyNames():
                if name == "purpose":
                    purpose = purpose or _own_purpose(prim)
                elif name.startswith(_BINDING) and not _bound_for(name) <= bound:
                    relationship = prim.GetRelationship(name)
                    if relationship and relationship.HasAuthoredTargets():
                        bound |= _bound_for(name)
            purpose_above[depth], bound_above[depth] = purpose, bound
        type_name = prim.GetTypeName()
        kind = kinds.get(type_name)
        if kind is None:
            kind = kinds[type_name] = _kind(prim, type_name)
        if kind == "other":
            continue
        if for_passes:
            if kind == "light" or (lit and _is_light(prim)):
                found.lights.append(prim.GetPath())
            if kind == "geometry":
                found.geometry.append(prim.GetPath())
        if inherits and kind == "geometry":
            _count(found.purposes, purpose or "default", prim)
            if bound:
                _count(found.bindings, bound, prim)
    return found


def _count(seen: dict[T, _Seen], what: T, prim: Usd.Prim) -> None:
    known = seen.get(what)
    if known is None:
        known = seen[what] = _Seen(prim.GetPath())
    known.count += 1


def _kind(prim: Usd.Prim, name: str) -> str:
    if name in _LIGHT_TYPES:
        return "light"
    return "geometry" if prim.IsA("Gprim") else "other"


def _is_light(prim: Usd.Prim) -> bool:
    return not _LIGHT_SCHEMAS.isdisjoint(prim.GetPrimTypeInfo().GetAppliedAPISchemas())


def _own_purpose(prim: Usd.Prim) -> str:
    attribute = prim.GetAttribute("purpose")
    value = attribute.Get() if attribute else None
    return str(value) if value and value != "default" else ""


@cache
def _bound_for(name: str) -> frozenset[str]:
    """The purpose that a relationship of this name binds materials for; none if it does not."""
    purpose = name.removeprefix(_BINDING).removeprefix(":")
    binds = name in (_BINDING, f"{_BINDING}:{purpose}") and ":" not in purpose
    return frozenset([purpose]) if binds and purpose != "collection" else _UNBOUND


def _site(seen: _Seen) -> Site:
    return Site(str(seen.first))


def _primvar(name: str) -> str:
    """As layers write it."""
    return f"primvars:{name.removeprefix('primvars:')}"


def _hides(one: Pass) -> bool:
    return any(c.name == "renderVisibility" for c in one.collections)


def _pass_view(stage: Usd.Stage, one: Pass, walked: _Walked) -> PassView:
    collection = Usd.CollectionAPI(stage.GetPrimAtPath(one.path), "renderVisibility")
    query = membership(collection)
    if query is None:  # an unknown predicate: nobody can evaluate it
        return PassView(one.path, shows_geometry=False, shows_lights=False)

    def any_of(paths: Iterable[Sdf.Path]) -> bool:
        return any(query.IsPathIncluded(path) for path in paths)

    lights = any_of(walked.lights)
    return PassView(one.path, lights or any_of(walked.geometry), lights)


def _beyond_the_layer_stack(stage: Usd.Stage) -> list[Sdf.Layer]:
    own = {layer.identifier for layer in stage.GetLayerStack()}
    others = [layer for layer in stage.GetUsedLayers() if layer.identifier not in own]
    return sorted(others, key=lambda layer: layer.identifier)

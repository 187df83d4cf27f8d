"""What does the whole scene hold that the render spec speaks of?

Everything here costs a walk over all prims, so it is asked only for rules `on=Scene`; and what the
layers do not mention at all, by their text or their tokens, is not walked for.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import field

from pxr import Sdf, Usd

from ..crate import mentions
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
    words = _Words(stage)
    walked = _walk(stage, words)
    return Scene(
        scope.root,
        Site("/"),
        scope,
        tuple(walked.purposes.values()),
        tuple(walked.bindings.values()),
        frozenset(_primvars(scope, words)),
        tuple(_pass_views(stage, scope, walked)),
        tuple(
            opinion_of(layer, counts=False)
            for layer in _beyond_the_layer_stack(stage)
            if layer.pseudoRoot.HasInfo(KEY)
        ),
    )


class _Words:
    """Which words the layers of a stage mention."""

    def __init__(self, stage: Usd.Stage) -> None:
        layers = [layer for layer in stage.GetUsedLayers() if not layer.empty]
        self._files = sorted({layer.realPath for layer in layers})

    def mention(self, word: str) -> bool:
        """False only if no layer can hold it."""
        return any(self._in_file(file, word.encode()) for file in self._files)

    def _in_file(self, file: str, word: bytes) -> bool:
        if not file:
            return True
        text = text_of(file)
        if text is not None:
            return word in text
        return mentions(file, [word], whole=False) is not False


@dataclass(slots=True)
class _Walked:
    purposes: dict[str, PurposeUse] = field(default_factory=dict)
    bindings: dict[frozenset[str], BindingUse] = field(default_factory=dict)
    lights: list[Sdf.Path] = field(default_factory=list)
    geometry: list[Sdf.Path] = field(default_factory=list)


def _walk(stage: Usd.Stage, words: _Words) -> _Walked:
    found = _Walked()
    purposes, bindings = words.mention("purpose"), words.mention(_BINDING)
    kinds: dict[str, str] = {}
    # What is inherited, by depth: the purpose, and the purposes that materials are bound for.
    purpose_above: list[str] = [""] * 4096
    bound_above: list[frozenset[str]] = [frozenset()] * 4096
    for prim in stage.Traverse():
        depth = prim.GetPath().pathElementCount
        if depth >= 4095:
            continue
        purpose_above[depth] = purpose_above[depth - 1]
        bound_above[depth] = bound_above[depth - 1]
        if purposes and (own := _own_purpose(prim)):
            purpose_above[depth] = purpose_above[depth - 1] or own
        if bindings:
            bound_above[depth] = bound_above[depth - 1].union(_bound_for(prim))
        name = prim.GetTypeName()
        kind = kinds.get(name)
        if kind is None:
            kind = kinds[name] = _kind(prim, name)
        if kind == "light" or (kind == "geometry" and _is_light(prim)):
            found.lights.append(prim.GetPath())
        if kind == "geometry":
            path = prim.GetPath()
            found.geometry.append(path)
            _count(found, path, purpose_above[depth] or "default", bound_above[depth])
    return found


def _kind(prim: Usd.Prim, name: str) -> str:
    if name in _LIGHT_TYPES:
        return "light"
    return "geometry" if prim.IsA("Gprim") else "other"


def _is_light(prim: Usd.Prim) -> bool:
    return not _LIGHT_SCHEMAS.isdisjoint(prim.GetPrimTypeInfo().GetAppliedAPISchemas())


def _own_purpose(prim: Usd.Prim) -> str:
    attribute = prim.GetAttribute("purpose")
    value = attribute.Get() if attribute and attribute.IsAuthored() else None
    return str(value) if value and value != "default" else ""


def _bound_for(prim: Usd.Prim) -> Iterator[str]:
    for relationship in prim.GetAuthoredRelationships():
        name = relationship.GetName()
        if name == _BINDING or (name.startswith(_BINDING + ":") and name.count(":") == 2):
            purpose = name.removeprefix(_BINDING).lstrip(":")
            if purpose != "collection" and relationship.HasAuthoredTargets():
                yield purpose


def _count(found: _Walked, path: Sdf.Path, purpose: str, bound: frozenset[str]) -> None:
    known = found.purposes.get(purpose)
    first = known.first if known else Site(str(path))
    found.purposes[purpose] = PurposeUse(purpose, (known.count if known else 0) + 1, first)
    if bound:
        use = found.bindings.get(bound)
        first = use.first if use else Site(str(path))
        found.bindings[bound] = BindingUse(bound, (use.count if use else 0) + 1, first)


def _primvars(scope: RenderScope, words: _Words) -> Iterator[str]:
    """The primvars that vars ask for and some layer mentions."""
    asked = {v.source_name.value for v in scope.vars if v.source_type.value == "primvar"}
    for name in asked:
        if words.mention(f"primvars:{name.removeprefix('primvars:')}"):
            yield name


def _pass_views(stage: Usd.Stage, scope: RenderScope, walked: _Walked) -> Iterator[PassView]:
    if not walked.lights:
        return
    for one in scope.passes:
        if one.live and any(c.name == "renderVisibility" for c in one.collections):
            yield _pass_view(stage, one, walked)


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

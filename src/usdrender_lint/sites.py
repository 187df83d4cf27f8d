"""Which layer and spec hold the opinion that a site names?"""

from __future__ import annotations

from collections.abc import Callable

from pxr import Pcp, Sdf, Usd

from .model import Site
from .records import dataclass


@dataclass(frozen=True, slots=True)
class Spot:
    """A spec, or a field of it, in the namespace of its layer."""

    layer: Sdf.Layer
    path: str
    field: str | None = None
    target: str | None = None


Translation = Callable[[str], str]
"""Of a composed path to that in the namespace of a layer; what does not stand there stays as it is."""


def find(stage: Usd.Stage, site: Site) -> Spot:
    """The strongest spec that has the field; without one the strongest spec of a property, the one
    that defines a prim; without any that of its parent, and so upward to the root layer."""
    if site.layer is not None:
        layer = Sdf.Layer.Find(site.layer) or stage.GetRootLayer()
        return Spot(layer, site.spec or site.path, site.field, site.target)
    if site.path in ("/", ""):
        return Spot(stage.GetRootLayer(), "/", site.field, site.target)
    if site.property_name is not None and (spot := _property_spot(stage, site)):
        return spot
    return _prim_spot(stage, site)


def _property_spot(stage: Usd.Stage, site: Site) -> Spot | None:
    prop = stage.GetPropertyAtPath(site.path)
    specs = prop.GetPropertyStack(Usd.TimeCode.Default()) if prop else []
    if not specs:
        return None
    if site.target is not None:
        for spec in specs:
            if isinstance(spec, Sdf.RelationshipSpec):
                written = into_namespace_of(prop.GetPrim(), spec, site.target)
                if spec.targetPathList.ContainsItemEdit(written, onlyAddOrExplicit=True):
                    return Spot(spec.layer, str(spec.path), site.field, str(written))
    field = site.field
    if field is not None:
        for spec in specs:
            if spec.HasInfo(field):
                return Spot(spec.layer, str(spec.path), field)
    return Spot(specs[0].layer, str(specs[0].path), field)


def _prim_spot(stage: Usd.Stage, site: Site) -> Spot:
    path = Sdf.Path(site.prim_path)
    prim = stage.GetPrimAtPath(path)
    field = site.field if site.property_name is None else None
    if prim and prim.GetPrimStack():
        specs = prim.GetPrimStack()
        for spec in specs:
            if field is not None and _has(spec, field):
                return Spot(spec.layer, str(spec.path), field, site.target)
        spec = _defining(specs)
        return Spot(spec.layer, str(spec.path))
    for layer in stage.GetLayerStack(includeSessionLayers=False):
        # Below an inactive prim nothing is composed, though the specs are there.
        if spec := layer.GetPrimAtPath(path):
            return Spot(layer, str(spec.path), field if field and _has(spec, field) else None)
    parent = path.GetParentPath()
    if parent in (Sdf.Path.absoluteRootPath, Sdf.Path.emptyPath):
        return Spot(stage.GetRootLayer(), "/")
    return _prim_spot(stage, Site(str(parent)))


def _defining(specs: list[Sdf.PrimSpec]) -> Sdf.PrimSpec:
    """The strongest that defines the prim: who looks for what a prim lacks opens the layer that makes
    it, not one that happens to override something else of it."""
    for specifier in (Sdf.SpecifierDef, Sdf.SpecifierClass):
        for spec in specs:
            if spec.specifier == specifier:
                return spec
    return specs[0]


def _has(spec: Sdf.PrimSpec, field: str) -> bool:
    if field == "typeName":
        return bool(spec.typeName)
    key, _, entry = field.partition(":")  # an entry of a dictionary, such as variantSelection:set
    return bool(spec.HasInfo(key)) and (not entry or entry in spec.GetInfo(key))


def node_of(prim: Usd.Prim, spec: Sdf.Spec) -> Pcp.NodeRef | None:
    """The node of the prim's index that brings in the spec."""
    wanted = spec.path.GetPrimOrPrimVariantSelectionPath()
    pending = [prim.GetPrimIndex().rootNode]
    while pending:
        node = pending.pop()
        if node.path == wanted and spec.layer in node.layerStack.layers:
            return node
        pending.extend(node.children)
    return None


def into_namespace_of(prim: Usd.Prim, spec: Sdf.Spec, target: str) -> Sdf.Path:
    """A composed target as it stands in the layer of `spec`."""
    node = node_of(prim, spec)
    if node is None or node.IsRootNode():
        return Sdf.Path(target)
    return node.mapToRoot.MapTargetToSource(Sdf.Path(target))


def out_of_namespace_of(prim: Usd.Prim, spec: Sdf.Spec, target: Sdf.Path) -> Sdf.Path:
    """A target written in the layer of `spec`, composed; the empty path if an arc drops it."""
    node = node_of(prim, spec)
    if node is None or node.IsRootNode():
        return target
    return node.mapToRoot.MapSourceToTarget(target)


def into_layer(stage: Usd.Stage, site: Site, spot: Spot) -> Translation | None:
    """From composed paths to those of the layer that brings the opinion in by a reference, a class
    or another arc; None where it brings them in under the same paths."""
    if spot.path == "/":
        return None
    own = spot.path.partition(".")[0] == site.prim_path
    if own and spot.layer in stage.GetLayerStack():
        return None
    at = Sdf.Path(spot.path).GetPrimOrPrimVariantSelectionPath()
    path = Sdf.Path(site.prim_path)
    while path.IsPrimPath():
        prim = stage.GetPrimAtPath(path)
        spec = spot.layer.GetPrimAtPath(at)
        if prim and spec and (node := node_of(prim, spec)):
            return _translation(prim, node)
        path = path.GetParentPath()
    return None


def _translation(prim: Usd.Prim, node: Pcp.NodeRef) -> Translation | None:
    if node.IsRootNode():
        return None
    function = node.mapToRoot
    instance, indexed = _instance_and_index(prim, node)

    def translate(path: str) -> str:
        composed = Sdf.Path(path)
        if instance is not None:
            composed = composed.ReplacePrefix(instance, indexed)
        written = function.MapTargetToSource(composed)
        return path if written.isEmpty else str(written)

    return translate


def _instance_and_index(
    prim: Usd.Prim, node: Pcp.NodeRef
) -> tuple[Sdf.Path | None, Sdf.Path | None]:
    """What stands in an instance is indexed below one of the instances that share it, which need not
    be the one that is asked about: both paths, or none."""
    if not prim.IsInstanceProxy():
        return None, None
    instance, depth = prim, 0
    while not instance.IsInstance():
        instance, depth = instance.GetParent(), depth + 1
    indexed = node.mapToRoot.MapSourceToTarget(node.path)
    for _ in range(depth):
        indexed = indexed.GetParentPath()
    return instance.GetPath(), indexed

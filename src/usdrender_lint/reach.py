"""Over which layers does a stage come to an opinion?"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

from pxr import Pcp, Sdf, Usd

from .model import Site
from .sites import Spot

Step = tuple[str, Sdf.Layer]
"""The kind of an arc, and the layer that it brings in."""

_ARCS = {
    Pcp.ArcTypeReference: "reference",
    Pcp.ArcTypePayload: "payload",
    Pcp.ArcTypeInherit: "inherits",
    Pcp.ArcTypeSpecialize: "specializes",
    Pcp.ArcTypeVariant: "variant",
    Pcp.ArcTypeRelocate: "relocates",
}
_MANY = 10_000
"""Prims that are asked for the one that a layer is brought in for."""


def way_to(stage: Usd.Stage, site: Site, spot: Spot) -> tuple[Step, ...]:
    """From the root layer to that of the spot; empty if it is the root layer, or nobody knows."""
    root = stage.GetPseudoRoot().GetPrimIndex().rootNode
    if spot.layer == stage.GetRootLayer() or spot.layer.anonymous:
        return ()
    if below := _sublayers(root.layerStack.layerTree, spot.layer):
        return below
    prim = _holder(stage, site, spot)
    if prim is None:
        return ()
    arcs = {
        _key(arc.GetTargetNode()): arc
        for arc in Usd.PrimCompositionQuery(prim).GetCompositionArcs()
    }
    node = next(n for n in _nodes(prim) if spot.layer in n.layerStack.layers)
    steps: tuple[Step, ...] = ()
    layer = spot.layer
    while not node.IsRootNode():
        arc = arcs.get(_key(node))
        if arc is None:
            return ()
        into = arc.GetIntroducingNode()
        if into.layerStack != node.layerStack:
            first = node.layerStack.identifier.rootLayer
            kind = _ARCS.get(arc.GetArcType(), "arc")
            steps = ((kind, first), *_sublayers(node.layerStack.layerTree, layer), *steps)
            layer = arc.GetIntroducingLayer()
        node = into
    return (*_sublayers(root.layerStack.layerTree, layer), *steps)


def _sublayers(tree: Pcp.LayerTree, layer: Sdf.Layer) -> tuple[Step, ...]:
    """Each is asked before what is below it; there may be a thousand, each in the one before."""
    waiting: list[tuple[Pcp.LayerTree, int]] = [(tree, 0)]
    way: list[Sdf.Layer] = []
    while waiting:
        one, depth = waiting.pop()
        way[depth:] = [one.layer]
        if depth and one.layer == layer:
            return tuple(("sublayer", above) for above in way[1:])
        waiting += [(child, depth + 1) for child in reversed(one.childTrees)]
    return ()


def _holder(stage: Usd.Stage, site: Site, spot: Spot) -> Usd.Prim | None:
    """The prim of the site, or one that the layer says anything about."""
    path = Sdf.Path(site.prim_path)
    if path != Sdf.Path.absoluteRootPath:
        for above in reversed(path.GetPrefixes()):
            prim = stage.GetPrimAtPath(above)
            if prim and any(spot.layer in n.layerStack.layers for n in _nodes(prim)):
                return prim
        return None
    asked = islice(stage.TraverseAll(), _MANY)
    return next(
        (p for p in asked if any(spot.layer in n.layerStack.layers for n in _nodes(p))), None
    )


def _nodes(prim: Usd.Prim) -> Iterator[Pcp.NodeRef]:
    pending = [prim.GetPrimIndex().rootNode]
    while pending:
        node = pending.pop(0)
        yield node
        pending += node.children


def _key(node: Pcp.NodeRef) -> tuple[str, str]:
    return str(node.path), node.layerStack.identifier.rootLayer.identifier

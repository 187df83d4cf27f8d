"""By which arcs do layers or prims lead back to themselves?

USD names the prim where it gives up, and none of the arcs. So they are followed here, on the specs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from pxr import Sdf

from ..model import Site
from ..records import dataclass
from .specs import variants_of

_DEEP = 32
"""Arcs of one chain: longer ones are not looked through."""

Find = Callable[[Sdf.Layer, str], Sdf.Layer | None]
"""The layer that an asset path of another one leads to."""


@dataclass(frozen=True, slots=True)
class _Arc:
    """From a place to another, and the opinion that makes it."""

    layer: Sdf.Layer
    path: Sdf.Path
    site: Site


def cycle_of_sublayers(root: Sdf.Layer, find: Find) -> tuple[Site, ...]:
    """The sublayers of a cycle, that which closes it last; empty if there is none."""

    def follow(layer: Sdf.Layer, above: tuple[_Arc, ...]) -> tuple[Site, ...]:
        for arc in _sublayers(layer, find):
            layers = [root, *(one.layer for one in above)]
            if arc.layer in layers:
                return tuple(a.site for a in (*above[layers.index(arc.layer) :], arc))
            if len(above) < _DEEP and (found := follow(arc.layer, (*above, arc))):
                return found
        return ()

    return follow(root, ())


def cycle_of_arcs(root: Sdf.Layer, prim: str, find: Find) -> tuple[Site, ...]:
    """The references, payloads and inherits of a cycle, that which closes it last."""
    seen: set[tuple[str, str]] = set()

    def follow(layer: Sdf.Layer, path: Sdf.Path, above: tuple[_Arc, ...]) -> tuple[Site, ...]:
        here = layer.identifier, str(path)
        if here in seen or len(above) > _DEEP:
            return ()
        seen.add(here)
        for arc in _arcs(layer, path, find):
            visited = [(root, Sdf.Path(prim)), *((a.layer, a.path) for a in above)]
            for number, (one, there) in enumerate(visited):
                if one == arc.layer and (there.HasPrefix(arc.path) or arc.path.HasPrefix(there)):
                    return tuple(a.site for a in (*above[number:], arc))
            if found := follow(arc.layer, arc.path, (*above, arc)):
                return found
        return ()

    return follow(root, Sdf.Path(prim), ())


def _sublayers(layer: Sdf.Layer, find: Find) -> Iterator[_Arc]:
    for written in layer.subLayerPaths:
        if found := find(layer, written):
            site = Site("/", "subLayers", written, layer.identifier)
            yield _Arc(found, Sdf.Path.absoluteRootPath, site)


def _stack(layer: Sdf.Layer, find: Find) -> list[Sdf.Layer]:
    """The layer and all below it."""
    found = [layer]
    for one in found:
        found += [arc.layer for arc in _sublayers(one, find) if arc.layer not in found]
    return found


def _arcs(root: Sdf.Layer, path: Sdf.Path, find: Find) -> Iterator[_Arc]:
    """Of a prim and of those above it, in one layer stack."""
    for above in path.GetPrefixes():
        for layer in _stack(root, find):
            for spec in _with_variants(layer.GetPrimAtPath(above)):
                for field, asset, target in _written(spec):
                    to = find(layer, asset) if asset else root
                    inner = target or (_default_prim(to) if to else None)
                    if to and inner:
                        named = spelt(asset, target)
                        at = layer.identifier, str(spec.path)
                        site = Site(str(above), field, named, *at)
                        yield _Arc(to, path.ReplacePrefix(above, inner), site)


def _with_variants(spec: Sdf.PrimSpec | None) -> Iterator[Sdf.PrimSpec]:
    if spec is None:
        return
    yield spec
    for variant in variants_of(spec):
        yield from _with_variants(variant)


def _written(spec: Sdf.PrimSpec) -> Iterator[tuple[str, str, Sdf.Path]]:
    """Field, asset and prim of every arc that a spec adds."""
    for field, operation in (("references", spec.referenceList), ("payload", spec.payloadList)):
        for item in operation.GetAddedOrExplicitItems():
            yield field, str(item.assetPath), item.primPath
    for field, paths in (
        ("inheritPaths", spec.inheritPathList),
        ("specializes", spec.specializesList),
    ):
        for target in paths.GetAddedOrExplicitItems():
            yield field, "", target


def _default_prim(layer: Sdf.Layer) -> Sdf.Path | None:
    name = layer.defaultPrim
    return Sdf.Path(name if name.startswith("/") else f"/{name}") if name else None


def spelt(asset: str, prim: Sdf.Path) -> str:
    """An arc as usda has it, but for the `@`s: what a site calls its target."""
    if not asset:
        return str(prim)
    return asset if prim.isEmpty else f"{asset}<{prim}>"

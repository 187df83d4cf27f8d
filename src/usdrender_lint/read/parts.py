"""Is the stage all of a shot, or a part that other layers complete?"""

from __future__ import annotations

from dataclasses import dataclass

from pxr import Sdf, Usd

from ..model import RENDER_TYPES
from ..stage import Opened, kinds_of, render_prims
from .specs import children_of, there

_SPECS = 1000
"""Of a root prim that may be a mere group of render prims."""


@dataclass(frozen=True, slots=True)
class Part:
    """What the model says of it, under the same names."""

    only_overrides: bool
    is_part: bool
    is_library: bool


def read_part(opened: Opened, default: str | None) -> Part:
    """`default`: the path of the settings that the stage names."""
    stage, scopes = opened.stage, opened.scopes
    roots = _defined_roots(stage)
    is_part = all(str(root.path) in scopes or _is_group_of_render_prims(root) for root in roots)
    is_library = (
        is_part
        and default is None
        and not any("RenderSettings" in kinds_of(p) for p in render_prims(opened))
    )
    return Part(_only_overrides(stage, scopes, roots), is_part, is_library)


class Definitions:
    """Where some layer *defines* a prim of these types, at or below: an `over` alone may be meant for a weaker layer.

    Asked of specs, because below an inactive prim nothing is composed; and of each of them once.
    """

    def __init__(self, types: tuple[str, ...]) -> None:
        self._types = types
        self._known: dict[tuple[str, Sdf.Path], bool] = {}

    def hold(self, stack: list[Sdf.PrimSpec]) -> bool:
        return any(map(self._holds, stack))

    def _holds(self, top: Sdf.PrimSpec) -> bool:
        layer = top.layer.identifier
        if (layer, top.path) in self._known:
            return self._known[layer, top.path]
        met, pending = [], [top]
        while pending:
            spec = pending.pop()
            defines = spec.specifier == Sdf.SpecifierDef and spec.typeName in self._types
            met.append((spec.path, self._known.get((layer, spec.path), defines)))
            if (layer, spec.path) not in self._known:
                pending.extend(children_of(spec))
        holding = set[Sdf.Path]()
        for path, defines in reversed(met):  # what is below comes before
            self._known[layer, path] = defines or path in holding
            if self._known[layer, path]:
                holding.add(path.GetParentPath())
        return self._known[layer, top.path]


def _only_overrides(stage: Usd.Stage, scopes: tuple[str, ...], roots: list[Sdf.PrimSpec]) -> bool:
    tops = [top for scope in scopes if (top := stage.GetPrimAtPath(scope))]
    if not tops or not roots:
        return not roots
    settings = Definitions(("RenderSettings",))
    return not any(top.IsDefined() or settings.hold(top.GetPrimStack()) for top in tops)


def _defined_roots(stage: Usd.Stage) -> list[Sdf.PrimSpec]:
    layers = stage.GetLayerStack(includeSessionLayers=False)
    roots = (root for layer in layers for root in there(layer.rootPrims))
    return [root for root in roots if root.specifier == Sdf.SpecifierDef]


def _is_group_of_render_prims(root: Sdf.PrimSpec) -> bool:
    pending, found = [root], False
    for _ in range(_SPECS):
        if not pending:
            return found
        spec = pending.pop()
        is_render_prim = spec.typeName in RENDER_TYPES
        found = found or is_render_prim
        if not is_render_prim and (spec.typeName not in ("", "Scope") or spec.hasReferences):
            return False
        pending.extend(children_of(spec))
    return False

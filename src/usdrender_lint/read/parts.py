"""Is the stage all of a shot, or a part that other layers complete?"""

from __future__ import annotations

from pxr import Sdf, Usd

from ..model import RENDER_TYPES
from ..records import dataclass
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
        self._layers: dict[str, dict[Sdf.Path, bool]] = {}

    def hold(self, stack: list[Sdf.PrimSpec]) -> bool:
        return any(map(self._holds, stack))

    def _holds(self, top: Sdf.PrimSpec) -> bool:
        known = self._layers.setdefault(top.layer.identifier, {})
        if top.path in known:
            return known[top.path]
        met: list[tuple[Sdf.Path, int]] = []
        """Paths, and the number of the one above."""
        holding = list[bool]()
        pending = [(top, 0)]
        while pending:
            spec, above = pending.pop()
            path = spec.path
            found = known.get(path)
            if found is None:
                found = spec.typeName in self._types and spec.specifier is Sdf.SpecifierDef
                pending += [(child, len(met)) for child in children_of(spec)]
            met.append((path, above))
            holding.append(found)
        for number in range(len(met) - 1, -1, -1):  # what is below comes before
            path, above = met[number]
            known[path] = holding[number]
            holding[above] = holding[above] or holding[number]
        return known[top.path]


def _only_overrides(stage: Usd.Stage, scopes: tuple[str, ...], roots: list[Sdf.PrimSpec]) -> bool:
    tops = [top for scope in scopes if (top := stage.GetPrimAtPath(scope))]
    if not tops or not roots:
        return not roots
    settings = Definitions(("RenderSettings",))
    return not any(top.IsDefined() or settings.hold(top.GetPrimStack()) for top in tops)


def _defined_roots(stage: Usd.Stage) -> list[Sdf.PrimSpec]:
    layers = stage.GetLayerStack(includeSessionLayers=False)
    roots = (root for layer in layers for root in there(layer.rootPrims))
    return [root for root in roots if root.specifier is Sdf.SpecifierDef]


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

"""Which products and vars does anybody list?"""

from __future__ import annotations

from collections.abc import Iterable

from ..likeness import is_like
from ..model import Rel, RenderPrim, RenderScope, Var
from ..rule import Context, once
from ._words import SIMILAR, is_near


def listed(rels: Iterable[Rel]) -> set[str]:
    """What is listed, was listed before a stronger layer replaced the list, or was probably meant by
    a target that leads nowhere: its faults need not wait until that is mended."""
    found = set[str]()
    for rel in rels:
        found.update(c.path for c in rel.clobbered)
        for target in rel.targets:
            found.add(target.path)
            if target.meant:
                found.add(target.meant)
            if not target.live:
                found.update(c.path for c in target.candidates[:1] if is_near(target, c))
    return found


def lost_its_list(prim: RenderPrim, rel: Rel) -> bool:
    """By a fault that is told: it is written as an attribute, or under a misspelt name."""
    if rel.named:
        return rel.written_as_attribute
    unknown = [p.name for p in prim.properties if not p.is_schema and ":" not in p.name]
    return any(is_like(name, rel.name, SIMILAR) for name in unknown)


@once
def live(scope: RenderScope, context: Context) -> tuple[Var, ...]:
    return tuple(v for v in scope.vars if v.live)


@once
def used(scope: RenderScope, context: Context) -> tuple[Var, ...]:
    """Vars that a product lists; where a list was lost, or other layers hold the products, all."""
    lists = [(p, p.ordered_vars) for p in scope.products if p.live]
    if not scope.products or any(lost_its_list(prim, rel) for prim, rel in lists):
        return live(scope, context)
    named = listed(rel for _, rel in lists)
    return tuple(v for v in live(scope, context) if v.path in named)

"""Which products and vars does anybody list?"""

from __future__ import annotations

from collections.abc import Iterable

from ..model import Rel, RenderScope, Var
from ..rule import Context, once
from ._words import is_near


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


@once
def live(scope: RenderScope, context: Context) -> tuple[Var, ...]:
    return tuple(v for v in scope.vars if v.live)


@once
def used(scope: RenderScope, context: Context) -> tuple[Var, ...]:
    """Vars that a product lists; of a layer without products, which other layers complete, all."""
    if not scope.products:
        return live(scope, context)
    named = listed(p.ordered_vars for p in scope.products)
    return tuple(v for v in live(scope, context) if v.path in named)

"""Which vars does anybody write?"""

from __future__ import annotations

from ..model import RenderScope, Var
from ..rule import Context, once


@once
def live(scope: RenderScope, context: Context) -> tuple[Var, ...]:
    return tuple(v for v in scope.vars if v.live)


@once
def used(scope: RenderScope, context: Context) -> tuple[Var, ...]:
    """Vars that a product lists; of a layer without products, which other layers complete, all."""
    if not scope.products:
        return live(scope, context)
    listed = {t.path for p in scope.products for t in p.ordered_vars.targets}
    return tuple(v for v in live(scope, context) if v.path in listed)

"""Which vars does anybody write?"""

from __future__ import annotations

from collections.abc import Iterator

from ..model import RenderScope, Var


def live(scope: RenderScope) -> Iterator[Var]:
    return (v for v in scope.vars if v.live)


def used(scope: RenderScope) -> Iterator[Var]:
    """Vars that a product lists; of a layer without products, which other layers complete, all."""
    listed = {t.path for p in scope.products for t in p.ordered_vars.targets}
    return (v for v in live(scope) if v.path in listed or not scope.products)

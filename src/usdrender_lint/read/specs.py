"""Which specs does a layer list, and are they there?

In a damaged crate they may not be: USD then gives None where nothing in its documentation says so.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

from pxr import Sdf

from ..opening import DamagedError

_Spec = TypeVar("_Spec")


def there(specs: Iterable[_Spec | None]) -> list[_Spec]:
    found = []
    for spec in specs:
        if spec is None:
            raise DamagedError("it lists a prim or variant that is not there")
        found.append(spec)
    return found


def children_of(spec: Sdf.PrimSpec) -> list[Sdf.PrimSpec]:
    return there(spec.nameChildren)


def variants_of(spec: Sdf.PrimSpec) -> list[Sdf.PrimSpec]:
    """The prims of all variants of all variant sets."""
    sets = there(spec.variantSets.values())
    return there(v.primSpec for one in sets for v in there(one.variants.values()))


def look_through(layer: Sdf.Layer) -> None:
    """Raise if a prim or variant is listed and not there."""
    pending = there(layer.rootPrims)
    while pending:
        one = pending.pop()
        pending += children_of(one)
        pending += variants_of(one)

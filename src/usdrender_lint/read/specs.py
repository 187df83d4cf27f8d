"""Which specs does a layer list, and are they there?

In a damaged crate they may not be: USD then gives None where nothing in its documentation says so.

Listed by their number, for a loop over what USD holds ends with a C++ exception, which takes longer
than ten specs do.
"""

from __future__ import annotations

from typing import Protocol, TypeVar

from pxr import Sdf

from ..unopened import DamagedError

_Spec = TypeVar("_Spec")
_Item = TypeVar("_Item", covariant=True)


class Listed(Protocol[_Item]):
    """What USD has instead of a list."""

    def __len__(self) -> int: ...

    def __getitem__(self, index: int, /) -> _Item: ...


def items(listed: Listed[_Item]) -> list[_Item]:
    return [listed[index] for index in range(len(listed))]


def there(specs: Listed[_Spec | None]) -> list[_Spec]:
    found = []
    for index in range(len(specs)):
        spec = specs[index]
        if spec is None:
            raise DamagedError("it lists a prim or variant that is not there")
        found.append(spec)
    return found


def children_of(spec: Sdf.PrimSpec) -> list[Sdf.PrimSpec]:
    return there(spec.nameChildren)


def variants_of(spec: Sdf.PrimSpec) -> list[Sdf.PrimSpec]:
    """The prims of all variants of all variant sets."""
    found = []
    for one in there(spec.variantSets):
        found += [variant.primSpec for variant in there(one.variants)]
    return there(found) if found else found


def look_through(layer: Sdf.Layer) -> None:
    """Raise if a prim or variant is listed and not there."""
    pending = there(layer.rootPrims)
    while pending:
        one = pending.pop()
        pending += children_of(one)
        pending += variants_of(one)

"""Which render prims stand outside the render scope, asked of layers rather than of the stage?"""

from __future__ import annotations

import mmap
import re
from collections.abc import Iterator
from pathlib import Path

from pxr import Sdf, Usd

from ..model import RENDER_TYPES
from .crate import mentions

_WORD = re.compile(rb"\bRender(?:Settings|Product|Var|Pass)\b")


def stray_paths(stage: Usd.Stage, scopes: tuple[str, ...]) -> list[str]:
    """Composed paths of specs of a render type outside the scopes, in the root layer stack, sorted."""
    found: set[str] = set()
    for layer in stage.GetLayerStack(includeSessionLayers=False):
        if _may_have_strays(layer, scopes):
            found.update(_outside(layer, scopes))
    return sorted(found)


def _may_have_strays(layer: Sdf.Layer, scopes: tuple[str, ...]) -> bool:
    """A walk of all specs from Python costs 7 us each: most layers can be spared it."""
    file = layer.realPath
    if not file or not Path(file).is_file():
        return True
    with Path(file).open("rb") as stream:
        head = stream.read(8)
    if head.startswith(b"PXR-USDC"):
        return mentions(file, [t.encode() for t in RENDER_TYPES]) is not False
    if head.startswith(b"PK"):
        return True
    # Every typed spec has its type's name in the text once. Where the scopes account for all of
    # the names, none is left for a stray; a name in a comment or string costs a walk, no more.
    return _named_in_text(file) > _inside(layer, scopes)


def _named_in_text(file: str) -> int:
    with Path(file).open("rb") as stream:
        if not stream.read(1):
            return 0
        with mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as text:
            return sum(1 for _ in _WORD.finditer(text))


def _inside(layer: Sdf.Layer, scopes: tuple[str, ...]) -> int:
    count = 0
    for scope in scopes:
        if spec := layer.GetPrimAtPath(scope):
            count += sum(s.typeName in RENDER_TYPES for s in _walk(spec))
    return count


def _outside(layer: Sdf.Layer, scopes: tuple[str, ...]) -> Iterator[str]:
    for root in layer.rootPrims:
        for spec in _walk(root, skip=scopes):
            if spec.typeName in RENDER_TYPES:
                yield str(spec.path.StripAllVariantSelections())


def _walk(spec: Sdf.PrimSpec, skip: tuple[str, ...] = ()) -> Iterator[Sdf.PrimSpec]:
    pending = [spec]
    while pending:
        one = pending.pop()
        if skip and str(one.path) in skip:
            # A render prim *at* the scope's own path is outside, too.
            if one.typeName in RENDER_TYPES:
                yield one
            continue
        yield one
        pending.extend(one.nameChildren)
        for variants in one.variantSets:
            pending.extend(v.primSpec for v in variants.variants)

"""Which prims does a pattern name that only hold what is to be seen?

Asked of composed prims down to the level above, and from there of specs: no prim is populated only
to learn that it is a group.
"""

from __future__ import annotations

from collections.abc import Iterator
from fnmatch import fnmatchcase
from functools import cache

from pxr import Sdf, Usd

from .patterns import STRETCH, Node, Parsed
from .specs import children_of

_MANY = 64
"""Children of one prim that a wildcard is tried on."""
_DEEP = 4
"""Levels of specs that are searched for something to be seen."""

_ARCS = ("references", "payload", "inheritPaths", "specializes", "variantSetNames")

Specs = list[Sdf.PrimSpec]


def matching(stage: Usd.Stage, parts: tuple[str, ...]) -> tuple[list[Usd.Prim], list[str]]:
    """Prims that the parts of a pattern without stretches name, and on the way to others the paths
    that are not populated yet."""
    found, outside = [stage.GetPseudoRoot()], list[str]()
    for part in parts:
        if part == STRETCH:
            return [], []
        paths = [p.GetPath().AppendChild(name) for p in found for name in _names(p, part)]
        found = [prim for path in paths if (prim := stage.GetPrimAtPath(path))]
        outside += [str(path) for path in paths if not stage.GetPrimAtPath(path)]
    return found, outside


def _names(prim: Usd.Prim, part: str) -> list[str]:
    names = prim.GetPrimIndex().ComputePrimChildNames()[0]
    if part in names:
        return [part]
    return [name for name in names if fnmatchcase(name, part)][:_MANY]


def cut_groups(stage: Usd.Stage, pattern: Parsed, expression: Node) -> Iterator[str]:
    """Groups that the pattern names while the expression holds nothing below them."""
    if not pattern.bare or pattern.conditions:
        return
    for above in matching(stage, pattern.parts[:-1])[0]:
        for name in _names(above, pattern.parts[-1]):
            path = str(above.GetPath().AppendChild(name))
            if expression.holds(path) is False or expression.may_hold_below(path):
                continue
            prim = stage.GetPrimAtPath(path)
            if is_group(prim) if prim else _is_group(_specs(above, name)):
                yield path


def is_group(prim: Usd.Prim) -> bool:
    """Nothing is to be seen of it but what is below it."""
    return _is_group(prim.GetPrimStack(), composed=True)


def _specs(above: Usd.Prim, name: str) -> Specs:
    found = (spec.nameChildren.get(name) for spec in above.GetPrimStack())
    return [spec for spec in found if spec is not None]


def _is_group(specs: Specs, *, composed: bool = False) -> bool:
    """`composed`: the specs that the prim's arcs bring in are among them."""
    if not _is_active(specs) or _may_be_seen(specs):
        return False
    return (not composed and _has_arcs(specs)) or any(map(_shows, _children(specs)))


def _shows(specs: Specs, depth: int = _DEEP) -> bool:
    """The prim of these specs, or one below it, may be geometry or a light."""
    if not _is_active(specs):
        return False
    if not depth or _has_arcs(specs) or _may_be_seen(specs):
        return True
    return any(_shows(children, depth - 1) for children in _children(specs))


def _is_active(specs: Specs) -> bool:
    return next((bool(s.active) for s in specs if s.HasInfo("active")), True)


def _has_arcs(specs: Specs) -> bool:
    return any(spec.HasInfo(field) for spec in specs for field in _ARCS)


def _children(specs: Specs) -> Iterator[Specs]:
    for name in dict.fromkeys(child.name for spec in specs for child in children_of(spec)):
        yield [spec.nameChildren[name] for spec in specs if name in spec.nameChildren]


def _may_be_seen(specs: Specs) -> bool:
    type_name = next((str(s.typeName) for s in specs if s.typeName), "")
    return bool(type_name) and _is_seen(type_name)


@cache
def _is_seen(type_name: str) -> bool:
    """Geometry, a light, or of a type that only a plugin knows."""
    registry = Usd.SchemaRegistry()
    kind = registry.GetTypeFromSchemaTypeName(type_name)
    if not kind:
        return True
    if type_name == "SkelRoot":  # has bounds, and is a group
        return False
    if any(kind.IsA(registry.GetTypeFromSchemaTypeName(n)) for n in ("Boundable", "LightFilter")):
        return True
    definition = registry.FindConcretePrimDefinition(type_name)
    return definition is not None and "LightAPI" in definition.GetAppliedAPISchemas()

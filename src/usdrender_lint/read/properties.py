"""Which properties are authored on a prim, and are they what its schema says they are?"""

from __future__ import annotations

from functools import cache

from pxr import Sdf, Usd, Vt

from ..model import RENDER_TYPES, Property, Site
from ..unopened import DamagedError
from .prims import Asked, Opinion
from .specs import items
from .values import VARYING

_OTHER_OPINIONS = (*VARYING, "targetPaths")
"""Fields of a property that say something, beside `default`."""


@cache
def built_in_of(type_name: str) -> frozenset[str]:
    """Un-namespaced properties that the schema of a render type has."""
    definition = Usd.SchemaRegistry().FindConcretePrimDefinition(type_name)
    return frozenset(n for n in definition.GetPropertyNames() if ":" not in n)


def owners_of(name: str) -> tuple[str, ...]:
    return tuple(t for t in RENDER_TYPES if name in built_in_of(t))


def read_properties(asked: Asked) -> tuple[Property, ...]:
    """Every property that some layer authors, by name."""
    return tuple(read_property(asked, name) for name in sorted(asked.authored))


def read_property(asked: Asked, name: str) -> Property:
    """One that some layer authors."""
    path, schema = f"{asked.path}.{name}", asked.schema
    is_schema = name in schema.names
    if not is_schema and ":" in name:
        # Nobody judges a namespaced property but by its name: spare its property stack.
        return Property(name, Site(path), is_relationship=False)
    said = asked.opinions(name)
    if not said:
        raise DamagedError(f"it lists the property <{path}>, which is not there")
    declared = schema.attribute(name) if is_schema else None
    first = said[0]
    if first.is_relationship:  # the strongest decides what USD takes it for
        # It may only declare it, and a weaker one name the targets.
        first = next((one for one in said if one.spec.HasInfo("targetPaths")), first)
    elif is_schema and not first.has_default:
        first = next((one for one in said if _has_value(one)), first)
    spec = first.spec
    allowed = declared.allowed if declared is not None and not first.is_relationship else ()
    refused = _refused(spec, allowed) if allowed else ()
    return Property(
        name,
        Site(path, None if first.is_relationship else "typeName", None, *asked.where(first, name)),
        first.is_relationship,
        first.type_name,
        is_schema,
        declared.type_name if declared is not None else "",
        schema.is_relationship(name),
        declared is None or first.is_relationship or declared.takes(first),
        () if is_schema else owners_of(name),
        spec.custom,
        first.has_default or any(map(spec.HasInfo, _OTHER_OPINIONS)),
        not first.is_relationship and spec.variability is Sdf.VariabilityUniform,
        declared is not None and declared.uniform,
        refused,
        allowed if refused else (),
    )


def _has_value(one: Opinion) -> bool:
    return one.has_default or bool(one.spec.HasInfo("timeSamples"))


def _refused(spec: Sdf.AttributeSpec, allowed: tuple[str, ...]) -> tuple[str, ...]:
    value = spec.default
    if isinstance(value, str):
        return () if value in allowed else (value,)
    if isinstance(value, Vt.TokenArray):
        return tuple(str(t) for t in items(value) if str(t) not in allowed)
    return ()  # nothing, a block, or of another type

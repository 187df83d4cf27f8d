"""What does a typed C++ read at the default time get for a schema attribute?"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, TypeVar

from pxr import Sdf, Usd, Vt

from ..model import RENDER_TYPES, Attr, Property, Site, ValueState
from ..opening import DamagedError
from .prims import Asked, Declared
from .specs import items

T = TypeVar("T")

_VARYING = ("timeSamples", "spline")
_VALUES = ("default", "timeSamples")
_OPINIONS = ("default", *_VARYING, "targetPaths")

# Looked up on an object, USD checks the object first, which takes longer than these do.
_attribute = Usd.Prim.GetAttribute
_attribute_type = Usd.Attribute.GetTypeName
_get = Usd.Attribute.Get


_EDITS = frozenset(getattr(Vt, name) for name in dir(Vt) if name.endswith("ArrayEdit"))
"""What `edit [append "x"]` is: not an array, but what becomes of that of a weaker layer."""
_EDIT = "edit [...]"


def plain_text(value: Any) -> str:
    return str(value)


def plain_tokens(value: Any) -> tuple[str, ...]:
    return tuple(map(str, items(value)))


def plain_ints(value: Any) -> tuple[int, ...]:
    return tuple(map(int, value[:]))


def plain_floats(value: Any) -> tuple[float, ...]:
    return tuple(map(float, value[:]))


def plain_asset(value: Any) -> str:
    return str(value.path)


def plain_expression(value: Any) -> str:
    return str(value.GetText())


def read_attr(
    asked: Asked,
    name: str,
    plain: Callable[[Any], T],
    empty: T,
    *,
    with_samples: bool = False,
) -> Attr[T]:
    """`empty` is what a reader holds when the value is blocked: a block kills the fallback too."""
    site = Site(f"{asked.path}.{name}", "default")
    fallback = asked.schema.fallback(name, plain, empty)
    if name not in asked.authored:
        return Attr(name, fallback, ValueState.FALLBACK, site)
    attribute = _attribute(asked.prim, name)
    if not attribute:
        return Attr(name, fallback, ValueState.FALLBACK, site)
    stack = [spec for spec in asked.specs(name) if isinstance(spec, Sdf.AttributeSpec)]
    authored_type = str(stack[0].typeName) if stack else None
    valued = [spec for spec in stack if spec.HasInfo("default")]
    varying = _varying(stack, valued)
    samples = _samples(attribute, plain) if with_samples and varying else ()
    spec, said, unread = _counting(valued, asked.schema.attribute(name))
    if spec is not None and spec is not valued[0]:
        # Only what is passed over makes another opinion than the strongest count.
        site = Site(site.path, "default", None, spec.layer.identifier, str(spec.path))
    value, state = fallback, ValueState.FALLBACK
    if type(said) in _EDITS:
        said = _get(attribute)
        if type(said) in _EDITS or said is None:  # before 26.05, which reads none
            spec, unread = None, unread or _EDIT
    if isinstance(said, Sdf.ValueBlock):
        value, state = empty, ValueState.BLOCKED
    elif spec is not None:
        value, state = (
            plain(said),
            ValueState.MISTYPED if unread is not None else ValueState.AUTHORED,
        )
    elif unread is not None:
        state = ValueState.MISTYPED
    elif varying is not None:
        state, site = ValueState.SAMPLED, Site(site.path, varying)
    return Attr(name, value, state, site, samples, authored_type, varying, unread or "")


def _counting(
    valued: list[Sdf.AttributeSpec], declared: Declared | None
) -> tuple[Sdf.AttributeSpec | None, Any, str | None]:
    """Of the opinions that hold a default the first that is read, if any, and its default; and what
    the first one says that is passed over for its type."""
    unread = None
    for spec in valued:
        said = spec.default
        # An animation block ends the samples of weaker layers, and lets their defaults through.
        if isinstance(said, Sdf.AnimationBlock):
            continue
        written = spec.typeName
        if (
            isinstance(said, Sdf.ValueBlock)
            or declared is None
            or declared.fits(written, str(written))
        ):
            return spec, said, unread
        # Passed over, not refused: a weaker opinion of the right type is read (26.11).
        unread = unread or _as_text(said, bool(written.isArray))
    return None, None, unread


def _varying(stack: list[Sdf.AttributeSpec], valued: list[Sdf.AttributeSpec]) -> str | None:
    """How the value changes over time: a stronger layer's default ends the samples of weaker ones."""
    for spec in stack:
        for field in _VARYING:
            if spec.HasInfo(field):
                return field
        if spec in valued:
            return None
    return None


def read_extras(asked: Asked) -> tuple[Attr[str], ...]:
    """What renderers and studios author beside the schema; at the first sample where there is no
    default, for it is never meant to vary."""
    found = []
    names = asked.schema.names
    for name in asked.authored:
        attribute = None if name in names else _attribute(asked.prim, name)
        if not attribute:
            continue
        value = _get(attribute)
        if value is None:
            value = _get(attribute, Usd.TimeCode.EarliestTime())
        type_name = _attribute_type(attribute)
        text = _as_text(value, bool(type_name.isArray))
        state = ValueState.FALLBACK if value is None else ValueState.AUTHORED
        site = Site(f"{asked.path}.{name}", "default")
        found.append(Attr(name, text, state, site, (), str(type_name)))
    return tuple(found)


def _as_text(value: Any, is_array: bool) -> str:
    if value is None:
        return ""
    if type(value) in _EDITS:
        return _EDIT
    if is_array:
        return f"[{len(value)}]"  # nobody reads it, and it may be long
    if isinstance(value, bool):
        return str(value).lower()
    return str(value)


def _samples(attribute: Usd.Attribute, plain: Callable[[Any], T]) -> tuple[tuple[float, T], ...]:
    found = []
    for time in attribute.GetTimeSamples():
        value = attribute.Get(time)
        readable = value is not None and type(value) not in _EDITS
        if readable and not isinstance(value, Sdf.AssetPath):
            found.append((float(time), plain(value)))
    return tuple(found)


@cache
def built_in_of(type_name: str) -> frozenset[str]:
    """Un-namespaced properties that the schema of a render type has."""
    definition = Usd.SchemaRegistry().FindConcretePrimDefinition(type_name)
    return frozenset(n for n in definition.GetPropertyNames() if ":" not in n)


def owners_of(name: str) -> tuple[str, ...]:
    return tuple(t for t in RENDER_TYPES if name in built_in_of(t))


def read_properties(asked: Asked) -> tuple[Property, ...]:
    """Every property that some layer authors, by name."""
    return tuple(_read_property(asked, name) for name in sorted(asked.authored))


def _read_property(asked: Asked, name: str) -> Property:
    path, schema = f"{asked.path}.{name}", asked.schema
    is_schema = name in schema.names
    if not is_schema and ":" in name:
        # Nobody judges a namespaced property but by its name: spare its property stack.
        return Property(name, Site(path), is_relationship=False)
    stack = asked.specs(name)
    if not stack:
        raise DamagedError(f"it lists the property <{path}>, which is not there")
    declared = schema.attribute(name) if is_schema else None
    spec = stack[0]  # decides whether USD takes it for a relationship
    if isinstance(spec, Sdf.RelationshipSpec):
        # A stronger layer may declare it, and a weaker one name the targets.
        spec = _first_with(stack, ("targetPaths",)) or spec
        return Property(
            name,
            Site(path, None, None, spec.layer.identifier, str(spec.path)),
            is_relationship=True,
            is_schema=is_schema,
            schema_type=declared.type_name if declared is not None else "",
            schema_is_relationship=schema.is_relationship(name),
            belongs_to=() if is_schema else owners_of(name),
            custom=bool(spec.custom),
            has_value=any(map(spec.HasInfo, _OPINIONS)),
            schema_uniform=declared is not None and declared.uniform,
        )
    if is_schema:
        spec = _first_with(stack, _VALUES) or spec
    type_name = str(spec.typeName)
    refused = _refused(spec, declared.allowed) if declared is not None and declared.allowed else ()
    return Property(
        name,
        Site(path, "typeName", None, spec.layer.identifier, str(spec.path)),
        False,
        type_name,
        is_schema,
        declared.type_name if declared is not None else "",
        schema.is_relationship(name),
        declared is None or declared.fits(spec.typeName, type_name),
        () if is_schema else owners_of(name),
        bool(spec.custom),
        any(map(spec.HasInfo, _OPINIONS)),
        spec.variability == Sdf.VariabilityUniform,
        declared is not None and declared.uniform,
        refused,
        declared.allowed if declared is not None and refused else (),
    )


def _first_with(stack: list[Sdf.PropertySpec], fields: tuple[str, ...]) -> Sdf.PropertySpec | None:
    for spec in stack:
        if any(map(spec.HasInfo, fields)):
            return spec
    return None


def _refused(spec: Sdf.AttributeSpec, allowed: tuple[str, ...]) -> tuple[str, ...]:
    value = spec.default
    if isinstance(value, str):
        return () if value in allowed else (value,)
    if isinstance(value, Vt.TokenArray):
        return tuple(str(t) for t in items(value) if str(t) not in allowed)
    return ()  # nothing, a block, or of another type

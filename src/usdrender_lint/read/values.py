"""What does a typed C++ read at the default time get for a schema attribute?"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any, TypeVar

from pxr import Sdf, Usd, Vt

from ..model import RENDER_TYPES, Attr, Property, Site, ValueState
from ..opening import DamagedError

T = TypeVar("T")

_VARYING = ("timeSamples", "spline")
_OPINIONS = ("default", *_VARYING, "targetPaths")


def plain_text(value: Any) -> str:
    return str(value)


def plain_tokens(value: Any) -> tuple[str, ...]:
    return tuple(str(v) for v in value)


def plain_ints(value: Any) -> tuple[int, ...]:
    return tuple(int(v) for v in value)


def plain_floats(value: Any) -> tuple[float, ...]:
    return tuple(float(v) for v in value)


def plain_asset(value: Any) -> str:
    return str(value.path)


def plain_expression(value: Any) -> str:
    return str(value.GetText())


class Schema:
    """What the schemas of a prim say about its properties. Asked of USD once a combination of them."""

    def __init__(self, definition: Usd.PrimDefinition) -> None:
        self._definition = definition
        self.names = frozenset(map(str, definition.GetPropertyNames()))
        self.built_in = tuple(sorted(name for name in self.names if ":" not in name))
        """Those without a namespace."""
        self._attributes: dict[str, Sdf.AttributeSpec | None] = {}

    def attribute(self, name: str) -> Sdf.AttributeSpec | None:
        if name not in self._attributes:
            self._attributes[name] = self._definition.GetSchemaAttributeSpec(name)
        return self._attributes[name]

    def is_relationship(self, name: str) -> bool:
        return name in self.names and self.attribute(name) is None


_schemas: dict[tuple[str, ...], Schema] = {}
"""By the type of a prim and all that is applied to it."""


class Asked:
    """A prim, and what every question about its properties begins with."""

    def __init__(self, prim: Usd.Prim, path: str = "") -> None:
        self.prim = prim
        self.path = path or str(prim.GetPath())
        self.authored = dict.fromkeys(prim.GetAuthoredPropertyNames())
        """Names, in the order of USD."""
        info = prim.GetPrimTypeInfo()
        schemas = (info.GetSchemaTypeName(), *info.GetAppliedAPISchemas())
        if schemas not in _schemas:
            _schemas[schemas] = Schema(prim.GetPrimDefinition())
        self.schema = _schemas[schemas]


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
    schema = asked.schema.attribute(name)
    fallback = empty
    if schema is not None and (default := schema.default) is not None:
        fallback = plain(default)
    if name not in asked.authored:
        return Attr(name, fallback, ValueState.FALLBACK, site)
    attribute = asked.prim.GetAttribute(name)
    if not attribute:
        return Attr(name, fallback, ValueState.FALLBACK, site)
    stack = [
        spec
        for spec in attribute.GetPropertyStack(Usd.TimeCode.Default())
        if isinstance(spec, Sdf.AttributeSpec)
    ]
    authored_type = str(stack[0].typeName) if stack else None
    varying = _varying(stack)
    samples = _samples(attribute, plain) if with_samples and varying else ()

    unread = ""
    strongest = next((spec for spec in stack if spec.HasInfo("default")), None)

    def attr(value: T, state: ValueState, at: Site = site) -> Attr[T]:
        return Attr(name, value, state, at, samples, authored_type, varying, unread)

    def at(spec: Sdf.AttributeSpec) -> Site:
        # Only what is passed over makes another opinion than the strongest count.
        if spec == strongest:
            return site
        return replace(site, layer=spec.layer.identifier, spec=str(spec.path))

    state = ValueState.AUTHORED
    for spec in stack:
        # An animation block ends the samples of weaker layers, and lets their defaults through.
        if not spec.HasInfo("default") or isinstance(spec.default, Sdf.AnimationBlock):
            continue
        if isinstance(spec.default, Sdf.ValueBlock):
            return attr(empty, ValueState.BLOCKED, at(spec))
        if schema is not None and not same_storage(spec.typeName, schema.typeName):
            # Passed over, not refused: a weaker opinion of the right type is read (26.11).
            state = ValueState.MISTYPED
            unread = unread or _as_text(spec.default, bool(spec.typeName.isArray))
            continue
        return attr(plain(spec.default), state, at(spec))
    if state is ValueState.MISTYPED:
        return attr(fallback, state)
    if varying is not None:
        return attr(fallback, ValueState.SAMPLED, Site(site.path, varying))
    return attr(fallback, ValueState.FALLBACK)


def _varying(stack: list[Sdf.AttributeSpec]) -> str | None:
    """How the value changes over time: a stronger layer's default ends the samples of weaker ones."""
    fields = ("default", *_VARYING)
    strongest = next((s for s in stack if any(s.HasInfo(f) for f in fields)), None)
    return next((f for f in _VARYING if strongest is not None and strongest.HasInfo(f)), None)


def read_extras(asked: Asked) -> tuple[Attr[str], ...]:
    """What renderers and studios author beside the schema; at the first sample where there is no
    default, for it is never meant to vary."""
    found = []
    for name in asked.authored:
        attribute = None if name in asked.schema.names else asked.prim.GetAttribute(name)
        if not attribute:
            continue
        value = attribute.Get()
        if value is None:
            value = attribute.Get(Usd.TimeCode.EarliestTime())
        text = _as_text(value, bool(attribute.GetTypeName().isArray))
        state = ValueState.FALLBACK if value is None else ValueState.AUTHORED
        site = Site(f"{asked.path}.{name}", "default")
        found.append(Attr(name, text, state, site, (), str(attribute.GetTypeName())))
    return tuple(found)


def _as_text(value: Any, is_array: bool) -> str:
    if value is None:
        return ""
    if is_array:
        return f"[{len(value)}]"  # nobody reads it, and it may be long
    if isinstance(value, bool):
        return str(value).lower()
    return str(value)


def _samples(attribute: Usd.Attribute, plain: Callable[[Any], T]) -> tuple[tuple[float, T], ...]:
    found = []
    for time in attribute.GetTimeSamples():
        value = attribute.Get(time)
        if value is not None and not isinstance(value, Sdf.AssetPath):
            found.append((float(time), plain(value)))
    return tuple(found)


def same_storage(one: Sdf.ValueTypeName, other: Sdf.ValueTypeName) -> bool:
    """Types that differ in role only (`color3f`, `float3`) are read alike."""
    return bool(one.type == other.type)


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
    stack = asked.prim.GetProperty(name).GetPropertyStack(Usd.TimeCode.Default())
    wanted_rel = schema.is_relationship(name)
    if not stack:
        raise DamagedError(f"it lists the property <{path}>, which is not there")
    spec = stack[0]  # decides whether USD takes it for a relationship
    if is_schema and not isinstance(spec, Sdf.RelationshipSpec):
        valued = (s for s in stack if s.HasInfo("default") or s.HasInfo("timeSamples"))
        spec = next(valued, spec)
    is_rel = isinstance(spec, Sdf.RelationshipSpec)
    if is_rel:  # a stronger layer may declare it, and a weaker one name the targets
        spec = next((s for s in stack if s.HasInfo("targetPaths")), spec)
    schema_attr = schema.attribute(name) if is_schema else None
    allowed = _allowed(schema_attr)
    refused = _refused(spec, allowed) if allowed and not is_rel else ()
    return Property(
        name,
        Site(
            path,
            None if is_rel else "typeName",
            layer=spec.layer.identifier,
            spec=str(spec.path),
        ),
        is_rel,
        "" if is_rel else str(spec.typeName),
        is_schema,
        str(schema_attr.typeName) if schema_attr is not None else "",
        wanted_rel,
        schema_attr is None or is_rel or same_storage(spec.typeName, schema_attr.typeName),
        () if is_schema else owners_of(name),
        bool(spec.custom),
        any(spec.HasInfo(field) for field in _OPINIONS),
        not is_rel and spec.variability == Sdf.VariabilityUniform,
        schema_attr is not None and schema_attr.variability == Sdf.VariabilityUniform,
        refused,
        allowed if refused else (),
    )


def _allowed(schema_attr: Sdf.AttributeSpec | None) -> tuple[str, ...]:
    tokens = schema_attr.allowedTokens if schema_attr is not None else None
    return tuple(str(t) for t in tokens) if tokens else ()


def _refused(spec: Sdf.AttributeSpec, allowed: tuple[str, ...]) -> tuple[str, ...]:
    value = spec.default
    if not isinstance(value, str | Vt.TokenArray):
        return ()  # nothing, a block, or of another type
    tokens = (value,) if isinstance(value, str) else tuple(value)
    return tuple(str(t) for t in tokens if str(t) not in allowed)

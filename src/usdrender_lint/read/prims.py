"""What does every question about a prim begin with? Asked of USD once.

The methods are taken from their classes: looked up on an object, USD checks the object first, which
takes longer than most of them do. An object that is no more they refuse all the same.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

from pxr import Sdf, Tf, Usd

from ..model import State
from ..records import dataclass
from ..stage import Opened, in_scopes, is_render_type, kinds_of, render_prims
from ..unopened import DamagedError
from .specs import items

T = TypeVar("T")

_path = Usd.Prim.GetPath
_type_name = Usd.Prim.GetTypeName
_is_active = Usd.Prim.IsActive
_is_abstract = Usd.Prim.IsAbstract
_is_defined = Usd.Prim.IsDefined
_is_proxy = Usd.Prim.IsInstanceProxy
_stack = Usd.Prim.GetPrimStack
_names = Usd.Prim.GetAuthoredPropertyNames
_type_info = Usd.Prim.GetPrimTypeInfo
_property = Usd.Prim.GetProperty
_index = Usd.Prim.GetPrimIndex
_property_stack = Usd.Property.GetPropertyStack


@dataclass(frozen=True, slots=True)
class Declared:
    """An attribute of a schema."""

    type: Sdf.ValueTypeName
    type_name: str
    default: Any
    uniform: bool
    allowed: tuple[str, ...]
    """The tokens that it may hold, where it may not hold any."""

    def takes(self, said: Opinion) -> bool:
        """A typed read takes a value of the type that the opinion has."""
        return said.type_name == self.type_name or same_storage(said.type, self.type)

    def checked(self, value: T, path: str) -> T:
        """The value, where it is what its attribute says that it is. Sdf writes no other, but a
        damaged crate may hold one: `DamagedError`."""
        if self.default is not None and type(value) is not type(self.default):
            raise DamagedError(f"the value of <{path}> is not of the type of its attribute")
        return value


class Schema:
    """What the schemas of a prim say about its properties. Asked of USD once a combination of them."""

    def __init__(self, definition: Usd.PrimDefinition, applied: tuple[str, ...]) -> None:
        self._definition = definition
        self.applied = applied
        """What `apiSchemas` lists."""
        self.collections = collections_among(definition.GetAppliedAPISchemas())
        """Names of its collections, built in or by `apiSchemas`."""
        self.names = frozenset(map(str, definition.GetPropertyNames()))
        self.built_in = tuple(sorted(name for name in self.names if ":" not in name))
        """Those without a namespace."""
        self._attributes: dict[str, Declared | None] = {}
        self._fallbacks: dict[str, Any] = {}

    def attribute(self, name: str) -> Declared | None:
        if name not in self._attributes:
            self._attributes[name] = _declared(self._definition.GetSchemaAttributeSpec(name))
        return self._attributes[name]

    def fallback(self, name: str, plain: Callable[[Any], T], empty: T) -> T:
        """What is read where nothing is authored; `empty` where the schema has nothing, either."""
        found: T | None = self._fallbacks.get(name)
        if found is None:
            declared = self.attribute(name)
            default = None if declared is None else declared.default
            found = self._fallbacks[name] = empty if default is None else plain(default)
        return found

    def is_relationship(self, name: str) -> bool:
        return name in self.names and self.attribute(name) is None


def collections_among(schemas: Iterable[str]) -> tuple[str, ...]:
    return tuple(s.partition(":")[2] for s in schemas if s.startswith("CollectionAPI:"))


def _declared(spec: Sdf.AttributeSpec | None) -> Declared | None:
    if spec is None:
        return None
    tokens = spec.allowedTokens
    return Declared(
        spec.typeName,
        str(spec.typeName),
        spec.default,
        spec.variability is Sdf.VariabilityUniform,
        tuple(map(str, items(tokens))) if tokens else (),
    )


def same_storage(one: Sdf.ValueTypeName, other: Sdf.ValueTypeName) -> bool:
    """Types that differ in role only (`color3f`, `float3`) are read alike."""
    return bool(one.type == other.type)


_schemas: dict[tuple[str, ...], Schema] = {}
"""By the type of a prim and all that is applied to it."""


def _schema_of(prim: Usd.Prim) -> Schema:
    info = _type_info(prim)
    applied = info.GetAppliedAPISchemas()
    schemas = (info.GetSchemaTypeName(), *applied)
    found = _schemas.get(schemas)
    if found is None:
        found = _schemas[schemas] = Schema(prim.GetPrimDefinition(), tuple(applied))
    return found


class Opinion:
    """What one layer says about a property, as far as several readers want to know it."""

    __slots__ = ("has_default", "is_relationship", "spec", "type", "type_name")

    def __init__(self, spec: Sdf.PropertySpec) -> None:
        self.spec = spec
        self.is_relationship = isinstance(spec, Sdf.RelationshipSpec)
        self.has_default = False
        self.type: Any = None
        self.type_name = ""
        if not self.is_relationship:
            self.has_default = spec.HasInfo("default")
            self.type = spec.typeName
            self.type_name = str(self.type)


class Asked:
    """A prim, and what more than one question about it begins with."""

    __slots__ = (
        "_only", "_opinions", "at", "authored", "kinds", "path", "prim", "schema", "stack", "state", "type_name",
    )  # fmt: skip

    def __init__(self, prim: Usd.Prim, path: str = "") -> None:
        self.prim = prim
        self.at: Sdf.Path = _path(prim)
        self.path = path or str(self.at)
        self.type_name: str = _type_name(prim)
        self.kinds = kinds_of(prim)
        self.state = state_of(prim)
        self.stack: list[Sdf.PrimSpec] = _stack(prim)
        self.authored = dict.fromkeys(_names(prim))
        """Names of properties, in the order of USD."""
        self._opinions: dict[str, list[Opinion]] = {}
        self.schema = _schema_of(prim)
        self._only: tuple[str, str] | None = None

    @property
    def is_render_prim(self) -> bool:
        return is_render_type(self.kinds)

    @property
    def is_proxy(self) -> bool:
        """It stands in an instance."""
        return bool(_is_proxy(self.prim))

    @property
    def is_known(self) -> bool:
        return type_is_known(self.prim)

    @property
    def has_arcs(self) -> bool:
        """Something else than the root layer stack brings in opinions."""
        return bool(_index(self.prim).rootNode.children)

    def opinions(self, name: str) -> list[Opinion]:
        """About one of its properties, strongest first."""
        found = self._opinions.get(name)
        if found is None:
            stack = _property_stack(_property(self.prim, name))
            found = self._opinions[name] = [Opinion(spec) for spec in stack]
        return found

    def where(self, one: Opinion, name: str) -> tuple[str, str]:
        """The layer that has the opinion about a property, and its path there."""
        if len(self.stack) != 1:
            return one.spec.layer.identifier, str(one.spec.path)
        if self._only is None:
            (only,) = self.stack
            self._only = only.layer.identifier, str(only.path)
        layer, path = self._only
        return layer, f"{path}.{name}"


class Prims:
    """The prims of a stage that are read, once its mask holds them all."""

    def __init__(self, opened: Opened) -> None:
        self._spelt: dict[Sdf.Path, str] = {}
        self._at: dict[Sdf.Path, Asked] = {}
        self.in_scopes = self._asked(in_scopes(opened))
        self.rendered = self._asked(render_prims(opened))
        self.groups = [one for one in self.in_scopes if not one.is_render_prim]
        """The scopes, and what stands below them and is no render prim."""

    def at(self, path: Sdf.Path) -> Asked | None:
        return self._at.get(path)

    def _asked(self, prims: Iterable[Usd.Prim]) -> list[Asked]:
        found = []
        for prim in prims:
            path = _path(prim)
            one = self._at.get(path)
            if one is None:
                one = self._at[path] = Asked(prim, self._spell(path))
            found.append(one)
        return found

    def _spell(self, path: Sdf.Path) -> str:
        """USD spells a path out name by name each time: here it is that of the prim above, and one
        name more."""
        above = self._spelt.get(path.GetParentPath())
        spelt = self._spelt[path] = f"{above}/{path.name}" if above else str(path)
        return spelt


_LIVE = State.LIVE
"""Python 3.11 takes longer to look up a member than USD to answer."""


def state_of(prim: Usd.Prim) -> State:
    if not _is_active(prim):
        return State.INACTIVE
    if _is_abstract(prim):
        return State.ABSTRACT
    if not _is_defined(prim):
        return State.OVER
    return _LIVE


def type_is_known(prim: Usd.Prim) -> bool:
    """An unregistered type looks like no type at all to `GetSchemaType()`, as does an untyped prim."""
    if not _type_name(prim):
        return True
    return bool(_type_info(prim).GetSchemaType() != Tf.Type.Unknown)

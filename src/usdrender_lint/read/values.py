"""What does a typed C++ read at the default time get for a schema attribute?"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from pxr import Sdf, Usd, Vt

from ..model import EXTRAS, Attr, Site, ValueState
from .prims import Asked, Declared, Opinion
from .specs import items

T = TypeVar("T")

_FALLBACK, _AUTHORED = ValueState.FALLBACK, ValueState.AUTHORED
"""Python 3.11 takes longer to look up a member than USD to answer."""

VARYING = ("timeSamples", "spline")
"""Fields of a property whose value depends on time."""

# Looked up on an object, USD checks the object first, which takes longer than these do.
_attribute = Usd.Prim.GetAttribute
_attribute_type = Usd.Attribute.GetTypeName
_get = Usd.Attribute.Get

_EDITS = frozenset(getattr(Vt, name) for name in dir(Vt) if name.endswith("ArrayEdit"))
"""What `edit [append "x"]` is: not an array, but what becomes of that of a weaker layer."""
_EDIT = "edit [...]"
_ARRAYS = frozenset(getattr(Vt, name) for name in dir(Vt) if name.endswith("Array"))


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
        return Attr(name, fallback, _FALLBACK, site)
    opinions = asked.opinions(name)
    said = [one for one in opinions if not one.is_relationship]
    if len(said) < len(opinions) and not _attribute(asked.prim, name):
        return Attr(name, fallback, ValueState.FALLBACK, site)
    varying = _varying(said)
    samples: tuple[tuple[float, T], ...] = ()
    if varying and with_samples:
        samples = _samples(_attribute(asked.prim, name), plain)
    declared = asked.schema.attribute(name)
    counts, default, unread = _counting(said, declared)
    # Only what is passed over makes another opinion than the strongest count.
    if counts is not None and counts is not next(one for one in said if one.has_default):
        site = Site(site.path, "default", None, *asked.where(counts, name))
    value, state = fallback, _FALLBACK
    if type(default) in _EDITS:
        default = _get(_attribute(asked.prim, name))
        if type(default) in _EDITS or default is None:  # before 26.05, which reads none
            counts, unread = None, unread or _EDIT
    if isinstance(default, Sdf.ValueBlock):
        value, state = empty, ValueState.BLOCKED
    elif counts is not None:
        value = plain(declared.checked(default, site.path) if declared else default)
        state = _AUTHORED if unread is None else ValueState.MISTYPED
    elif unread is not None:
        state = ValueState.MISTYPED
    elif varying is not None:
        state, site = ValueState.SAMPLED, Site(site.path, varying)
    authored_type = said[0].type_name if said else None
    return Attr(name, value, state, site, samples, authored_type, varying, unread or "")


def _counting(
    said: list[Opinion], declared: Declared | None
) -> tuple[Opinion | None, Any, str | None]:
    """The first opinion whose default is read, if any, and the default; and what the first one says
    that is passed over for its type."""
    unread = None
    for one in said:
        if not one.has_default:
            continue
        default = one.spec.default
        # An animation block ends the samples of weaker layers, and lets their defaults through.
        if isinstance(default, Sdf.AnimationBlock):
            continue
        if declared is None or isinstance(default, Sdf.ValueBlock) or declared.takes(one):
            return one, default, unread
        # Passed over, not refused: a weaker opinion of the right type is read (26.11).
        unread = unread or _as_text(default)
    return None, None, unread


def _varying(said: list[Opinion]) -> str | None:
    """How the value changes over time: a stronger layer's default ends the samples of weaker ones."""
    for one in said:
        for field in VARYING:
            if one.spec.HasInfo(field):
                return field
        if one.has_default:
            return None
    return None


def read_extras(asked: Asked) -> tuple[Attr[str], ...]:
    """What renderers and studios author beside the schema; at the first sample where there is no
    default, for it is never meant to vary."""
    found = []
    wanted = asked.authored if "RenderVar" in asked.kinds else EXTRAS
    for name in asked.authored:
        is_extra = name in wanted and name not in asked.schema.names
        attribute = _attribute(asked.prim, name) if is_extra else None
        if not attribute:
            continue
        value = _get(attribute)
        if value is None:
            value = _get(attribute, Usd.TimeCode.EarliestTime())
        type_name = _attribute_type(attribute)
        text = _as_text(value)
        state = _FALLBACK if value is None else _AUTHORED
        site = Site(f"{asked.path}.{name}", "default")
        found.append(Attr(name, text, state, site, (), str(type_name)))
    return tuple(found)


def _as_text(value: Any) -> str:
    """By its own type: that of the attribute may be another layer's."""
    if value is None:
        return ""
    if type(value) in _EDITS:
        return _EDIT
    if type(value) in _ARRAYS:
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

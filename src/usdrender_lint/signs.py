"""What does a stage show that rules can speak of?

Most rules are silent on most stages, because what they speak of is not there: no collection, no
attribute of that name, no target that leads astray. One look at the stage tells that for all of
them, and spares each one its own; see `Sign` and `Rule.about`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import fields
from functools import cache
from operator import attrgetter
from typing import Any

from .model import (
    EXPECTED,
    RENDER_TYPES,
    Attr,
    Camera,
    Collection,
    DefaultSettings,
    OtherPrim,
    Property,
    Rel,
    RenderPrim,
    RenderScope,
    State,
    ValueState,
)
from .rule import Sign

_LIVE, _OVER = State.LIVE, State.OVER
_FALLBACK, _BLOCKED, _SAMPLED = ValueState.FALLBACK, ValueState.BLOCKED, ValueState.SAMPLED
"""Python 3.11 takes longer to look up a member than the rest of a comparison."""
_COLLECTION = "collection:"
_TYPES = frozenset({*RENDER_TYPES, "Camera"})


def signs_of(scope: RenderScope) -> set[str]:
    """All signs of a stage, and the names of the attributes and relationships that say something.

    That an attribute says nothing is no sign only where its fallback is that of USD: a type that
    derives from USD's may have others.
    """
    found: set[str] = {sign for sign, there in _beside_prims(scope) if there}
    for prim in scope.prims():
        if prim.state is _OVER:
            found.add(Sign.OVER)
        if prim.other_types:
            found.add(Sign.OTHER_TYPE)
        _add_attributes(prim, prim.type_name in _TYPES, found)
        _add_targets(prim.rels, found)
        _add_properties(prim.properties, found)
    if not all(var.data_type_known for var in scope.vars):
        found.add(Sign.UNKNOWN_DATA_TYPE)
    if any(product.product_name.samples for product in scope.products):
        found.add(Sign.SAMPLED_NAME)
    for render_pass in scope.passes:
        is_usual = render_pass.type_name in _TYPES
        for collection in render_pass.collections:
            _add_attributes(collection, is_usual, found)
            if not is_usual or _is_used(collection):
                found.add(Sign.COLLECTION)
    for camera in scope.cameras:
        _add_attributes(camera, camera.type_name in _TYPES, found)
        if camera.properties:  # of a camera only what is odd is kept
            found.add(Sign.ODD_PROPERTY)
        if camera.instance is not None:
            found.add(Sign.INSTANCED_CAMERA)
    return found


def _beside_prims(scope: RenderScope) -> tuple[tuple[Sign, object], ...]:
    return (
        (Sign.RENDER_PASS, scope.passes),
        (Sign.OTHER_PRIM, any(not _is_group(other) for other in scope.others)),
        (Sign.STRAY, scope.strays),
        (Sign.ARC_ERROR, scope.errors),
        (Sign.MISSING_VARIANT, scope.missing_variants),
        (Sign.ODD_DEFAULT, _is_odd_default(scope.default)),
        (Sign.ODD_SCOPE, any(s.state is not _LIVE or s.type_name != "Scope" for s in scope.scopes)),
    )


def _is_group(prim: OtherPrim) -> bool:
    return prim.type_name in ("", "Scope") and not prim.properties and not prim.content


def _is_odd_default(default: DefaultSettings) -> bool:
    """It is anything but one live RenderSettings, named in the one right place."""
    target = default.target
    if default.problem is not None or default.sublayers or default.misspelled:
        return True
    return target is not None and (target.state is not _LIVE or "RenderSettings" not in target.isa)


@cache
def _attributes(kind: type) -> Callable[[object], tuple[Attr[Any], ...]]:
    """Gets all attributes of a prim, or collection, of that kind."""
    names = [one.name for one in fields(kind) if str(one.type).startswith(Attr.__name__)]
    return attrgetter(*names)


def _add_attributes(
    holder: RenderPrim | Camera | Collection, is_usual: bool, found: set[str]
) -> None:
    kind: type = type(holder)
    for attr in _attributes(kind)(holder):
        state = attr.state
        if is_usual and state is _FALLBACK:
            continue
        found.add(attr.name)
        if state is _BLOCKED:
            found.add(Sign.BLOCKED)
        # The name of a product is meant to vary.
        if (attr.varying is not None or state is _SAMPLED) and attr.name != "productName":
            found.add(Sign.VARYING)


def _add_targets(rels: Iterable[Rel], found: set[str]) -> None:
    for rel in rels:
        wanted = EXPECTED[rel.name]
        if rel.targets:
            found.add(rel.name)
        if rel.lost or rel.clobbered:
            found.add(Sign.ODD_TARGET)
        for target in rel.targets:
            is_there = target.state is _LIVE and wanted in target.isa
            if not is_there or target.is_property or target.via:
                found.add(Sign.ODD_TARGET)


def _add_properties(properties: Iterable[Property], found: set[str]) -> None:
    for one in properties:
        if one.name.startswith(_COLLECTION):
            found.add(Sign.COLLECTION_PROPERTY)
        if one.is_schema:
            is_odd = one.is_relationship is not one.schema_is_relationship
        else:
            is_odd = bool(one.belongs_to) or ":" not in one.name
        # Other refused tokens are found in their attributes.
        if is_odd or not one.type_fits or (one.refused and ":" in one.name):
            found.add(Sign.ODD_PROPERTY)


def _is_used(collection: Collection) -> bool:
    """Somebody writes something of it, in whatever way."""
    attributes = _attributes(Collection)(collection)
    return (
        any(attr.state is not _FALLBACK for attr in attributes)
        or collection.includes.named
        or collection.excludes.named
        or collection.problem is not None
        or bool(collection.members or collection.patterns or collection.others or collection.lost)
    )

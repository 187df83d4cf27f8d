"""Can USD evaluate the predicates of a path expression? It is asked about each one alone."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

from pxr import Sdf, Tf, Usd

from ..model import Predicate, PredicateState

KNOWN = (
    "abstract",
    "defined",
    "group",
    "hasAPI",
    "isa",
    "kind",
    "model",
    "specifier",
    "variant",
)
"""What USD's library has; for guesses only."""

_HYDRA = frozenset(
    {
        "hasDataSource",
        "hasMaterialBinding",
        "hasPrimvar",
        "hdHasDataSource",
        "hdHasMaterialBinding",
        "hdHasPrimvar",
        "hdPurpose",
        "hdType",
        "hdVisible",
        "purpose",
        "type",
        "visible",
    }
)
"""`HdGetCollectionPredicateLibrary()`: what a scene index asks, and USD's own queries do not know."""

_MODELS = frozenset({"group", "kind", "model"})
_GROUPS = frozenset({"Scope", "SkelRoot", "Xform"})


def read_predicates(condition: str) -> Iterator[Predicate]:
    """The calls in a predicate expression such as `isa:Mesh and not model`."""
    for call in _calls(condition):
        yield _read(call)


def means_groups(condition: str) -> bool:
    """It holds for prims that have others below them, and for hardly any geometry."""
    calls = _calls(condition)
    if len(calls) != 1:
        return False
    (call,) = calls
    if call.funcName == "isa":
        return bool(call.args) and all(a.value in _GROUPS for a in call.args)
    return call.funcName in _MODELS and not any(a.value is False for a in call.args)


def _calls(condition: str) -> list[Any]:
    found: list[Any] = []
    Sdf.PredicateExpression(condition).Walk(lambda op, index: None, found.append)
    return found


def _read(call: Any) -> Predicate:
    name = str(call.funcName)
    text = str(Sdf.PredicateExpression.MakeCall(call).GetText()).replace('"', "")
    if not _is_evaluated(str(Sdf.PredicateExpression.MakeCall(call).GetText())):
        if name in KNOWN:
            return Predicate(name, text, PredicateState.BAD_ARGUMENTS)
        if name in _HYDRA:
            return Predicate(name, text, PredicateState.HYDRA)
        return Predicate(name, text, PredicateState.UNKNOWN, _meant(name, call))
    if name in ("isa", "hasAPI"):
        wanted = [str(a.value) for a in call.args if not a.argName]
        meant = [_type_meant(name, w) for w in wanted]
        if wanted and all(meant):
            return Predicate(name, text, PredicateState.NO_SUCH_TYPE, meant[0])
    return Predicate(name, text, PredicateState.KNOWN)


@cache
def _is_evaluated(condition: str) -> bool:
    layer = Sdf.Layer.CreateAnonymous(".usda")
    prim = Sdf.CreatePrimInLayer(layer, "/asked")
    prim.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=["CollectionAPI:it"]))
    stage = Usd.Stage.Open(layer)
    collection = Usd.CollectionAPI(stage.GetPrimAtPath("/asked"), "it")
    expression = Sdf.PathExpression("//{" + condition + "}")
    collection.CreateMembershipExpressionAttr(expression)
    try:
        collection.ComputeMembershipQuery()
    except Tf.ErrorException:
        return False
    return True


def _meant(name: str, call: Any) -> str | None:
    """`isMesh` and `Mesh` for `isa:Mesh`, `iskind` for `kind`."""
    if not call.args:
        bare = name[2:] if name.lower().startswith("is") else name
        for kind in (bare, bare[:1].upper() + bare[1:]):
            if _schema_type(kind):
                return f"isa:{kind}"
    import difflib

    best = difflib.get_close_matches(name, KNOWN, 1, 0.7)
    return best[0] if best else None


def _type_meant(name: str, wanted: str) -> str | None:
    """The type that a misspelt one stands for; None for one that exists, or a plugin's own."""
    if _schema_type(wanted):
        return None
    registry = Usd.SchemaRegistry
    known = registry.GetTypeFromName(wanted)
    if known:  # UsdGeomMesh: the class in C++
        return f"{name}:{registry.GetSchemaTypeName(known)}"
    if name == "isa" and _schema_type(f"{wanted}API"):
        return f"hasAPI:{wanted}API"
    import difflib

    near = difflib.get_close_matches(wanted.lower(), _types_by_lower_case(), 1, 0.8)
    return f"{name}:{_types_by_lower_case()[near[0]]}" if near else None


def _schema_type(name: str) -> bool:
    return bool(Usd.SchemaRegistry.GetTypeFromSchemaTypeName(name))


@cache
def _types_by_lower_case() -> dict[str, str]:
    names = (
        str(Usd.SchemaRegistry.GetSchemaTypeName(t))
        for t in Tf.Type.FindByName("UsdSchemaBase").GetAllDerivedTypes()
    )
    return {name.lower(): name for name in names if name}

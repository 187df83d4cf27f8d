"""Which composition arcs failed, where are they authored, and what may hide behind them?"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from pxr import Pcp, Sdf, Usd

from ..discover import USD_SUFFIXES
from ..model import ArcError, Site
from ..records import dataclass
from ..stage import Opened, ParseProblem, Unreadable, open_layer, open_member

_ARC_FIELDS = (("reference", "referenceList", "references"), ("payload", "payloadList", "payload"))

_SAID = {
    "ErrorArcCycle": "cycle",
    "ErrorSublayerCycle": "sublayer-cycle",
}
_FOUND_ON_SPECS = {
    "ErrorInvalidAssetPath",
    "ErrorMutedAssetPath",
    "ErrorUnresolvedPrimPath",
    "ErrorInvalidSublayerPath",
    "ErrorAssetPathError",
}


@dataclass(frozen=True, slots=True)
class Failure:
    """One arc that brings nothing."""

    prim: str
    """The composed prim that misses something; "/" for a sublayer of the root layer stack."""
    kind: str
    arc: str
    asset: str
    missing_prim: str
    site: Site


class Failures:
    """All arcs of a stage that failed. Python's errors carry a type and a root site only; the arc
    that asks for the asset is found on the specs."""

    def __init__(self, opened: Opened) -> None:
        self._opened = opened
        self._found: list[Failure] = []
        self._opened_files: dict[str, Sdf.Layer | None] = {}
        errors = opened.stage.GetCompositionErrors()
        if not errors:
            return
        prims = sorted({str(e.rootSite.path) for e in errors})
        for path in prims:
            self._found.extend(self._below_arcs(path))
        if any(type(e).__name__ == "ErrorInvalidSublayerPath" for e in errors):
            self._found.extend(self._sublayers())
        for error in errors:
            name = type(error).__name__
            if name not in _FOUND_ON_SPECS:
                path = str(error.rootSite.path)
                self._found.append(Failure(path, _SAID.get(name, name), "", "", "", Site(path)))

    def hiding(self, path: str) -> str | None:
        """What the prim at `path` may be behind, as authored: an asset, or the prim of an internal arc."""
        for failure in self._found:
            above = failure.prim
            if failure.arc and (
                above == "/" or path == above or path.startswith((above + "/", above + "."))
            ):
                return failure.asset or f"<{failure.missing_prim}>"
        return None

    def errors(self, essential: Iterable[str]) -> tuple[ArcError, ...]:
        """One error a cause. `essential`: prims whose loss a render feels."""
        needed = tuple(essential)
        grouped: dict[tuple[str, ...], list[Failure]] = {}
        for failure in self._found:
            # An asset that did not open is told as a finding of that layer, or as unreadable.
            if failure.kind != "unopened-asset":
                where = "" if failure.asset else failure.prim
                cause = (failure.kind, failure.arc, failure.asset, failure.missing_prim, where)
                grouped.setdefault(cause, []).append(failure)
        return tuple(self._error(group, needed) for group in grouped.values())

    def _error(self, group: list[Failure], needed: tuple[str, ...]) -> ArcError:
        first = min(group, key=lambda f: (f.site.layer or "", f.prim))
        prims = sorted({f.prim for f in group})
        touches = any(p == "/" or n == p or n.startswith(p + "/") for p in prims for n in needed)
        return ArcError(
            first.kind,
            first.arc,
            first.asset,
            first.missing_prim,
            first.site,
            len(group),
            tuple(prims[:5]),
            touches,
        )

    def _below_arcs(self, path: str) -> Iterator[Failure]:
        prim = self._opened.stage.GetPrimAtPath(path)
        if not prim or prim.IsPseudoRoot():
            return
        for arc, list_name, field in _ARC_FIELDS:
            deleted: set[tuple[str, str]] = set()
            replaced: set[Sdf.Path] = set()
            for spec in prim.GetPrimStack():
                # List edits act within one layer stack, where a spec's path is the same.
                if spec.path in replaced:
                    continue
                operation = getattr(spec, list_name)
                for item in operation.GetAddedOrExplicitItems():
                    if (str(item.assetPath), str(item.primPath)) not in deleted:
                        yield from self._check(prim, spec, arc, field, item)
                deleted.update((str(i.assetPath), str(i.primPath)) for i in operation.deletedItems)
                if operation.isExplicit:
                    replaced.add(spec.path)

    def _check(
        self, prim: Usd.Prim, spec: Sdf.PrimSpec, arc: str, field: str, item: Sdf.Reference
    ) -> Iterator[Failure]:
        asset, wanted = str(item.assetPath), item.primPath
        written = asset
        if asset.startswith("`"):
            asset = self._evaluated(asset)
        site = Site(
            str(prim.GetPath()),
            field,
            written or str(wanted),
            spec.layer.identifier,
            str(spec.path),
        )
        if written and not asset:
            return  # an expression that gives nothing, on purpose
        if asset:
            kind, layer = self._open(spec.layer, asset)
            if layer is None:
                yield Failure(str(prim.GetPath()), kind, arc, written, "", site)
                return
            wanted = wanted or _default_prim(layer)
            layers = [layer]
        else:
            layers = _layer_stack_of(prim, spec)
        if not wanted:
            yield Failure(str(prim.GetPath()), "no-default-prim", arc, asset, "", site)
        elif not any(one.GetPrimAtPath(wanted) for one in _with_sublayers(layers)):
            yield Failure(str(prim.GetPath()), "missing-prim", arc, asset, str(wanted), site)

    def _evaluated(self, expression: str) -> str:
        """What a variable expression comes to, by the variables of the root layer."""
        variables = self._opened.stage.GetRootLayer().expressionVariables
        result = Sdf.VariableExpression(expression).Evaluate(dict(variables))
        return result.value if isinstance(result.value, str) else ""

    def _sublayers(self) -> Iterator[Failure]:
        own = set(self._opened.stage.GetLayerStack(includeSessionLayers=True))
        for layer in self._opened.stage.GetUsedLayers():
            for written in layer.subLayerPaths:
                asset = self._evaluated(written) if written.startswith("`") else written
                kind, sublayer = self._open(layer, asset) if asset else ("", layer)
                if sublayer is None:
                    site = Site("/", "subLayers", written, layer.identifier)
                    for prim in ["/"] if layer in own else self._using(layer):
                        yield Failure(prim, kind, "sublayer", written, "", site)

    def _using(self, layer: Sdf.Layer) -> Iterator[str]:
        """The topmost prims that an arc fills from the layer stack of `layer`: USD names none."""
        found: list[Sdf.Path] = []
        for prim in self._opened.stage.TraverseAll():
            path = prim.GetPath()
            if any(path.HasPrefix(above) for above in found):
                continue
            if any(layer in node.layerStack.layers for node in _nodes(prim)):
                found.append(path)
                yield str(path)

    def _open(self, layer: Sdf.Layer, asset: str) -> tuple[str, Sdf.Layer | None]:
        identifier = layer.ComputeAbsolutePath(asset)
        if identifier in self._opened_files:
            known = self._opened_files[identifier]
            return "" if known else "unopened-asset", known
        resolved = self._opened.stage.ResolveIdentifierToEditTarget(identifier)
        if not resolved:
            return "missing-asset", None
        member = resolved.endswith("]")
        if not member and not resolved.lower().endswith(USD_SUFFIXES):
            # A plug-in's format, such as Alembic: what it holds is not known without the plug-in.
            return "foreign-format", None
        found: Sdf.Layer | None = None
        match open_member(resolved) if member else open_layer(resolved):
            case Unreadable() as unreadable:
                self._opened.unreadable.append(
                    Unreadable(
                        unreadable.file, unreadable.kind, unreadable.message, layer.identifier
                    )
                )
            case ParseProblem() as problem:
                self._opened.unparsed.append(problem)
            case opened:
                found = opened
        self._opened_files[identifier] = found
        return "" if found else "unopened-asset", found


def _default_prim(layer: Sdf.Layer) -> Sdf.Path | None:
    name = layer.defaultPrim
    if not name:
        return None
    return Sdf.Path(name if name.startswith("/") else "/" + name)


def _nodes(prim: Usd.Prim) -> Iterator[Pcp.NodeRef]:
    pending = [prim.GetPrimIndex().rootNode]
    while pending:
        node: Pcp.NodeRef = pending.pop()
        yield node
        pending.extend(node.children)


def _layer_stack_of(prim: Usd.Prim, spec: Sdf.PrimSpec) -> list[Sdf.Layer]:
    stacks = (node.layerStack.layers for node in _nodes(prim))
    return next((list(s) for s in stacks if spec.layer in s), [spec.layer])


def _with_sublayers(layers: list[Sdf.Layer]) -> Iterator[Sdf.Layer]:
    seen: set[str] = set()
    pending = list(layers)
    while pending:
        layer = pending.pop()
        if layer.identifier in seen:
            continue
        seen.add(layer.identifier)
        yield layer
        for asset in layer.subLayerPaths:
            if found := Sdf.Layer.Find(layer.ComputeAbsolutePath(asset)):
                pending.append(found)

"""Which composition arcs failed, where are they authored, and what may hide behind them?"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import cached_property

from pxr import Pcp, Sdf, Tf, Usd

from ..discover import USD_SUFFIXES
from ..lazily import lazily
from ..model import ArcError, Site
from ..opening import ARGUMENTS, open_layer, open_member
from ..packages import split_package
from ..records import dataclass
from ..stage import Opened
from ..unopened import ParseProblem, Unreadable
from .cycles import cycle_of_arcs, cycle_of_sublayers, spelt

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
_EXPRESSION = "ErrorVariableExpressionError"
_SPEC = lazily(r" at (/\S*) in @(.*?)@: ")
_RELOCATION = lazily(r"[Rr]elocation from <(.*?)>.*? authored at @(.*?)@<(.*?)>")
_BY_NOW = "USD refused it when it composed the stage, and opens it now: it was being written, or it is damaged"
_OF_SUBLAYERS = {"ErrorInvalidSublayerPath", _EXPRESSION}


_SCHEME = lazily(r"[A-Za-z][\w+.-]+:")
"""Of a URI, which a resolver of the studio or the host application reads; not a drive's letter."""


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
    evaluated: _Evaluated | None = None
    """Where the asset is an expression."""
    further: tuple[Site, ...] = ()


@dataclass(frozen=True, slots=True)
class _Evaluated:
    """What a variable expression comes to."""

    value: str
    """Empty where it gives nothing, or cannot be evaluated."""
    problem: str
    variables: tuple[Site, ...]
    """The opinions of those that it uses."""
    unset: tuple[str, ...]


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
        prims = {str(e.rootSite.path) for e in errors}.union(*map(self._of_expression, errors))
        for path in sorted(prims - {""}):
            self._found.extend(self._below_arcs(path))
        if any(type(e).__name__ in _OF_SUBLAYERS for e in errors):
            self._found.extend(self._sublayers())
        placed = any(failure.kind == "bad-expression" for failure in self._found)
        for error in errors:
            name = type(error).__name__
            if name not in _FOUND_ON_SPECS and not (name == _EXPRESSION and placed):
                path = str(error.rootSite.path) or "/"
                if relocation := _relocation(error):
                    self._found.append(relocation)
                    continue
                kind = _SAID.get(name, name)
                *further, site = self._cycle(kind, path) or (Site(path),)
                self._found.append(Failure(path, kind, "", "", "", site, None, tuple(further)))

    def _cycle(self, kind: str, path: str) -> tuple[Site, ...]:
        root = self._opened.stage.GetRootLayer()
        if kind == "cycle":
            return cycle_of_arcs(root, path, self._layer_at)
        return cycle_of_sublayers(root, self._layer_at) if kind == "sublayer-cycle" else ()

    def _of_expression(self, error: Pcp.ErrorBase) -> set[str]:
        """Prims whose arc is an expression that failed: there the error tells no prim of the stage,
        and in words the spec."""
        match = _SPEC.search(str(error)) if type(error).__name__ == _EXPRESSION else None
        if not match:
            return set()
        path, file = Sdf.Path(match[1]), match[2]
        stacks = ((p, p.GetPrimStack()) for p in self._opened.stage.TraverseAll())
        return {
            str(prim.GetPath())
            for prim, stack in stacks
            if any(s.path == path and file in (s.layer.identifier, s.layer.realPath) for s in stack)
        }

    def _layer_at(self, layer: Sdf.Layer, asset: str) -> Sdf.Layer | None:
        """What an asset path leads to, if USD has it open."""
        asset = self._evaluated(layer, asset).value if asset.startswith("`") else asset
        return Sdf.Layer.Find(layer.ComputeAbsolutePath(asset)) if asset else None

    def hiding(self, path: str) -> str | None:
        """What the prim at `path` may be behind, as authored: an asset, or the prim of an internal arc."""
        if not self._hidden_by:
            return None
        above = path.partition(".")[0]
        found = [self._hidden_by["/"]] if "/" in self._hidden_by else []
        while above:
            if above in self._hidden_by:
                found.append(self._hidden_by[above])
            above = above.rpartition("/")[0]
        if not found:
            return None
        failure = self._found[min(found)]
        return failure.asset or f"<{failure.missing_prim}>"

    def only_a_layer_hides(self, path: str) -> bool:
        """A missing sublayer may bring anything; an arc, what stands below its prim."""
        above = _prefixes(path.partition(".")[0])
        return "/" in self._hidden_by and self._hidden_by.keys().isdisjoint({*above} - {"/"})

    @cached_property
    def _hidden_by(self) -> dict[str, int]:
        """The first failure that has to do with an arc, by the prim that misses something."""
        first: dict[str, int] = {}
        for index, failure in enumerate(self._found):
            if failure.arc:
                first.setdefault(failure.prim, index)
        return first

    def errors(self, essential: Iterable[str]) -> tuple[ArcError, ...]:
        """One error a cause. `essential`: prims whose loss a render feels."""
        if not self._found:
            return ()
        # What an essential prim stands below is essential, too.
        needed = {above for path in essential for above in _prefixes(path)}
        grouped: dict[tuple[str, ...], list[Failure]] = {}
        for failure in self._found:
            # An asset that did not open is told as a finding of that layer, or as unreadable.
            if failure.kind != "unopened-asset":
                where = "" if failure.asset or failure.further else failure.prim
                edges = sorted(
                    map(str, (*failure.further, failure.site) if failure.further else ())
                )
                named = failure.asset, failure.missing_prim
                cause = (failure.kind, failure.arc, *named, where, *edges)
                grouped.setdefault(cause, []).append(failure)
        return tuple(self._error(group, needed) for group in grouped.values())

    def _error(self, group: list[Failure], needed: set[str]) -> ArcError:
        first = min(group, key=lambda f: (self._depth(f.site), f.site.layer or "", f.prim))
        asking = [f.site for f in group if f.site.layer and f.site != first.site]
        prims = sorted({f.prim for f in group})
        touches = prims[0] == "/" or not needed.isdisjoint(prims)
        return ArcError(
            first.kind,
            first.arc,
            first.asset,
            first.missing_prim,
            first.site,
            len(group),
            tuple(prims[:5]),
            first.further or tuple(dict.fromkeys(asking)),
            first.evaluated.variables if first.evaluated else (),
            (first.evaluated.problem or first.evaluated.value) if first.evaluated else "",
            first.evaluated.unset if first.evaluated else (),
            touches,
        )

    def _depth(self, site: Site) -> int:
        """How far down the root layer stack it stands; what is beyond comes last."""
        layers = [one.identifier for one in self._own]
        return layers.index(site.layer) if site.layer in layers else len(layers)

    @cached_property
    def _used(self) -> set[Sdf.Layer]:
        return {*self._opened.stage.GetUsedLayers()}

    @cached_property
    def _own(self) -> list[Sdf.Layer]:
        return list(self._opened.stage.GetLayerStack(includeSessionLayers=True))

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
        yield from self._selections(prim)

    def _selections(self, prim: Usd.Prim) -> Iterator[Failure]:
        """Of variants, by expressions that cannot be evaluated. USD tries only those for sets that
        are there."""
        path, sets = str(prim.GetPath()), prim.GetVariantSets()
        for spec in prim.GetPrimStack():
            written = spec.variantSelections if spec.HasInfo("variantSelection") else {}
            for name, selection in written.items():
                if selection[:1] != "`" or not sets.HasVariantSet(name):
                    continue
                evaluated = self._evaluated(spec.layer, selection)
                if evaluated and evaluated.problem:
                    field, file = f"variantSelection:{name}", spec.layer.identifier
                    site = Site(path, field, None, file, str(spec.path))
                    yield Failure(
                        path, "bad-expression", "variant selection", selection, "", site, evaluated
                    )

    def _check(
        self, prim: Usd.Prim, spec: Sdf.PrimSpec, arc: str, field: str, item: Sdf.Reference
    ) -> Iterator[Failure]:
        asset, wanted = str(item.assetPath), item.primPath
        written, path, evaluated = asset, str(prim.GetPath()), None
        site = Site(path, field, spelt(asset, wanted), spec.layer.identifier, str(spec.path))
        if asset.startswith("`"):
            evaluated = self._evaluated(spec.layer, asset)
            asset = evaluated.value
            if evaluated.problem:
                yield Failure(path, "bad-expression", arc, written, "", site, evaluated)
        if written and not asset:
            return  # an expression that gives nothing, on purpose
        if asset:
            kind, layer = self._open(spec.layer, asset, site)
            if layer is None:
                yield Failure(path, kind, arc, written, "", site, evaluated)
                return
            wanted = wanted or _default_prim(layer)
            layers = [layer]
        else:
            layers = _layer_stack_of(prim, spec)
        if not wanted:
            yield Failure(str(prim.GetPath()), "no-default-prim", arc, asset, "", site)
        elif not any(one.GetPrimAtPath(wanted) for one in _with_sublayers(layers)):
            yield Failure(str(prim.GetPath()), "missing-prim", arc, asset, str(wanted), site)

    def _evaluated(self, layer: Sdf.Layer, expression: str) -> _Evaluated:
        """What a variable expression of a layer comes to. The root layer has the last word."""
        root = self._opened.stage.GetRootLayer()
        holders = {name: one for one in (layer, root) for name in one.expressionVariables}
        variables = {name: one.expressionVariables[name] for name, one in holders.items()}
        result = Sdf.VariableExpression(expression).Evaluate(variables)
        used = sorted(map(str, result.usedVariables))
        sites = tuple(
            Site("/", f"expressionVariables:{name}", layer=holders[name].identifier)
            for name in used
            if name in holders
        )
        value = result.value if isinstance(result.value, str) else ""
        unset = tuple(name for name in used if name not in holders)
        problem = "; ".join(map(str, result.errors))
        if not (value or problem or result.value in ("", None)):
            problem = "it comes to something else than a string"
        return _Evaluated(value, problem, sites, unset)

    def _sublayers(self) -> Iterator[Failure]:
        for layer in sorted(self._used, key=lambda layer: layer.identifier):
            for written in layer.subLayerPaths:
                yield from self._check_sublayer(layer, written)

    def _check_sublayer(self, layer: Sdf.Layer, written: str) -> Iterator[Failure]:
        asset, evaluated = written, None
        if written.startswith("`"):
            evaluated = self._evaluated(layer, written)
            asset = evaluated.value
        site = Site("/", "subLayers", written, layer.identifier)
        if evaluated and evaluated.problem:
            kind = "bad-expression"
        elif asset:
            kind, found = self._open(layer, asset, site)
            if found is not None:
                if found not in self._used:
                    self._opened.unreadable.append(
                        Unreadable(found.realPath, "unreadable-file", _BY_NOW, layer.identifier)
                    )
                return
        else:
            return  # an expression that gives nothing, on purpose
        for prim in ["/"] if layer in self._own else self._using(layer):
            yield Failure(prim, kind, "sublayer", written, "", site, evaluated)

    def _using(self, layer: Sdf.Layer) -> Iterator[str]:
        """The topmost prims that an arc fills from the layer stack of `layer`: USD names none."""
        below = iter(self._opened.stage.TraverseAll())
        for prim in below:
            if any(layer in node.layerStack.layers for node in _nodes(prim)):
                below.PruneChildren()
                yield str(prim.GetPath())

    def _open(self, layer: Sdf.Layer, asset: str, asked: Site) -> tuple[str, Sdf.Layer | None]:
        identifier = layer.ComputeAbsolutePath(asset)
        if identifier in self._opened_files:
            known = self._opened_files[identifier]
            return "" if known else "unopened-asset", known
        plain, _, arguments = identifier.partition(ARGUMENTS)
        resolved = self._opened.stage.ResolveIdentifierToEditTarget(plain)
        # With arguments USD takes every name for that of a file. pathlib raises for long names.
        if arguments and not os.path.exists(split_package(resolved)[0]):  # noqa: PTH110 see above
            resolved = ""
        if not resolved:
            foreign = _SCHEME.match(asset.partition(ARGUMENTS)[0])
            return "foreign-resolver" if foreign else "missing-asset", None
        if os.path.isdir(resolved):  # noqa: PTH112 likewise
            return "folder", None
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
                self._opened.unparsed.append(replace(problem, asked=asked))
            case opened:
                found = _with_arguments(identifier) if arguments else opened
                if found is None:
                    told = "USD cannot open it with the arguments behind its name"
                    self._opened.unreadable.append(
                        Unreadable(resolved, "unreadable-file", told, layer.identifier)
                    )
        if found is not None:
            self._opened.reopened.add(found.realPath)
        self._opened_files[identifier] = found
        return "" if found else "unopened-asset", found


def _with_arguments(identifier: str) -> Sdf.Layer | None:
    try:
        return Sdf.Layer.FindOrOpen(identifier)
    except Tf.ErrorException:
        return None


def _relocation(error: Pcp.ErrorBase) -> Failure | None:
    """One that USD passes over. Python's error tells neither what it was nor where."""
    said = str(error)
    match = _RELOCATION.search(said)
    if match is None:
        return None
    source, file, path = match.groups()
    found, layer = said.rpartition(": ")[2].rstrip("."), Sdf.Layer.Find(file)
    why = "other prims are relocated to the same path" if "multiple" in said else found
    site = Site(path, "relocates", layer=layer.identifier if layer else file)
    return Failure(path, "relocation", "", "", source, site, _Evaluated("", why, (), ()))


def _prefixes(path: str) -> Iterator[str]:
    while path:
        yield path
        path = path.rpartition("/")[0]


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

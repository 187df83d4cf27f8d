"""How is a stage opened, as little of it as the rules ask about?"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import field
from itertools import count

from pxr import Sdf, Tf, Usd

from .model import EXPECTED, RENDER_TYPES
from .records import dataclass
from .unopened import ParseProblem, Unreadable

PROBE = "__probe__"
"""No prim has this name: masking `/World/set/__probe__` populates `/World/set` and its
ancestors, and none of its children."""

Lead = tuple[Sdf.Path, str, list[Sdf.Path] | None]
"""A render prim, one of its relationships, and what this leads to, not forwarded; None where some
layer authors it as an attribute."""

ROUNDS = 8
"""Of widening, prim by prim, before the layers are asked what a chain leads to in the end."""

# Looked up on an object, USD checks the object first, which takes longer than these do.
_path = Usd.Prim.GetPath
_type_name = Usd.Prim.GetTypeName
_is_a = Usd.Prim.IsA
_children = Usd.Prim.GetFilteredChildren
_names = Usd.Prim.GetAuthoredPropertyNames
_relationship = Usd.Prim.GetRelationship
_targets = Usd.Relationship.GetTargets


@dataclass(slots=True)
class Opened:
    """A stage and what was learned while opening it. Everything in it dies with it."""

    stage: Usd.Stage
    scopes: tuple[str, ...]
    whole: bool = False
    """Nothing is left out."""
    unreadable: list[Unreadable] = field(default_factory=list)
    reopened: set[str] = field(default_factory=set)
    """Files of layers that arcs and sublayers lead to and that were found to open. A damaged one may
    have been refused when the stage was composed."""
    unparsed: list[ParseProblem] = field(default_factory=list)
    render_prims: list[Usd.Prim] | None = None
    """See the functions of these names. None: not yet asked for, of what is populated by now."""
    other_types: frozenset[str] = frozenset()
    """Of all that is no render prim, by the names that are written, known ones or not."""
    in_scopes: list[Usd.Prim] | None = None
    leads: dict[Sdf.Path, list[Lead]] = field(default_factory=dict)
    """Those of each prim. What is populated later changes none of them."""


def open_stage(
    layer: Sdf.Layer,
    scopes: tuple[str, ...],
    session: Sdf.Layer | None = None,
    *,
    whole: bool = False,
) -> Opened:
    """The stage of `layer`, with the scopes, all their relationships lead to, and little else; or
    all of it.

    Errors while opening become `Tf.ErrorException`, as everywhere in USD's Python.
    """
    session = session or Sdf.Layer.CreateAnonymous("session")
    if whole:
        return Opened(Usd.Stage.Open(layer, session), scopes, whole=True)
    mask = Usd.StagePopulationMask()
    for scope in scopes:
        mask.Add(Sdf.Path(scope))
    return Opened(Usd.Stage.OpenMasked(layer, session, mask), scopes)


def widen(opened: Opened, wanted: Iterable[str | Sdf.Path]) -> bool:
    """Populate these prims too, each with its ancestors but without what lies below it.

    True if the mask grew.
    """
    stage = opened.stage
    mask = stage.GetPopulationMask()
    probes = []
    for one in wanted:
        path = Sdf.Path(one).GetPrimPath().StripAllVariantSelections()
        # A mask that is given a property path raises and keeps the path (26.11).
        if not path.IsAbsoluteRootOrPrimPath() or stage.GetPrimAtPath(path):
            continue
        probe = path.AppendChild(PROBE)
        if not mask.Includes(probe):
            probes.append(probe)
    if probes:
        # Adding them one by one takes quadratic time.
        opened.render_prims = opened.in_scopes = None
        stage.SetPopulationMask(mask.GetUnion(Usd.StagePopulationMask(probes)))
    return bool(probes)


def widen_to_targets(opened: Opened, first: Iterable[str]) -> None:
    """Populate `first`, and what the render prims on the stage lead to, until nothing new turns up."""
    widen(opened, first)
    search = _Search(opened)
    for round_ in count():
        if not widen(opened, search.wanted(ahead=round_ >= ROUNDS)):
            return


class _Search:
    """Follows relationships from prim to prim, as far as prims are populated."""

    def __init__(self, opened: Opened) -> None:
        self._opened = opened
        self._begun: set[tuple[Sdf.Path, str]] = set()
        self._followed: set[Sdf.Path] = set()
        self._beyond: list[Sdf.Path] = []
        """Where prims have to be populated before it goes on."""

    def wanted(self, *, ahead: bool) -> set[Sdf.Path]:
        """What has to be populated next. `ahead`: also what the layers alone promise will follow,
        for a long chain of prims is not populated one by one."""
        pending, self._beyond = self._beyond, []
        for owner, name, targets in leads(self._opened):
            if (owner, name) not in self._begun:
                self._begun.add((owner, name))
                pending += targets or ()
        wanted: set[Sdf.Path] = set()
        stage = self._opened.stage
        while pending:
            path = pending.pop()
            if path in self._followed:
                continue
            populated = stage.GetPrimAtPath(path.GetPrimPath())
            if not populated:
                wanted.add(path)
            if not path.IsPropertyPath():
                continue
            if populated:
                self._followed.add(path)
                relationship = relationship_at(stage, path)
                pending += targets_of(relationship) if relationship else []
            else:
                self._beyond.append(path)
                if ahead:
                    wanted.update(promised(stage, path))
        return wanted


def promised(stage: Usd.Stage, first: Sdf.Path, suffix: str = "") -> set[Sdf.Path]:
    """What the relationships of the root layer stack lead to, as they are written. `suffix`: what
    makes a target the name of the next relationship."""
    layers = stage.GetLayerStack(includeSessionLayers=False)
    found, pending = set[Sdf.Path](), [first]
    while pending:
        path = pending.pop()
        if path not in found:
            found.add(path)
            if not path.IsPropertyPath():
                continue
            further = path.ReplaceName(path.name + suffix) if suffix else path
            for layer in layers:
                if spec := layer.GetRelationshipAtPath(further):
                    pending += spec.targetPathList.GetAddedOrExplicitItems()
    return found


def render_prims(opened: Opened) -> list[Usd.Prim]:
    """Every prim of a render type that is populated, in the scopes or elsewhere, whatever its state."""
    if opened.render_prims is None:
        found, known = list[Usd.Prim](), dict[str, bool]()
        for prim in everything(opened.stage):
            # There may be a million prims of a few types: only the first of each is asked what it is.
            name = _type_name(prim)
            if name not in known:
                known[name] = is_render_prim(prim)
            if known[name]:
                found.append(prim)
        others = (name for name, is_rendered in known.items() if not is_rendered)
        opened.render_prims, opened.other_types = found, frozenset(others)
    return opened.render_prims


def everything(stage: Usd.Stage) -> Iterator[Usd.Prim]:
    """All prims that are populated, whatever their state."""
    found = all_below(stage.GetPseudoRoot())
    next(found)  # the root itself
    return found


def in_scopes(opened: Opened) -> list[Usd.Prim]:
    """The scopes and every prim below them, whatever its state."""
    if opened.in_scopes is None:
        tops = (opened.stage.GetPrimAtPath(scope) for scope in opened.scopes)
        opened.in_scopes = [p for top in tops if top for p in all_below(top)]
    return opened.in_scopes


def all_below(prim: Usd.Prim) -> Iterator[Usd.Prim]:
    """`prim` and all populated prims below it, also inactive, undefined, abstract, in instances."""
    pending = [prim]
    while pending:
        one = pending.pop()
        yield one
        if below := _children(one, _EVERY):
            below.reverse()
            pending += below


_EVERY = Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)


def is_render_prim(prim: Usd.Prim) -> bool:
    return is_render_type(kinds_of(prim))


def is_render_type(kinds: frozenset[str]) -> bool:
    return not _RENDERED.isdisjoint(kinds)


def kinds_of(prim: Usd.Prim) -> frozenset[str]:
    """Which of the render types and `Camera` the prim is or derives from."""
    name = _type_name(prim)
    found = _kinds.get(name)
    if found is None:
        # By name: importing the UsdRender module only for IsA costs more than the answer.
        found = frozenset(t for t in (*RENDER_TYPES, "Camera") if _is_a(prim, t)) if name else _NONE
        if name and not Usd.SchemaRegistry.GetTypeFromSchemaTypeName(name):
            return found  # what stands for a type that is not installed, a stage says for itself
        _kinds[name] = found
    return found


_NONE: frozenset[str] = frozenset()
_RENDERED = frozenset(RENDER_TYPES)
_kinds: dict[str, frozenset[str]] = {}
"""Of prims by the name of their type."""


def leads(opened: Opened) -> Iterator[Lead]:
    """Of all render prims that are populated by now."""
    for prim in render_prims(opened):
        path = _path(prim)
        if path not in opened.leads:
            opened.leads[path] = [*_leads_of(prim, path)]
        yield from opened.leads[path]


def _leads_of(prim: Usd.Prim, path: Sdf.Path) -> Iterator[Lead]:
    names = _names(prim)
    for name in EXPECTED:
        if name in names and (relationship := _relationship(prim, name)):
            yield path, name, listed_by(relationship)


def relationship_at(stage: Usd.Stage, path: Sdf.Path) -> Usd.Relationship | None:
    """What a target forwards to."""
    found = stage.GetRelationshipAtPath(path) if path.IsPropertyPath() else None
    return found or None


def targets_of(relationship: Usd.Relationship) -> list[Sdf.Path]:
    """Not forwarded. None of a relationship that some layer authors as an attribute."""
    return listed_by(relationship) or []


def listed_by(relationship: Usd.Relationship) -> list[Sdf.Path] | None:
    """Not forwarded; None where some layer authors it as an attribute: USD raises."""
    try:
        found: list[Sdf.Path] = _targets(relationship)
    except Tf.ErrorException:
        return None
    return found

"""Which variant sets reach the render spec, and how is another variant selected?"""

from __future__ import annotations

from collections.abc import Iterator

from pxr import Sdf

from ..model import RenderScope
from ..records import dataclass
from ..stage import Opened, all_below


@dataclass(frozen=True, slots=True)
class VariantSet:
    prim: str
    name: str
    choices: tuple[str, ...]
    selected: str
    """As composed; empty for none."""

    @property
    def key(self) -> str:
        return f"{self.prim}{{{self.name}}}"

    @property
    def others(self) -> tuple[str, ...]:
        """The variants that the stage itself does not show."""
        return tuple(c for c in self.choices if c != self.selected)

    def spelt(self, choice: str) -> str:
        return f"<{self.prim}{{{self.name}={choice}}}>"


def variant_sets(opened: Opened, scope: RenderScope) -> tuple[VariantSet, ...]:
    """Those on render prims, on their ancestors and on what they target, by path."""
    found = {}
    for path in sorted(_reached(opened, scope)):
        prim = opened.stage.GetPrimAtPath(path)
        if not prim or prim.IsInstanceProxy():
            continue
        sets = prim.GetVariantSets()
        for name in sorted(sets.GetNames()):
            one = sets.GetVariantSet(name)
            choices = tuple(sorted(one.GetVariantNames()))
            found[path, name] = VariantSet(str(path), name, choices, one.GetVariantSelection())
    return tuple(found.values())


def _reached(opened: Opened, scope: RenderScope) -> set[Sdf.Path]:
    paths: set[Sdf.Path] = set()
    for path in _ends(opened, scope):
        paths.update(path.GetPrefixes())
    return paths


def _ends(opened: Opened, scope: RenderScope) -> Iterator[Sdf.Path]:
    for root in opened.scopes:
        if prim := opened.stage.GetPrimAtPath(root):
            yield from (p.GetPath() for p in all_below(prim))
    for one in scope.prims():
        yield Sdf.Path(one.path)
        for rel in one.rels:
            yield from (Sdf.Path(t.path).GetPrimPath() for t in rel.targets)


def selecting(found: VariantSet, choice: str) -> Sdf.Layer:
    """A session layer that selects a variant: stronger than what any layer of the stage says."""
    session = Sdf.Layer.CreateAnonymous("variant")
    spec = Sdf.CreatePrimInLayer(session, found.prim)
    spec.variantSelections[found.name] = choice
    return session

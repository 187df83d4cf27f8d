"""Through which stages is a layer seen?

In production a render layer is rarely a stage of its own: its camera stands in another layer, its
default settings in the shot that sublayers both. What is wrong with such a layer is what is wrong
with the stages that use it.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

from .discover import USD_SUFFIXES, RealPaths, Shown, Target
from .records import dataclass
from .results import Located

if TYPE_CHECKING:
    from .uses import Uses

MOST_SIBLINGS = 64
"""Files beside and above a layer that are looked at for a stage that uses it."""
MOST_STAGES = 8
"""Stages that are opened in a run to see whether they complete a layer."""
_NAMED = 3


@dataclass(frozen=True, slots=True)
class Outline:
    """What a stage is made of, as far as it tells which layers are its parts. Files as USD has them,
    paths in the namespaces of their layers."""

    stack: tuple[str, ...] = ()
    """Its root layer and all that this sublayers."""
    tops: frozenset[str] = frozenset()
    """Root prims of these layers."""
    brought: frozenset[tuple[str, str]] = frozenset()
    """File and path of other root prims that references and payloads bring to its render prims, or
    above them."""


@dataclass(frozen=True, slots=True)
class Plan:
    """Which stages are linted."""

    given: tuple[Target, ...]
    added: tuple[Target, ...] = ()
    """Roots that use one of the given layers, on whose behalf they are linted."""
    roots: frozenset[str] = frozenset()
    """Real paths of all that the configuration names."""
    mentioned: frozenset[str] = frozenset()
    """Real paths of the given layers that a root brings in, for its render spec or not."""
    notes: tuple[str, ...] = ()

    @property
    def targets(self) -> tuple[Target, ...]:
        return (*self.given, *self.added)


def planned(
    given: Sequence[Target], patterns: Sequence[str], scopes: Sequence[str], cwd: Path, shown: Shown
) -> Plan:
    """The given files, and the roots through which to see those that are none.

    `patterns` are those of `glob`, absolute or from `cwd`.
    """
    if not patterns:
        return Plan(tuple(given))
    from .uses import Uses  # most runs do without

    asked = {os.path.realpath(target.file): target for target in given}
    uses = Uses(asked, scopes)
    roots, idle = _matching(patterns, cwd, uses)
    layers = asked.keys() - roots.keys()
    added = []
    mentioned: set[str] = set()
    # Where all that was given is a root, nothing is to be learned from the others.
    for root, file in sorted(roots.items()) if layers else ():
        reach = uses.of(str(file))
        about = layers & (reach.stack | reach.maybe)
        mentioned |= about
        if not reach.sure or root in uses.unreadable:  # that is told where it is opened
            about = layers
        if about and root not in asked:
            added.append(Target(str(file), shown(file), tuple(sorted(about))))
    notes = [f"no file matches the root '{shown(pattern)}'" for pattern in idle]
    return Plan(tuple(given), tuple(added), frozenset(roots), frozenset(mentioned), tuple(notes))


def _matching(patterns: Sequence[str], cwd: Path, uses: Uses) -> tuple[dict[str, Path], list[str]]:
    """Roots by their real paths, and the patterns that match nothing.

    Layers of a shot often lie beside it, so `shots/*/*.usda` matches them, too: of what a wildcard
    in the name of the file matches, a layer of another match is no root. What a pattern spells out
    is one, whatever uses it.
    """
    import glob

    spelled: dict[str, Path] = {}
    found: dict[str, Path] = {}
    idle = []
    for pattern in patterns:
        absolute = str(cwd / pattern)
        # pathlib's own goes into hidden folders, too.
        named = map(Path, glob.glob(absolute, recursive=True))
        files = [file for file in named if file.suffix.lower() in USD_SUFFIXES and file.is_file()]
        if not files:
            idle.append(absolute)
        into = found if glob.has_magic(Path(pattern).name) else spelled
        into.update((os.path.realpath(file), file) for file in files)
    layers = uses.between(found)
    return {f: p for f, p in found.items() if f not in layers} | spelled, idle


def stages_of(files: Sequence[Target]) -> dict[str, str]:
    """For each file that another of them sublayers the first topmost one that does, as shown."""
    from .uses import Uses  # most runs do without

    uses, real = Uses((), ()), RealPaths()
    by_real = {real[target.file]: target for target in files}
    layers = uses.between({file: target.file for file, target in by_real.items()})
    found: dict[str, str] = {}
    for target in files:
        if real[target.file] not in layers:
            for layer in uses.of(target.file).stack & layers:
                found.setdefault(by_real[layer].shown, target.shown)
    return found


def seen_through(
    targets: Sequence[Target], outlines: Sequence[Outline], roots: frozenset[str]
) -> list[tuple[int, ...]]:
    """For each target those others that complete it; none for one that is a stage of its own.

    A stage completes what it sublayers, at whatever depth. What it references, only if it takes all
    of it, down from every root prim, to where it has its own render prims. A render spec without a
    world can be nothing but a part; a shot that lends its `/Render` to another one is still rendered
    by itself, and so judged by itself. Whoever says otherwise names the roots.

    Layers that sublayer each other are nobody's parts.
    """
    if not any(len(one.stack) > 1 or one.brought for one in outlines):
        return [() for _ in targets]
    real = RealPaths()
    files = [real[target.file] for target in targets]
    stacks = [frozenset(map(real.__getitem__, one.stack)) for one in outlines]
    brought = [{(real[file], path) for file, path in one.brought} for one in outlines]
    holders: dict[str, set[int]] = {}
    for i, stack in enumerate(stacks):
        for file in stack:
            holders.setdefault(file, set()).add(i)

    def completes(stage: int, part: int) -> bool:
        if files[part] in stacks[stage]:
            return files[stage] not in stacks[part]
        return bool(outlines[part].tops) and all(
            any((file, top) in brought[stage] for file in stacks[part])
            for top in outlines[part].tops
        )

    index = {file: i for i, file in enumerate(files)}
    users: list[set[int]] = [set() for _ in targets]
    for stage in range(len(targets)):
        parts = {index[file] for file in stacks[stage] & index.keys()}
        parts.update(part for file, _ in brought[stage] for part in holders.get(file, ()))
        for part in parts - {stage}:
            if files[part] not in roots and completes(stage, part):
                users[part].add(stage)
    return [tuple(sorted(user for user in found if not users[user])) for found in users]


def not_used(plan: Plan, layers: Sequence[Iterable[str]], shown: Shown) -> Iterator[str]:
    """What there is to say of given layers that no root uses. `layers`: all of each target, as shown."""
    if not plan.roots:
        return
    real = RealPaths()
    left = {real[t.file] for t in plan.given} - plan.roots - plan.mentioned
    if not left:
        return
    for target, files in zip(plan.targets, layers, strict=True):
        if real[target.file] in plan.roots:
            if not files:  # nobody knows what a root uses that cannot be read
                return
            left.difference_update(real[str(shown.root / file)] for file in files)
    alone = [t.shown for t in plan.given if real[t.file] in left]
    if alone:
        as_stage = "is linted as a stage of its own" if len(alone) == 1 else "are linted as stages"
        yield f"no root uses {_some(alone)}, which {as_stage}"


def siblings(targets: Sequence[Target], scopes: Sequence[str], shown: Shown) -> list[list[Target]]:
    """For each target the stages in its folder, or in the one above, that sublayer it."""
    if not targets:
        return []
    from .uses import Uses  # most runs do without

    uses, real = Uses((), scopes), RealPaths()
    listed: dict[str, list[str]] = {}
    found = []
    for target in targets:
        file = real[target.file]
        folder = os.path.dirname(file)
        near: list[str] = []
        for one in dict.fromkeys((folder, os.path.dirname(folder))):
            if one not in listed:
                listed[one] = [real[f] for f in islice(_usd_files(one), MOST_SIBLINGS)]
            near.extend(listed[one])
        users = [one for one in near if one != file and file in uses.of(one).stack]
        inner = uses.between({one: one for one in users})
        found.append([Target(one, shown(one)) for one in users if one not in inner])
    return found


def _usd_files(folder: str) -> Iterator[str]:
    try:
        names = sorted(os.listdir(folder))
    except OSError:
        return
    for name in names:
        if name.lower().endswith(USD_SUFFIXES) and not name.startswith("."):
            yield os.path.join(folder, name)


def advised(
    findings: Iterable[Located], stages: Mapping[str, Iterable[Located]]
) -> tuple[Located, ...]:
    """Findings of a layer on its own; those that do not hold in a stage that sublayers it say so.
    `stages`: what was found in such stages, by their names."""
    holding = {name: {f.known_by for f in found} for name, found in stages.items()}
    advised = []
    for finding in findings:
        right_in = next((n for n, known in holding.items() if finding.known_by not in known), None)
        if right_in is not None:
            todo = f"it is right in {right_in}, which sublayers this layer: lint that, or set roots"
            finding = replace(finding, help=todo, related=())
        advised.append(finding)
    return tuple(advised)


def _some(names: Sequence[str]) -> str:
    more = len(names) - _NAMED
    if more > 0:
        return f"{', '.join(names[:_NAMED])} and {more} more"
    *others, last = names
    return f"{', '.join(others)} and {last}" if others else last

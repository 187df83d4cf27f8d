"""Can the passes be run, one after the other, and does each leave its own images?"""

from __future__ import annotations

import posixpath
import re
from collections import deque
from collections.abc import Iterator, Mapping
from itertools import pairwise

from ..lazily import lazily
from ..model import HasSite, Output, Pass, RenderScope, Settings, Site, Target
from ..rule import Context, Finding, Severity, Sign, rule
from ._chains import dead_ends, start_of
from ._names import is_file
from ._order import Order
from ._words import paths

GROUP = "pass"

_PASS_TOKEN = lazily(r"[<{\[@%$]\W?(render)?_?pass(_?name)?\b|[$]\{?(render)?_?pass", re.IGNORECASE)
"""Something puts the name of the pass into the name of the file."""


@rule("missing-render-source", on=Pass, severity=Severity.ERROR, since="0.1")
def missing_render_source(render_pass: Pass, context: Context) -> Iterator[Finding]:
    """A pass does not say what it renders."""
    if render_pass.render_source.named:
        return
    if render_pass.file_name.authored:
        severity, said = (
            Severity.NOTE,
            "only the application that opens its fileName knows what to render",
        )
    else:
        severity, said = None, "nothing says what to render"
    yield Finding(
        Site(f"{render_pass.path}.renderSource"),
        f"<{render_pass.path}> has no renderSource: {said}",
        label="no render source",
        help="point it at settings: rel renderSource = </Render/Primary>",
        related=dead_ends(render_pass.render_source),
        severity=severity,
    )


@rule(
    "input-pass-cycle", on=RenderScope, severity=Severity.ERROR, since="0.1", about=("inputPasses",)
)
def input_pass_cycle(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """Passes wait for each other."""
    passes = {p.path: p for p in scope.passes if p.live}
    inputs = {
        path: [t.path for t in p.input_passes.targets if t.path in passes]
        for path, p in passes.items()
    }
    told: set[str] = set()
    order = Order(inputs)
    for path in sorted(passes):
        if path in told or not order.waits_for_itself(path):
            continue
        cycle = _way_back(path, inputs)
        told.update(cycle)
        edges = [(one, _entry(passes[one], other)) for one, other in pairwise(cycle)]
        said = (
            f"<{path}> waits for itself"
            if len(cycle) == 2
            else "passes wait for each other: " + " -> ".join(f"<{p}>" for p in cycle)
        )
        closing = edges.pop()[1]
        yield Finding(
            closing.written,
            f"{said}: no order of execution exists",
            label="closes the cycle",
            help="remove one of these inputPasses" if edges else "remove it",
            related=(
                *start_of(closing),
                *(
                    (entry.written, f"makes <{one}> wait for <{entry.path}>")
                    for one, entry in edges
                ),
            ),
            explains=tuple(entry for _, entry in (*edges, (path, closing))),
        )


def _entry(waiting: Pass, path: str) -> Target:
    return next(t for t in waiting.input_passes.targets if t.path == path)


def _way_back(start: str, inputs: Mapping[str, list[str]]) -> list[str]:
    """A shortest way from a pass to itself, with it at both ends; empty without one."""
    before: dict[str, str] = {}
    pending = deque([start])
    while pending:
        path = pending.popleft()
        for following in inputs[path]:
            if following == start:
                way = [start]
                while path != start:
                    way.append(path)
                    path = before[path]
                return [start, *reversed(way[1:]), start]
            if following not in before:
                before[following] = path
                pending.append(following)
    return []


@rule(
    "passes-overwrite-output",
    on=RenderScope,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=("shared-product",),
    about=(Sign.RENDER_PASS,),
)
def passes_overwrite_output(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """Several passes write the same file."""
    order = Order({p.path: [t.path for t in p.input_passes.targets] for p in scope.passes})
    sources = _sources(scope)
    writers: dict[str, list[tuple[Pass, Output]]] = {}
    for one in (p for p in _passes(scope) if not p.file_name.value):
        for name, output in _files(one, sources, context).items():
            writers.setdefault(name, []).append((one, output))
    told: dict[str, list[set[str]]] = {}
    for found in sorted(writers.values(), key=len, reverse=True):
        rivals = _rivals(found, order)
        passes = {p.path for p, _ in rivals}
        if len(passes) > 1 and not any(passes <= o for o in told.get(rivals[0][0].path, ())):
            for path in passes:
                told.setdefault(path, []).append(passes)
            yield _overwrites(rivals)


def _passes(scope: RenderScope) -> list[Pass]:
    """Live passes; what instances share is one pass."""
    live = [p for p in scope.passes if p.live]
    return list({p.prototype or p.path: p for p in reversed(live)}.values())[::-1]


def _files(one: Pass, sources: Mapping[str, Settings], context: Context) -> dict[str, Output]:
    """What a pass writes, but for names that tell the pass."""
    outputs = {o.product.first_name: o for o in reversed(_outputs(one, sources))}
    return {
        posixpath.normpath(name.replace("\\", "/")): output
        for name, output in outputs.items()
        if is_file(name, context.renderer) and not _PASS_TOKEN.search(name)
    }


def _rivals(found: list[tuple[Pass, Output]], order: Order) -> list[tuple[Pass, Output]]:
    """Those that something else overwrites. Not if nothing says which of two comes first, but that
    each waits for the other; nor if one works on the images of the other, by another program."""
    everything = order.bits(p.path for p, _ in found)
    by_type: dict[str, list[str]] = {}
    for one, _ in found:
        by_type.setdefault(one.pass_type.value, []).append(one.path)
    alike = {kind: order.bits(members) for kind, members in by_type.items()}
    return [
        (one, output)
        for one, output in found
        if order.unordered(one.path) & everything
        or order.one_way(one.path) & alike[one.pass_type.value]
    ]


def _outputs(one: Pass, sources: Mapping[str, Settings]) -> tuple[Output, ...]:
    source = _source(one, sources)
    return tuple(o for o in source.outputs if o.product.live) if source else ()


def _sources(scope: RenderScope) -> dict[str, Settings]:
    return {s.path: s for s in scope.settings if s.live}


def _source(one: Pass, sources: Mapping[str, Settings]) -> Settings | None:
    """The settings that a pass renders: the first target counts, or what it was meant to be."""
    first = next(iter(one.render_source.targets), None)
    candidates = (first.path, first.meant or "") if first else ()
    return next((sources[path] for path in candidates if path in sources), None)


def _overwrites(writers: list[tuple[Pass, Output]]) -> Finding:
    """It stands where the first two come together."""
    (_, other), (second, output) = writers[:2]
    name = output.product.product_name
    at: HasSite = name
    related: list[tuple[HasSite, str]] = [(one, "writes it") for one, _ in writers]
    if output.settings == other.settings:
        source = second.render_source.targets[0]
        # A target that leads nowhere has a fault of its own, which is told at its place.
        at, label = (source if source.live else second), "the same settings"
        todo = "give each pass settings and products of its own"
        related = [(one, "writes it, too") for one, _ in writers if one is not second]
        related.append((name, "is the file"))
    elif output.product is other.product:
        label, todo = "written by both", "give the settings of each pass a product of its own"
    else:
        label, todo = "the same file", "give the products of each pass names of their own"
        related.append((other.product.product_name, "is the same file"))
    return Finding(
        at,
        f"the passes {paths(p.path for p, _ in writers)} write the same file '{output.product.first_name}': one overwrites the other",
        label=label,
        help=todo,
        related=tuple(related[:4]),
        explains=(at, *(Site(o.settings) for _, o in writers)),
    )


@rule(
    "multiple-render-sources",
    on=Pass,
    severity=Severity.WARNING,
    since="0.1",
    about=("renderSource",),
)
def multiple_render_sources(render_pass: Pass, context: Context) -> Iterator[Finding]:
    """A pass names several render sources, and only the first is used."""
    targets = render_pass.render_source.targets
    if len(targets) > 1:
        yield Finding(
            targets[1].written,
            f"<{render_pass.path}> names {len(targets)} render sources: only the first, <{targets[0].path}>, is rendered",
            label="not rendered",
            help="leave one, and make a pass for each of the others",
            related=start_of(targets[1]),
        )


@rule(
    "input-pass-without-output",
    on=RenderScope,
    severity=Severity.WARNING,
    since="0.1",
    supersedes=("empty-product-name", "settings-without-products"),
    about=("inputPasses",),
)
def input_pass_without_output(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A pass waits for another one that writes no file."""
    passes = {p.path: p for p in scope.passes if p.live and not p.file_name.authored}
    readers: dict[str, list[Pass]] = {}
    for one in (p for p in scope.passes if p.live):
        for target in one.input_passes.targets:
            if target.path in passes and target.path != one.path:
                readers.setdefault(target.path, []).append(one)
    told: set[str] = set()
    sources = _sources(scope)
    for path, waiting in readers.items():
        source = _source(passes[path], sources)
        if source is None or source.path in told:
            continue
        told.add(source.path)
        yield from _unread(source, passes[path], waiting)


def _unread(source: Settings, one: Pass, waiting: list[Pass]) -> Iterator[Finding]:
    outputs = [o for o in source.outputs if o.product.live]
    reader = f"{paths(p.path for p in waiting)} {'reads' if len(waiting) == 1 else 'read'}"
    entries = [t for p in waiting for t in p.input_passes.targets if t.path == one.path]
    related = tuple((t, f"waits for <{one.path}>") for t in entries[:3])
    if not outputs and not source.products.named:
        yield Finding(
            Site(f"{source.path}.products"),
            f"<{source.path}> has no products, and {reader} the images of <{one.path}>: there are none",
            label="writes no file",
            help="give it a product, or take the pass out of the inputPasses",
            related=related,
        )
    if outputs and not any(o.product.first_name for o in outputs):
        for output in outputs:
            yield Finding(
                output.product.product_name,
                f"<{output.product.path}> has no productName, and {reader} the images of <{one.path}>: there is no file",
                label="writes no file",
                help="name the file",
                related=related,
            )


@rule(
    "duplicate-pass-name",
    on=RenderScope,
    severity=Severity.WARNING,
    since="0.1",
    about=(Sign.RENDER_PASS,),
)
def duplicate_pass_name(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """Two passes have the same name, which is the name of the prim."""
    first: dict[str, Pass] = {}
    for one in _passes(scope):
        other = first.setdefault(one.name, one)
        if other is not one:
            yield Finding(
                one,
                f"<{one.path}> and <{other.path}> are both the pass '{one.name}': jobs and files named by the pass collide",
                label="the same name",
                help="rename one of the two",
                related=((other, "has it, too"),),
            )

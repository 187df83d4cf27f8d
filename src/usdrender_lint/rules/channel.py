"""Does each var write a channel of its own, from a source that exists?"""

from __future__ import annotations

from collections.abc import Iterator

from ..model import HasSite, Output, RenderScope, Settings, Var
from ..rule import Context, Finding, Renderer, Severity, rule
from ._handful import handful
from ._types import pixel
from ._words import joined, paths

GROUP = "var"

_ABOUT_CHANNELS = ("camera", "channel", "layer", "prefix", "suffix")
"""In an attribute's name: it may give another name to the channels, or other content."""
_ABOUT_FORMAT = ("arnold:format", "driver:parameters:aov:format")


def _named(var: Var, renderer: Renderer) -> HasSite | None:
    """What authors the name of the channel, if that is not the source."""
    for name in renderer.aov_name_attributes:
        attr = var.extra_attr(name)
        if attr is not None and attr.value:
            return attr
    return var if var.source_type.value == "lpe" else None


def _channel(var: Var, renderer: Renderer) -> str:
    """Empty for a var that names neither channel nor source."""
    for name in renderer.aov_name_attributes:
        attr = var.extra_attr(name)
        if attr is not None and attr.value:
            return attr.value
    return var.name if var.source_type.value == "lpe" else var.source_name.value


def _by_channel(output: Output, renderer: Renderer) -> dict[str, list[Var]]:
    found: dict[str, list[Var]] = {}
    for var in output.vars:
        if var.live and (name := _channel(var, renderer)):
            found.setdefault(name, []).append(var)
    return found


def _told_apart(one: Var, other: Var, renderer: Renderer) -> bool:
    """A renderer has means to make two channels of them: filters, prefixes, a camera for each."""
    by_source = _named(one, renderer) is None and _named(other, renderer) is None
    if by_source and renderer.renames_duplicates and one.name != other.name:
        return True
    return _means(one, renderer, by_source) != _means(other, renderer, by_source)


def _means(var: Var, renderer: Renderer, by_source: bool) -> dict[str, str]:
    """What a renderer's own attributes say. Once the channel is named by one of them, only those
    count that change its name again."""
    ignored = (*renderer.aov_name_attributes, *_ABOUT_FORMAT)
    return {
        attr.name: attr.value
        for attr in var.extras
        if attr.name not in ignored
        and (by_source or any(word in attr.name.lower() for word in _ABOUT_CHANNELS))
    }


def _differences(one: Var, other: Var) -> list[str]:
    pairs = (
        (one.source_name, other.source_name),
        (one.source_type, other.source_type),
        (one.data_type, other.data_type),
    )
    return [
        f"{a.name} ('{a.value}', here '{b.value}')"
        for a, b in pairs
        if a.value != b.value
    ]  # fmt: skip


@rule(
    "duplicate-channel",
    on=RenderScope,
    severity=Severity.ERROR,
    since="0.1",
    supersedes=("conflicting-aov",),
    about=("orderedVars",),
)
def duplicate_channel(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """Two vars of one product write the same channel."""
    told: set[tuple[str, ...]] = set()
    for settings in scope.settings:
        for output in settings.outputs:
            if not (settings.live and output.product.live):
                continue
            for name, group in _by_channel(output, context.renderer).items():
                if len(group) < 2:
                    continue
                same = _alike(group, context.renderer)
                key = tuple(v.path for v in same)
                if len(same) > 1 and key not in told:
                    told.add(key)
                    yield _duplicate(output, name, same, context.renderer)


def _alike(group: list[Var], renderer: Renderer) -> list[Var]:
    """The first, and those that nothing tells apart from it; else the same of the second, and so on."""
    for index, first in enumerate(group):
        same = [v for v in group[index + 1 :] if not _told_apart(first, v, renderer)]
        if same:
            return [first, *same]
    return []


def _duplicate(output: Output, name: str, same: list[Var], renderer: Renderer) -> Finding:
    first, second = same[0], same[1]
    differ = any(_differences(first, v) for v in same[1:])
    kept = "renderers keep one of them" if differ else "once is enough"
    return Finding(
        _named(second, renderer) or second.source_name,
        f"{paths(v.path for v in same)} write the channel '{name}' of <{output.product.path}>: {kept}",
        label="the same channel",
        help="give each var a channel of its own, or list only one of them",
        related=((_named(first, renderer) or first.source_name, "writes it first"),),
        severity=None if differ else Severity.WARNING,
    )


@rule(
    "conflicting-aov",
    on=RenderScope,
    severity=Severity.WARNING,
    since="0.1",
    about=("orderedVars",),
)
def conflicting_aov(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """Vars of different products share a channel's name and differ in what it holds."""
    told: set[frozenset[str]] = set()
    for settings in scope.settings:
        if not settings.live or len(settings.outputs) < 2:
            continue
        for pair, finding in _conflicts(settings, context.renderer):
            # Two renders may hold the same two vars, in whatever order.
            if pair not in told:
                told.add(pair)
                yield finding


def _conflicts(settings: Settings, renderer: Renderer) -> Iterator[tuple[frozenset[str], Finding]]:
    first: dict[str, tuple[Output, Var]] = {}
    told: set[str] = set()
    for output in settings.outputs:
        for name, group in _by_channel(output, renderer).items() if output.product.live else ():
            elsewhere, other = first.setdefault(name, (output, group[0]))
            for var in group:
                if var.path in told or elsewhere is output or _told_apart(other, var, renderer):
                    continue
                if differing := _differences(other, var):
                    told.add(var.path)
                    pair = frozenset((var.path, other.path))
                    yield (
                        pair,
                        _conflict(name, (elsewhere, other), (output, var), differing, renderer),
                    )


def _conflict(
    name: str,
    first: tuple[Output, Var],
    second: tuple[Output, Var],
    differing: list[str],
    renderer: Renderer,
) -> Finding:
    (elsewhere, other), (output, var) = first, second
    return Finding(
        _named(var, renderer) or var.source_name,
        f"'{name}' of <{output.product.path}> differs from that of <{elsewhere.product.path}> in {joined(differing)}: "
        "renderers that go by the name keep the first",
        label="another AOV of this name",
        help="give it a name of its own, or list the same var in both products",
        related=((_named(other, renderer) or other.source_name, "has the name first"),),
        severity=Severity.NOTE if _only_precision(other, var) else None,
    )


def _only_precision(one: Var, other: Var) -> bool:
    """Half or float: the file is larger or coarser than it was to be, and holds the right thing."""
    if [d.partition(" ")[0] for d in _differences(one, other)] != ["dataType"]:
        return False
    first, second = pixel(one.data_type.value), pixel(other.data_type.value)
    return bool(
        first and second and (first.components, first.whole) == (second.components, second.whole)
    )


@rule(
    "prefixed-source-name",
    on=RenderScope,
    severity=Severity.WARNING,
    since="0.1",
    supersedes=("invalid-lpe", "nonportable-lpe", "suspicious-lpe", "unknown-primvar"),
    about=("sourceType",),
)
def prefixed_source_name(scope: RenderScope, context: Context) -> Iterator[Finding]:
    """A source name repeats what the source type says already."""
    accepted = context.renderer.source_prefixes
    found = (
        _prefixed(var, prefix)
        for var in scope.vars
        if var.live and (prefix := _prefix(var)) and prefix not in accepted
    )
    yield from handful(found, "vars")


def _prefix(var: Var) -> str:
    known = {"lpe": ("lpe:",), "primvar": ("primvars:", "primvar:")}
    given = known.get(var.source_type.value, ())
    return next((p for p in given if var.source_name.value.startswith(p)), "")


def _prefixed(var: Var, prefix: str) -> Finding:
    name, plain = var.source_name.value, var.source_name.value.removeprefix(prefix)
    if prefix == "lpe:":
        said = (
            f"'{name}' has the prefix that renderers add by themselves: they look for 'lpe:{name}'"
        )
    else:
        said = f"'{name}' is not what the primvar is called: '{plain}' is"
    return Finding(
        var.source_name,
        said,
        label=f"with '{prefix}'",
        help=f'write uniform string sourceName = "{plain}"',
        related=((var.source_type, "says so already"),),
    )

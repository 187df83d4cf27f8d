"""What is wanted of each file, when the command line has spoken and its configuration, too?

The command line stands above the configuration: `--select` says which rules run, whatever is
selected, ignored or off there; the other options replace one value, or add to it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from pathlib import Path
from typing import Literal

from .config import Asked, ConfigError, Configuration, Source
from .job import SCOPES, Config
from .patterns import Patterns
from .records import dataclass
from .registry import all_rules, matching, select
from .renderers import Own, names, renderer
from .rule import Severity

AUTO = "auto"
OFF: Literal["off"] = "off"


@dataclass(frozen=True, slots=True)
class Options:
    """The command line, as far as a configuration could say the same. None: it says nothing."""

    select: tuple[str, ...] | None = None
    extend_select: tuple[str, ...] = ()
    ignore: tuple[str, ...] = ()
    severity: Mapping[str, str] = field(default_factory=dict)
    """By rule; a severity or `off`."""
    renderer: str | None = None
    scene: bool | None = None
    variants: bool | None = None
    fail_on: str | None = None
    baseline: Path | None = None
    ignores: bool = True


def wrong_value(source: Source, path: tuple[str | int, ...], message: str) -> ConfigError:
    # What is needed to tell of a mistake is not worth a run without one.
    from .config import wrong

    return wrong.wrong_value(source, path, message)


class WantedError(Exception):
    """The command line asks for what there is not."""


def wanted(configuration: Configuration, options: Options) -> Config:
    """`ConfigError` or `WantedError` for what cannot be had."""
    scene = _flag(configuration, "scene", options.scene)
    levels = _levels(configuration, options)
    chosen = [*(options.select or _selected(configuration)), *options.extend_select]
    selection = select(chosen, _left_out(configuration, options, levels), scene=scene)
    if not selection.told:
        raise _nothing_to_do(configuration, options, "no rule is selected")
    own = _own_renderers(configuration)
    judge = _renderer(configuration, options, own)
    severities = {rule: Severity(level) for rule, level in levels.items() if level != OFF}
    if judge != AUTO and not any(_speaks(rule, judge, own, severities) for rule in selection.told):
        raise _nothing_to_do(configuration, options, f"no rule that is selected is for {judge}")
    return Config(
        selection,
        severities,
        judge,
        own,
        _flag(configuration, "variants", options.variants),
        scopes=_scopes(configuration),
        ignores=options.ignores,
        per_file_ignores=_per_file_ignores(configuration),
        fail_on=options.fail_on or _text(configuration.asked("fail-on"), "warning"),
        roots=_roots(configuration),
    )


def baseline(configuration: Configuration) -> Path | None:
    asked = configuration.asked("baseline")
    return asked.source.file.parent / asked.value if asked else None


def _flag(configuration: Configuration, key: str, option: bool | None) -> bool:
    asked = configuration.asked(key)
    return option if option is not None else bool(asked and asked.value)


def _text(asked: Asked | None, default: str) -> str:
    return str(asked.value) if asked else default


def _selected(configuration: Configuration) -> list[str]:
    asked = configuration.asked("select")
    more = configuration.added("extend-select", "select")
    return [*(asked.value if asked else ["default"]), *(r for one in more for r in one.value)]


def _levels(configuration: Configuration, options: Options) -> dict[str, str]:
    """By rule: what a subject gets, and above it what the rule itself gets."""
    entries = configuration.entries("severity")
    found: dict[str, str] = {}
    for selector in sorted(entries, key=_breadth, reverse=True):
        found.update(dict.fromkeys(matching(selector), entries[selector].value))
    return found | dict(options.severity)


def _breadth(selector: str) -> int:
    """How many rules a selector may mean: an id one, a subject some, `default` most, `ALL` all."""
    if selector in all_rules():
        return 0
    return {"default": 2, "ALL": 3}.get(selector, 1)


def _left_out(
    configuration: Configuration, options: Options, levels: Mapping[str, str]
) -> set[str]:
    found: set[str] = set()
    if options.select is None:
        if asked := configuration.asked("ignore"):
            found = found.union(*map(matching, asked.value))
        found |= {rule for rule, level in levels.items() if level == OFF}
        found = found.difference(*map(matching, options.extend_select))
    found |= {rule for rule, level in options.severity.items() if level == OFF}
    return found.union(*map(matching, options.ignore))


def _speaks(
    rule: str, judge: str, own: tuple[Own, ...], severities: Mapping[str, Severity]
) -> bool:
    """Whether a rule has a say where that renderer judges."""
    whose = all_rules()[rule].renderers
    if whose and judge not in whose:
        return False
    off = {rule for rule, severity in renderer(judge, own).severities.items() if severity is None}
    return rule in severities or rule not in off


def _nothing_to_do(
    configuration: Configuration, options: Options, why: str
) -> WantedError | ConfigError:
    said = f"{why}: nothing would be linted"
    asked = configuration.asked("select") or configuration.asked("ignore")
    if options.select or options.ignore or options.severity or not asked:
        return WantedError(said)
    return wrong_value(asked.source, (asked.path[-1],), said)


def _own_renderers(configuration: Configuration) -> tuple[Own, ...]:
    asked = configuration.asked("renderers")
    if asked is None:
        return ()
    from .config.own_renderers import own_renderer

    found: dict[str, Own] = {}
    for index, name in enumerate(asked.value):
        file = asked.source.file.parent / name
        path = ("renderers", index)
        try:
            one = own_renderer(file)
        except ConfigError as error:
            if error.wrongs[0].span is None:
                said = f"{name}: {error.wrongs[0].message}"
                raise wrong_value(asked.source, path, said) from None
            raise
        if one.name in found:
            raise wrong_value(asked.source, path, f"a second renderer of the name '{one.name}'")
        found[one.name] = one
    return tuple(found.values())


def _renderer(configuration: Configuration, options: Options, own: tuple[Own, ...]) -> str:
    asked = configuration.asked("renderer")
    name = options.renderer or _text(asked, AUTO)
    known = [AUTO, *names(own)]
    if name in known:
        return name
    from .config.wrong import suggestion

    said = f"unknown renderer '{name}'{suggestion(name, known)}"
    if options.renderer or not asked:
        raise WantedError(said)
    raise wrong_value(asked.source, ("renderer",), said)


def _scopes(configuration: Configuration) -> tuple[str, ...]:
    asked = configuration.asked("scopes")
    if asked is None:
        return SCOPES
    if not asked.value:
        raise wrong_value(asked.source, ("scopes",), "no scope: render prims would belong nowhere")
    return tuple(
        one
        for one in dict.fromkeys(asked.value)
        if not any(one.startswith(f"{other}/") for other in asked.value)
    )


def _per_file_ignores(
    configuration: Configuration,
) -> tuple[tuple[Patterns, frozenset[str]], ...]:
    return tuple(
        (
            Patterns([pattern], asked.source.folder),
            frozenset[str]().union(*map(matching, asked.value)),
        )
        for pattern, asked in configuration.entries("per-file-ignores").items()
    )


def _roots(configuration: Configuration) -> tuple[str, ...]:
    asked = configuration.asked("roots")
    if asked is None:
        return ()
    import glob

    folder = glob.escape(asked.source.folder)
    return tuple(str(Path(folder, pattern)) for pattern in asked.value)

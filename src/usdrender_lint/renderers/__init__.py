r"""What does each renderer accept, and which one does a stage seem to be for?

One TOML file a renderer. What `any` accepts, all accept. All keys but `title` are optional:

    title = "Arnold"                  as the summary calls it
    product-types = [...]             productType values beside the schema's own
    deep-types = [...]                those of them that write deep images
    deep-extensions = [".rat"]        extensions for deep images beside .exr; for `any` those of all renderers
    special-product-names = [...]     product names that are no files
    unnamed-product = "..."           what it does with a product that has no name
    camera-types = ["OmniSensor*"]    prim types accepted where a Camera is expected
    data-types = [...]                dataType values beside USD's value types
    unsupported-data-types = [...]    value types of USD that it does not take for dataType
    host-prims = ["/Kit_*"]           prims of the host application that no file holds
    source-name-attributes = [...]    attributes (* matches) that may stand for a var's sourceName
    extensions = [".exr"]             of the files that it writes; for `any` those of all renderers
    unsupported-extensions = [".jpg"] which `any` lists and it does not write
    exact-extension-case = true       .PNG is no .png to it
    multi-channel-extensions = [...]  of files beside .exr that hold any number of channels
    frame-tokens = ['[$]F[0-9]*']     regular expressions that it replaces by the frame in a product's name
    name-variables = ['[$]\w+']       regular expressions of what else it expands in a product's name
    namespaces = [...]                of properties that belong to it
    aov-name-attributes = [...]       attributes that name a var's channel, strongest first
    source-types = [...]              sourceType values beside the schema's own
    source-prefixes = ["lpe:"]        with which a sourceName may begin though sourceType says the same
    renames-duplicates = true         vars that share a sourceName are told apart by their prims' names
    lpe-dialect = "karma"             see `lpe`
    properties = [...]                un-namespaced properties that it reads on render prims
    accepted-types = [["sourceName", "token"]]
    [severity]                        rules whose severity differs, or "off"
    [evidence]                        what tells that a stage is for it:
    namespaces, schemas (a final * matches the rest), product-types, camera-types, prim-names, layer-data
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from fnmatch import translate
from functools import cache
from pathlib import Path
from typing import Any

from ..model import Evidence
from ..records import dataclass
from ..rule import Renderer, Severity

ANY = "any"


@dataclass(frozen=True, slots=True)
class Own:
    """A renderer that a show adds to those of the package; its text is known to be one."""

    name: str
    text: str


@cache
def _built_in() -> dict[str, dict[str, Any]]:
    import tomllib

    return {file.stem: tomllib.loads(file.read_text("utf-8")) for file in _files()}


def _files() -> list[Path]:
    return sorted(Path(__file__).parent.glob("*.toml"))


@cache
def _tables(own: tuple[Own, ...]) -> dict[str, dict[str, Any]]:
    import tomllib

    tables = _built_in() | {one.name: tomllib.loads(one.text) for one in own}
    return dict(sorted(tables.items()))


def names(own: tuple[Own, ...] = ()) -> list[str]:
    return sorted([*(file.stem for file in _files()), *(one.name for one in own)])


def renderer(name: str, own: tuple[Own, ...] = ()) -> Renderer:
    """The facts about one renderer; `KeyError` for a name that is not in `names()`."""
    return _read(name, (name,), own)


def _any_of(contenders: tuple[str, ...], own: tuple[Own, ...]) -> Renderer:
    """For a stage that is made for several: what one of them accepts is no mistake, and what one of
    them leaves out is not told."""
    return _read(ANY, contenders, own)


@cache
def _read(name: str, accepting: tuple[str, ...], own: tuple[Own, ...]) -> Renderer:
    known = _tables(own)
    table = known[name]
    tables = [*(known[one] for one in accepting if one != ANY), known[ANY]]

    def ordered(key: str) -> tuple[str, ...]:
        return tuple(dict.fromkeys(entry for one in tables for entry in one.get(key, ())))

    def listed(key: str) -> frozenset[str]:
        return frozenset(ordered(key))

    return Renderer(
        name,
        table["title"],
        product_types=listed("product-types"),
        deep_types=listed("deep-types"),
        deep_extensions=_every("deep-extensions", own)
        if name == ANY
        else listed("deep-extensions"),
        special_product_names=listed("special-product-names"),
        camera_types=listed("camera-types"),
        data_types=listed("data-types"),
        unsupported_data_types=listed("unsupported-data-types"),
        host_prims=listed("host-prims"),
        source_name_attributes=listed("source-name-attributes"),
        properties=listed("properties"),
        unnamed_product=table.get("unnamed-product", ""),
        extensions=_every("extensions", own) if name == ANY else listed("extensions"),
        unsupported_extensions=listed("unsupported-extensions"),
        exact_extension_case=bool(table.get("exact-extension-case")),
        multi_channel_extensions=listed("multi-channel-extensions"),
        frame_tokens=ordered("frame-tokens"),
        name_variables=ordered("name-variables"),
        namespaces=listed("namespaces"),
        known_namespaces=_every("namespaces", own),
        aov_name_attributes=ordered("aov-name-attributes"),
        source_types=listed("source-types"),
        source_prefixes=listed("source-prefixes"),
        renames_duplicates=bool(table.get("renames-duplicates")),
        lpe_dialect=table.get("lpe-dialect"),
        accepted_types=frozenset(
            (prop, kind) for one in tables for prop, kind in one.get("accepted-types", ())
        ),
        severities={
            rule: None if level == "off" else Severity(level)
            for one in tables
            for rule, level in one.get("severity", {}).items()
            if one is table or level == "off"
        },
    )


def _every(key: str, own: tuple[Own, ...]) -> frozenset[str]:
    """What all tables list; an empty entry is one renderer's affair."""
    return frozenset(n for one in _tables(own).values() for n in one.get(key, ()) if n)


def choose(evidence: Evidence, own: tuple[Own, ...] = ()) -> tuple[Renderer, str]:
    """The renderer that left by far the most traces, and which; `any` where none did, or several."""
    weighed = [
        (weight, name, reason)
        for name, table in _tables(own).items()
        for weight, reason in [_weigh(table.get("evidence", {}), evidence)]
        if weight
    ]
    if not weighed:
        return renderer(ANY, own), "no traces of a renderer"
    most = max(weight for weight, _, _ in weighed)
    contenders = [(name, reason) for weight, name, reason in weighed if 2 * weight > most]
    if len(contenders) == 1:
        return renderer(contenders[0][0], own), contenders[0][1]
    names = tuple(name for name, _ in contenders)
    return _any_of(names, own), f"traces of {' and '.join(names)}, none by far the most"


def _weigh(table: dict[str, Any], evidence: Evidence) -> tuple[int, str]:
    traces = [
        (
            "properties in the namespace",
            _matching(table.get("namespaces", ()), evidence.namespaces),
        ),
        ("applied schemas", _matching(table.get("schemas", ()), evidence.schemas)),
        ("productType", _matching(table.get("product-types", ()), evidence.product_types)),
        ("cameras of type", _matching(table.get("camera-types", ()), evidence.camera_types)),
        ("prims named", _matching(table.get("prim-names", ()), _once(evidence.prim_names))),
        ("layer data", _matching(table.get("layer-data", ()), _once(evidence.layer_data))),
    ]
    weight = sum(count for _, found in traces for _, count in found)
    said = [f"{what} {', '.join(repr(n) for n, _ in found)}" for what, found in traces if found]
    return weight, "; ".join(said)


def _once(found: Iterable[str]) -> list[tuple[str, int]]:
    return [(name, 1) for name in found]


def _matching(patterns: Iterable[str], found: Iterable[tuple[str, int]]) -> list[tuple[str, int]]:
    matches = _pattern(tuple(patterns))
    return [(name, n) for name, n in found if matches(name)]


@cache
def _pattern(patterns: tuple[str, ...]) -> Callable[[str], object]:
    return re.compile("|".join(map(translate, patterns)) or r"(?!)").match

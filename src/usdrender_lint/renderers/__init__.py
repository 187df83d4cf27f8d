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

from collections.abc import Iterable
from fnmatch import fnmatchcase
from functools import cache, lru_cache
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
        exact_extension_case=_case_matters_to(name, own),
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


def _case_matters_to(name: str, own: tuple[Own, ...]) -> frozenset[str]:
    tables = _tables(own)
    asked = tables.values() if name == ANY else (tables[name],)
    return frozenset(t["title"] for t in asked if t.get("exact-extension-case"))


def _every(key: str, own: tuple[Own, ...]) -> frozenset[str]:
    """What all tables list; an empty entry is one renderer's affair."""
    return frozenset(n for one in _tables(own).values() for n in one.get(key, ()) if n)


def choose(evidence: Evidence, own: tuple[Own, ...] = ()) -> tuple[Renderer, str]:
    """The renderer that left by far the most traces, and which; `any` where none did, or several."""
    if not any(_is_trace(kind, t, own) for kind in _TRACES for t, _ in _traces(evidence, kind)):
        return renderer(ANY, own), "no traces of a renderer"
    weighed = [(name, *_weigh(told, evidence)) for name, told in _telling(own)]
    most = max(weight for _, weight, _ in weighed)
    contenders = [(name, reason) for name, weight, reason in weighed if 2 * weight > most]
    if len(contenders) == 1:
        return renderer(contenders[0][0], own), contenders[0][1]
    names = tuple(name for name, _ in contenders)
    return _any_of(names, own), f"traces of {' and '.join(names)}, none by far the most"


_TRACES = {
    "namespaces": "properties in the namespace",
    "schemas": "applied schemas",
    "product-types": "productType",
    "camera-types": "cameras of type",
    "prim-names": "prims named",
    "layer-data": "layer data",
}
"""What an entry of `[evidence]` is called in a sentence."""


@cache
def _telling(own: tuple[Own, ...]) -> list[tuple[str, list[tuple[str, tuple[str, ...]]]]]:
    """For each renderer the patterns of each kind of trace, where there are any."""
    return [
        (name, [(kind, tuple(told[kind])) for kind in _TRACES if told.get(kind)])
        for name, table in _tables(own).items()
        if (told := table.get("evidence"))
    ]


@lru_cache(maxsize=4096)
def _is_trace(kind: str, name: str, own: tuple[Own, ...]) -> bool:
    """Whether any renderer goes by it: stages are full of names, the same ones over and over."""
    patterns = (p for _, told in _telling(own) for k, listed in told if k == kind for p in listed)
    return any(_fits(name, pattern) for pattern in patterns)


def _weigh(told: Iterable[tuple[str, tuple[str, ...]]], evidence: Evidence) -> tuple[int, str]:
    weight, said = 0, []
    for kind, patterns in told:
        found = [t for t in _traces(evidence, kind) if any(_fits(t[0], p) for p in patterns)]
        if found:
            weight += sum(count for _, count in found)
            said.append(f"{_TRACES[kind]} {', '.join(repr(name) for name, _ in found)}")
    return weight, "; ".join(said)


def _traces(evidence: Evidence, kind: str) -> Iterable[tuple[str, int]]:
    found: Iterable[str | tuple[str, int]] = getattr(evidence, kind.replace("-", "_"))
    return [(one, 1) if isinstance(one, str) else one for one in found]


def _fits(name: str, pattern: str) -> bool:
    head, star, tail = pattern.partition("*")
    if tail or "?" in head or "[" in head:
        return fnmatchcase(name, pattern)
    # Spares compiling a regular expression.
    return name.startswith(head) if star else name == pattern

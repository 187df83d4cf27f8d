r"""What does each renderer accept, and which one does a stage seem to be for?

One TOML file a renderer; `pytest --update` copies them to `tables.py`, which is what runs. What `any`
accepts, all accept. All keys but `title` are optional:

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
from typing import Any

from ..model import Evidence
from ..records import dataclass
from ..rule import Renderer, Severity
from .tables import BUILT_IN

ANY = "any"


@dataclass(frozen=True, slots=True)
class Own:
    """A renderer that a show adds to those of the package; its text is known to be one."""

    name: str
    text: str


@cache
def _tables(own: tuple[Own, ...]) -> dict[str, dict[str, Any]]:
    return dict(sorted({**BUILT_IN, **{one.name: _parsed(one.text) for one in own}}.items()))


def _parsed(text: str) -> dict[str, Any]:
    # With its patterns it takes 4 ms to import.
    import tomllib

    return tomllib.loads(text)


def names(own: tuple[Own, ...] = ()) -> list[str]:
    return sorted([*BUILT_IN, *(one.name for one in own)])


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
        is_any=name == ANY,
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
    traces: dict[str, dict[str, list[str]]] = {}
    weights: dict[str, int] = {}
    for kind in _TRACES:
        for trace, count in _traces(evidence, kind):
            for name in _left_by(kind, trace, own):
                traces.setdefault(name, {}).setdefault(kind, []).append(trace)
                weights[name] = weights.get(name, 0) + count
    if not weights:
        return renderer(ANY, own), "no traces of a renderer"
    most = max(weights.values())
    contenders = tuple(name for name in sorted(weights) if 2 * weights[name] > most)
    if len(contenders) > 1:
        said = f"traces of {' and '.join(contenders)}, none by far the most"
        return _any_of(contenders, own), said
    (name,) = contenders
    reasons = (f"{_TRACES[kind]} {_some(found)}" for kind, found in traces[name].items())
    return renderer(name, own), "; ".join(reasons)


def _some(names: list[str]) -> str:
    """Whoever doubts the choice looks one of them up; a stage may have dozens."""
    told = ", ".join(map(repr, names[:_SOME]))
    return f"{told} and {len(names) - _SOME} more" if len(names) > _SOME else told


_SOME = 3

_TRACES = {
    "namespaces": "properties in the namespace",
    "schemas": "applied schemas",
    "product-types": "productType",
    "camera-types": "cameras of type",
    "prim-names": "prims named",
    "layer-data": "layer data",
}
"""What an entry of `[evidence]` is called in a sentence."""


@lru_cache(maxsize=4096)
def _left_by(kind: str, trace: str, own: tuple[Own, ...]) -> tuple[str, ...]:
    """The renderers that go by it, mostly none: stages are full of names, the same over and over."""
    told = ((name, table.get("evidence", {})) for name, table in _tables(own).items())
    return tuple(name for name, by in told if any(_fits(trace, p) for p in by.get(kind, ())))


def _traces(evidence: Evidence, kind: str) -> Iterable[tuple[str, int]]:
    found: Iterable[str | tuple[str, int]] = getattr(evidence, kind.replace("-", "_"))
    return [(one, 1) if isinstance(one, str) else one for one in found]


def _fits(name: str, pattern: str) -> bool:
    head, star, tail = pattern.partition("*")
    if tail or "?" in head or "[" in head:
        return fnmatchcase(name, pattern)
    # Spares compiling a regular expression.
    return name.startswith(head) if star else name == pattern

"""Does an independent grammar see names and values in the same places as `usdrender_lint.usda`?

tree-sitter-usda reads the same texts; where it finds no error in one, every prim, property, value,
target and metadata entry has to stand where `UsdaText` says.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
import tree_sitter_usda
from pxr import Sdf
from tree_sitter import Language, Node, Parser

from conftest import ROOT
from usdrender_lint.results import Span
from usdrender_lint.usda import KEYWORDS, UsdaText

FIXTURES = ROOT / "fixtures"
CORPUS = ROOT.parent / "shared" / "corpus"
LARGE = 40_000
"""Bytes; of the corpus, files above are left out, to be done in two seconds."""

FIELD_OF_KEYWORD = {keyword: field for field, keyword in KEYWORDS.items()}
FIELD_OF_SUFFIX = {
    "": "default",
    "connect": "connectionPaths",
    "spline": "spline",
    "timeSamples": "timeSamples",
}


@dataclass(frozen=True)
class Place:
    """What stands where, by the other grammar."""

    path: str
    field: str | None
    target: str | None
    nodes: tuple[Node, ...]
    """From the one that is asked for to what stands for it if it goes over several lines."""


class Oracle:
    def __init__(self, data: bytes) -> None:
        self.data = data
        self.lines = data.decode("utf-8").split("\n")
        self.root = Parser(Language(tree_sitter_usda.language())).parse(data).root_node

    def text(self, node: Node) -> str:
        return self.data[node.start_byte : node.end_byte].decode("utf-8")

    def span(self, node: Node) -> Span | None:
        """None for what goes over several lines."""
        (row, start), (end_row, end) = node.start_point, node.end_point
        if row != end_row:
            return None
        line = self.lines[row].encode()
        return Span(row + 1, len(line[:start].decode()) + 1, len(line[:end].decode()) + 1)

    def expected(self, place: Place) -> Span | None:
        return next((s for n in place.nodes if (s := self.span(n))), None)

    def places(self) -> Iterator[Place]:
        yield from self.in_block(self.root, "", "/")

    def in_block(self, block: Node, path: str, owner: str) -> Iterator[Place]:
        """`path` in the layer's namespace, without the slash of the root; `owner` without variants."""
        for node in block.named_children:
            if node.type == "prim_definition":
                yield from self.prim(node, path, owner)
            elif node.type.startswith("attribute"):
                yield from self.attribute(node, path, owner)
            elif node.type.startswith("relationship"):
                yield from self.relationship(node, path, owner)
            elif node.type == "variant_set_definition":
                yield from self.variants(node, path, owner)
            elif node.type == "metadata" and not path:
                yield from self.metadata(node, "/", None)

    def prim(self, node: Node, above: str, owner: str) -> Iterator[Place]:
        name = child(node, "string")
        prim = self.text(name)[1:-1]
        path = f"{above}{'' if above.endswith('}') else '/'}{prim}"
        yield Place(path, None, None, (name,))
        yield Place(path, "specifier", None, (child(node, "prim_type"), name))
        kinds = [n for n in node.named_children if "identifier" in n.type]
        yield Place(path, "typeName", None, (*kinds[:1], name))
        yield from self.below(node, path, f"{owner.rstrip('/')}/{prim}", name)

    def variants(self, node: Node, path: str, owner: str) -> Iterator[Place]:
        variant_set = self.text(child(node, "string"))[1:-1]
        for variant in (n for n in node.named_children if n.type == "variant"):
            name = child(variant, "string")
            inner = f"{path}{{{variant_set}={self.text(name)[1:-1]}}}"
            yield Place(inner, None, None, (name,))
            yield from self.below(variant, inner, owner, name)

    def below(self, node: Node, path: str, owner: str, name: Node) -> Iterator[Place]:
        for part in node.named_children:
            if part.type == "metadata":
                yield from self.metadata(part, path, name)
            elif part.type == "block":
                yield from self.in_block(part, path, owner)

    def attribute(self, node: Node, above: str, owner: str) -> Iterator[Place]:
        name = next(n for n in node.named_children if "identifier" in n.type)
        path = f"{above}.{self.text(name)}"
        yield Place(path, None, None, (name,))
        yield Place(path, "typeName", None, (child(node, "attribute_type"), name))
        suffix = next(
            (self.text(n) for n in node.named_children if n.type == "attribute_property"), ""
        )
        value = value_of(node, name)
        if value is not None:
            yield Place(path, FIELD_OF_SUFFIX[suffix], None, (value, name))
            if suffix == "connect":
                yield from self.targets(value, path, "connectionPaths", owner)
        yield from self.own_metadata(node, path, name)

    def relationship(self, node: Node, above: str, owner: str) -> Iterator[Place]:
        name = next(n for n in node.named_children if "identifier" in n.type)
        path = f"{above}.{self.text(name)}"
        yield Place(path, None, None, (name,))
        value = value_of(node, name)
        if value is not None:
            yield Place(path, "targetPaths", None, (value, name))
            yield from self.targets(value, path, "targetPaths", owner)
        yield from self.own_metadata(node, path, name)

    def own_metadata(self, node: Node, path: str, name: Node) -> Iterator[Place]:
        for part in node.named_children:
            if part.type == "metadata":
                yield from self.metadata(part, path, name)

    def targets(self, value: Node, path: str, field: str, owner: str) -> Iterator[Place]:
        entries = [value, *value.named_children]
        for entry in (n for n in entries if n.type == "prim_path"):
            meant = Sdf.Path(self.text(entry)[1:-1]).MakeAbsolutePath(owner)
            yield Place(path, field, str(meant), (entry,))

    def metadata(self, node: Node, path: str, owner: Node | None) -> Iterator[Place]:
        for entry in (n for n in node.named_children if n.type == "metadata_assignment"):
            key = next(n for n in entry.named_children if "identifier" in n.type)
            field = FIELD_OF_KEYWORD.get(self.text(key), self.text(key))
            value = value_of(entry, key)
            if value is not None:
                yield Place(path, field, None, (value, key))


def child(node: Node, kind: str) -> Node:
    return next(n for n in node.named_children if n.type == kind)


def value_of(node: Node, name: Node) -> Node | None:
    """What follows the equals sign."""
    equals = next(
        (n for n in node.children if n.type == "=" and n.start_byte >= name.end_byte), None
    )
    behind = [n for n in node.children if equals and n.start_byte >= equals.end_byte]
    return next((n for n in behind if n.type not in ("comment", ";")), None)


def is_text(file: Path) -> bool:
    return file.is_file() and file.read_bytes().startswith(b"#usda")


def complaints(file: Path) -> tuple[list[str], int]:
    """Where the two differ, and how many places were compared."""
    data = file.read_bytes()
    try:
        oracle = Oracle(data)
    except UnicodeDecodeError:
        return [], 0
    if oracle.root.has_error:
        return [], 0
    text = UsdaText(data)
    wanted: dict[tuple[str, str | None, str | None], list[Span | None]] = {}
    for place in oracle.places():
        key = place.path, place.field, place.target
        wanted.setdefault(key, []).append(oracle.expected(place))
    wrong = [
        f"{key}: {span} is none of {spans}"
        for key, spans in wanted.items()
        if (span := text.span(*key)) not in spans
    ]
    return wrong, len(wanted)


def fixtures() -> list[Path]:
    found = [*FIXTURES.rglob("*.usda"), *FIXTURES.rglob("*.usd")]
    return sorted(f for f in found if is_text(f))


@pytest.mark.parametrize("file", fixtures(), ids=lambda f: f.relative_to(FIXTURES).as_posix())
def test_fixture(file: Path) -> None:
    assert complaints(file)[0] == []


def test_most_fixtures_are_compared() -> None:
    compared = [complaints(f)[1] for f in fixtures()]
    assert sum(bool(n) for n in compared) > len(compared) * 0.8
    assert sum(compared) > 1000


@pytest.mark.skipif(not CORPUS.is_dir(), reason="the corpus of real layers is not here")
def test_corpus() -> None:
    files = sorted(f for f in CORPUS.rglob("*.usd*") if is_text(f) and f.stat().st_size < LARGE)
    places = 0
    for file in files:
        wrong, compared = complaints(file)
        assert wrong == [], file
        places += compared
    assert places > 5000

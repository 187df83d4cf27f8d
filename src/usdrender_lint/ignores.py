"""Which suppressions are there for the findings of one file, whatever layers they stand in?"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cached_property
from os.path import commonprefix

from pxr import Sdf, Usd

from .discover import Shown
from .locate import Locator
from .model import Extent, Site
from .packages import split_package
from .read.suppressions import (
    KEY,
    Authored,
    authored_above,
    authored_in,
    authored_on_layer,
    is_composed,
)
from .read.text import Texts
from .results import Located, Location
from .suppress import MARK, Ignore, Key, in_comment, in_metadata, judge
from .usda import UsdaText

_WORD = commonprefix([MARK, KEY]).encode()  # noqa: RUF071 it goes by letters
"""A text that does not hold it says nothing to this program."""


class Ignores:
    """Judges the findings of all openings of one file, and keeps what this tells of suppressions."""

    def __init__(self, texts: Texts, shown: Shown) -> None:
        self._texts = texts
        self._shown = shown
        self._comments: dict[str, tuple[Ignore, ...]] = {}
        self._by_line: dict[str, dict[int | None, list[Ignore]]] = {}
        self._opening: _Opening | None = None
        self._silencing: set[Key] = set()
        self._unseen: set[Key] | None = None
        self.own: tuple[Ignore, ...] = ()
        """All of the root layer, if they were asked for."""

    @property
    def needed(self) -> frozenset[Key]:
        """Those that silenced something, or may in a variant that was never selected."""
        return frozenset(self._silencing | (self._unseen or set()))

    def enter(self, stage: Usd.Stage, locator: Locator, own: Sdf.Layer | None) -> None:
        """Findings of this stage follow; `own`: the root layer, to learn all that it holds."""
        self._opening = _Opening(stage, locator, self._texts)
        if own is not None:
            if self._unseen is None and self._texts.mention(own.realPath, _WORD) is not False:
                self.own = (
                    *self._in_text(self._texts.file_of(own)),
                    *self._opening.of_layer(own, self._texts.of(own)),
                )
            unseen = self._opening.unseen(self.own)
            self._unseen = unseen if self._unseen is None else self._unseen & unseen

    def enter_text(self, file: str) -> None:
        """The root layer gives no stage, and what follows is about its text."""
        self.own = self._in_text(self._texts.full_name(file))

    def judge(self, finding: Located) -> Located:
        judged, silencing = judge(finding, self._for(finding))
        self._silencing |= silencing
        return judged

    def _for(self, finding: Located) -> Iterator[Ignore]:
        file, span = _full_name(finding.location), finding.location.span
        yield from self._about(file, None)
        if span is not None:
            yield from self._about(file, span.line)
        if self._opening is not None:
            yield from self._opening.in_metadata(finding)

    def _in_text(self, file: str) -> tuple[Ignore, ...]:
        if file not in self._comments:
            self._comments[file] = tuple(self._read(file))
        return self._comments[file]

    def _about(self, file: str, line: int | None) -> list[Ignore]:
        """The comments about a line; None: about the file."""
        if file not in self._by_line:
            by_line = self._by_line.setdefault(file, {})
            for ignore in self._in_text(file):
                whole = ignore.said.extent is Extent.LAYER
                for number in (None,) if whole else ignore.lines:
                    by_line.setdefault(number, []).append(ignore)
        return self._by_line[file].get(line, [])

    def _read(self, file: str) -> Iterator[Ignore]:
        text = self._texts.of_file(file) if self._texts.mention(file, _WORD) else None
        if text is None:
            return
        for comment in text.comments(MARK.encode()):
            source = text.line(comment.line)
            for said, span, lines in in_comment(comment, file):
                at = Location(*self._located(file), span, source)
                yield Ignore(said, at, lines)

    def _located(self, file: str) -> tuple[str, str, str | None]:
        package, member = split_package(file)
        return package, self._shown(package), member


class _Opening:
    """The metadata of one stage."""

    def __init__(self, stage: Usd.Stage, locator: Locator, texts: Texts) -> None:
        self._stage = stage
        self._texts = texts
        self._locator = locator
        self._of_layers: dict[str, tuple[Ignore, ...]] = {}
        self._above: dict[str, tuple[Ignore, ...]] = {}

    @cached_property
    def _layers(self) -> dict[str, Sdf.Layer]:
        used = self._stage.GetUsedLayers()
        return {self._texts.file_of(layer): layer for layer in used}

    @cached_property
    def _is_silent(self) -> bool:
        """There is nothing but the root layer, and its text is without the word."""
        root = self._stage.GetRootLayer()
        return (
            all(layer == root or layer.anonymous for layer in self._stage.GetUsedLayers())
            and self._texts.mention(root.realPath, _WORD) is False
        )

    def in_metadata(self, finding: Located) -> Iterator[Ignore]:
        if self._is_silent:
            return
        at = finding.location
        name = _full_name(at)
        if name not in self._of_layers:
            layer = self._layers.get(name)
            found = authored_on_layer(layer) if layer is not None else ()
            self._of_layers[name] = tuple(self._placed(found))
        yield from self._of_layers[name]
        path = finding.prim_path
        path = f"{path}.{finding.property}" if finding.property else path
        if path not in self._above:
            self._above[path] = tuple(self._placed(authored_above(self._stage, path)))
        yield from self._above[path]

    def of_layer(self, layer: Sdf.Layer, text: UsdaText | None) -> Iterator[Ignore]:
        return self._placed(authored_in(layer, text))

    def unseen(self, own: Iterable[Ignore]) -> set[Key]:
        """Those of the root layer that stand in a variant which is not selected."""
        specs = ((ignore, ignore.said.site.spec or "") for ignore in own)
        return {i.key for i, spec in specs if "{" in spec and not is_composed(self._stage, spec)}

    def _placed(self, found: Iterable[Authored]) -> Iterator[Ignore]:
        for one in found:
            path = str(Sdf.Path(one.spec).StripAllVariantSelections())
            site = Site(path, one.field, layer=one.layer, spec=one.spec)
            for said in in_metadata(site, _extent(one.spec), one.key, one.names):
                yield Ignore(said, self._locator.location(said.site), reaches=one.reaches)


def _full_name(at: Location) -> str:
    return f"{at.file}[{at.member}]" if at.member else at.file


def _extent(spec: str) -> Extent:
    if spec == "/":
        return Extent.LAYER
    return Extent.PROPERTY if Sdf.Path(spec).IsPropertyPath() else Extent.PRIM

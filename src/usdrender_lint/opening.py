"""Does a file open as a layer, and if not, why not? In a sentence for the one who wrote it."""

from __future__ import annotations

import os
import re
import stat
from collections import Counter
from collections.abc import Callable, Iterable
from contextlib import suppress
from itertools import islice

from pxr import Sdf, Tf

from .crate import mentions
from .diagnostics import sentences
from .discover import USD_SUFFIXES
from .handed import bytes_at
from .lazily import lazily
from .model import Site
from .packages import bytes_of, first_member, split_package
from .records import dataclass
from .unread import closing, samples, statement, string
from .usda_lines import Lines

_FOLDER = "a folder"
_SMALL, _SMALL_CRATE = 1_000_000, 100_000
"""Bytes of a layer in which all asset paths are found in no time."""
_ARCS = (b"references", b"payload")
_CROWD = 16
"""Files in one folder that are looked at as one."""

_LFS = b"version https://git-lfs.github.com/spec/v1"
_HEADER = lazily(rb"#(?:usda|sdf)\b")
_EMPTY = "the file is empty"
_UTF16 = (b"\xff\xfe", b"\xfe\xff", b"#\0", b"\0#")
"""With its mark, or the first letter of a header without one."""
_CRATE, _PACKAGE, _EMPTY_PACKAGE = b"PXR-USDC", b"PK\x03\x04", b"PK\x05\x06"


@dataclass(frozen=True, slots=True)
class ParseProblem:
    """Why the text of a layer is no usda. `column` counts bytes from 1, as USD does; 0 where only an
    expression is known to be wrong and its place has to be found in the text."""

    file: str
    message: str
    line: int = 0
    column: int = 0
    spec: str | None = None
    """The property that cannot be read, where no line is told."""
    asked: Site | None = None
    """The arc that brings the layer in; of a root layer there is none."""


@dataclass(frozen=True, slots=True)
class Unreadable:
    """Why a file is no layer at all. Not a finding: nothing of it could be looked at."""

    file: str
    kind: str
    message: str
    asked_by: str | None = None
    """File of the layer that brings it in."""


class DamagedError(Exception):
    """A layer opens, and what it holds does not hang together: a spec is listed and not there."""


def look(file: str) -> Unreadable | None:
    """What the first bytes tell before USD is asked; its own messages differ by extension."""
    if not file.isascii() and file.encode(errors="replace").decode() != file:
        return Unreadable(file, "unreadable-file", "its name is not UTF-8, which USD needs")
    at = bytes_at(file)
    try:
        if what := _no_file(os.stat(at).st_mode):
            return Unreadable(file, "unreadable-file", f"{what}, not a file")
        with open(at, "rb", buffering=0) as stream:
            head = stream.read(1024)
    except OSError as error:
        return _cannot_be_read(file, error)
    if not head:
        return Unreadable(file, "unreadable-file", _EMPTY)
    if head.startswith(_LFS):
        return Unreadable(
            file, "lfs-pointer", "a Git LFS pointer, not the file itself: run `git lfs pull`"
        )
    if head.startswith(b"\xef\xbb\xbf"):
        return Unreadable(
            file,
            "unreadable-file",
            "begins with a UTF-8 byte order mark, which USD refuses: save it as UTF-8 without BOM",
        )
    if head.startswith(_UTF16):
        said = "UTF-16 text, which USD refuses: save it as UTF-8 without BOM"
        return Unreadable(file, "unreadable-file", said)
    if head.startswith(_EMPTY_PACKAGE):
        return Unreadable(file, "unreadable-file", "a zip package without a file in it")
    if at != file and head.startswith(_PACKAGE):
        said = "a package cannot be linted from standard input"
        return Unreadable(file, "unreadable-file", said)
    return _wrong_format(file, head)


def _cannot_be_read(file: str, error: OSError) -> Unreadable:
    reason = (error.strerror or str(error)).lower()
    return Unreadable(file, "unreadable-file", f"cannot be read: {reason}")


def _no_file(mode: int) -> str | None:
    """What stands where a file should. Opening a pipe is waiting for somebody who writes into it;
    a device may have no end, or do something."""
    if stat.S_ISREG(mode):
        return None
    kinds = {stat.S_IFDIR: _FOLDER, stat.S_IFIFO: "a named pipe", stat.S_IFSOCK: "a socket"}
    return kinds.get(stat.S_IFMT(mode), "a device")


def sublayers_of(
    layer: Sdf.Layer,
    look_through: Callable[[Sdf.Layer], None],
    mention: Callable[[str, bytes], bool | None],
) -> tuple[list[Sdf.Layer], Unreadable | None]:
    """All layers below, to be held until the stage is open, which needs them, too; and a pipe or
    device that is brought in, for which USD would wait forever.

    `look_through` raises for a crate that lists what is not there: asked for the arcs of such a one,
    USD ends the process. `mention` tells whether the text of a layer holds a word.

    What lies behind references is not looked at: it is opened only where the render spec needs it.
    """
    held, known = [layer], {layer.identifier}
    for one in held:
        all_assets = _brought_in(one, look_through, mention)
        if not (all_assets or one.subLayerPaths):
            continue
        sublayers = {one.ComputeAbsolutePath(name) for name in one.subLayerPaths}
        new = sublayers.union(map(one.ComputeAbsolutePath, all_assets)) - known
        known |= new
        for file in sorted(new - (_plain_files(new) - sublayers)):
            try:
                what = _no_file(os.stat(file).st_mode)
            except (OSError, ValueError):  # told where it is missed
                continue
            if what not in (None, _FOLDER):
                return held, Unreadable(
                    file, "unreadable-file", f"{what}, not a file", one.realPath
                )
            if file in sublayers:
                with suppress(Tf.ErrorException):
                    if found := Sdf.Layer.FindOrOpen(file):
                        held.append(found)
    return held, None


def _plain_files(files: Iterable[str]) -> set[str]:
    """Those that are nothing else, as far as many of them stand in one folder: to list it takes less
    than to ask for each."""
    by_folder = Counter(file.rpartition("/")[0] for file in files)
    plain: set[str] = set()
    for folder, number in by_folder.items():
        if number >= _CROWD:
            with suppress(OSError, ValueError), os.scandir(folder) as entries:
                few = islice(entries, 4 * number)  # there may be a hundred times as many
                # Not as the entry spells its path, which is another way on Windows.
                plain.update(f"{folder}/{e.name}" for e in few if e.is_file(follow_symlinks=False))
    return plain


def _brought_in(
    layer: Sdf.Layer,
    look_through: Callable[[Sdf.Layer], None],
    mention: Callable[[str, bytes], bool | None],
) -> list[str]:
    """What a small layer names in its arcs."""
    file = bytes_at(layer.realPath)
    is_text = file.endswith(".usda")
    try:
        size = os.stat(file).st_size
    except OSError:
        return []
    if size >= (_SMALL if is_text else _SMALL_CRATE):
        return []
    if is_text:
        if mention(layer.realPath, b"@") is False:
            return []
    else:
        if mentions(file, _ARCS) is False:
            return []
        look_through(layer)
    return list(layer.GetCompositionAssetDependencies())


def _wrong_format(file: str, head: bytes) -> Unreadable | None:
    suffix = os.path.splitext(file)[1].lower()
    is_crate, is_package = head.startswith(_CRATE), head.startswith(_PACKAGE)
    expected = {
        ".usd": not is_package,
        ".usda": not (is_crate or is_package),
        ".usdc": is_crate,
        ".usdz": is_package,
    }
    if not expected.get(suffix, True):
        found = (
            "a binary crate"
            if is_crate
            else "a zip package"
            if is_package
            else "usda text"
            if _HEADER.match(head)
            else "something else"
        )
        return Unreadable(
            file, "unreadable-file", f"named {suffix}, but holds {found}: USD opens it by its name"
        )
    if not (is_crate or is_package) and b"\0" in head:
        return Unreadable(file, "unreadable-file", "binary data that is not USD")
    return None


def open_layer(file: str) -> Sdf.Layer | Unreadable | ParseProblem:
    """The layer, or why there is none."""
    if found := look(file):
        return found
    try:
        instead = bytes_at(file)
        layer = Sdf.Layer.FindOrOpen(file) if instead == file else _in_memory(file, instead)
    except Tf.ErrorException as error:
        return _refused(file, error)
    return Unreadable(file, "unreadable-file", _missing_in(file)) if layer is None else layer


def _in_memory(file: str, instead: str) -> Sdf.Layer | None:
    """What `instead` holds, under the name of `file`."""
    if found := Sdf.Layer.Find(file):
        return found
    read = Sdf.Layer.OpenAsAnonymous(instead)
    if read is None:
        return None
    layer = Sdf.Layer.New(read.GetFileFormat(), file)
    layer.TransferContent(read)
    return layer


def open_member(name: str) -> Sdf.Layer | Unreadable | ParseProblem:
    """A layer inside a package, or why there is none. `name` is `package.usdz[member]`."""
    try:
        if layer := Sdf.Layer.FindOrOpen(name):
            return layer
    except Tf.ErrorException as error:
        return _refused(name, error)
    return Unreadable(name, "unreadable-file", "USD cannot open this member of the package")


def _missing_in(file: str) -> str:
    """Why USD finds nothing, and has no words for it."""
    if not file.lower().endswith(".usdz"):
        return "USD finds nothing of USD in it"
    if first := first_member(file, None):
        said = f"its first file is '{first}', and USD opens no other: put the root layer first"
        return (
            said if not first.lower().endswith(USD_SUFFIXES) else f"USD cannot open '{first}' in it"
        )
    return "the package is truncated or damaged"


_AT = lazily(r":(\d+):(\d+): (.*)", re.S)
_NEAR = lazily(r"(.*) at '(.*?)' in <(.*)>", re.S)
_OF_PROPERTY = lazily(r"(.*?) at '.*' in <(/.*\..*)>", re.S)
_COMPONENTS = lazily(r"Tuple dimensions error for attribute of type ([\w\[\]]+)")
_QUOTING = lazily(r" due to ':\d+:\d+: .*?'")
_PACKED = lazily(r"Cannot open (.+) in .+: (\w+) files are not supported", re.DOTALL)
_RULES = {
    "::RightAngleBracket": "expected a path and >",
    "_PathParser::": "this is no path",
    "::ListValueClose": "expected a comma or ]",
    "::TimeSampleMap": "these are no time samples, each of which is written as time: value",
    "Expected ]": "expected a comma or ]",
    "Type name has [] for non-shaped value": "the type is an array, and the value has no brackets",
    "Duplicate items exist for field 'targetPaths'": "a target stands twice in the list",
    " for dictionary": "an entry of a dictionary is written as type name = value",
}
"""What to say for a sentence of USD that holds this."""
_LIST_OF_ASSETS = lazily(rb"\b(?:subLayers|references|payload)\s*=\s*\[[^\[\]]*\Z")
_CONFLICT = ("<<<<<<<", "=======", ">>>>>>>")
_QUOTED = lazily(r"\"[^\"]*\"|'[^']*'")
_STRANGE = {
    "\u201c": "a curly quote",
    "\u201d": "a curly quote",
    "\u00a0": "a no-break space",
    "\ufeff": "a byte order mark",
}
"""What editors and chats put into text, and nobody sees."""
_EXPRESSION = lazily(r"Ill-formed path expression|<input>:1:\d+: parse error")
"""Before 26.11 USD tells of a line, but it is that of the expression alone."""


def _refused(file: str, error: Tf.ErrorException) -> Unreadable | ParseProblem:
    try:
        return _why_not(file, sentences(error.args))
    except OSError as gone:  # since it was looked at
        return _cannot_be_read(file, gone)


def _why_not(file: str, said: list[str]) -> Unreadable | ParseProblem:
    """USD's sentences hold C++ names and temporary paths: the facts in them, in other words."""
    if problem := _not_parsed(file, said):
        return problem
    for text in said:
        if match := _PACKED.search(text):
            told = f"'{match[1]}' in it is {match[2]}, and USD reads no such file in a package"
            return Unreadable(split_package(file)[0], "unreadable-file", told)
    data, inside = _text_in(file)
    if data is not None:
        return _wrong_text(file, data, said) if data else _nothing(file, inside)
    detail = "truncated or damaged"
    for text in said:
        if "version" in text.lower():
            detail = "written by a version of USD that this one does not read"
    told = f"USD cannot open '{inside}' in it" if inside else "USD cannot open it"
    return Unreadable(file, "unreadable-file", f"{told}: {detail}")


def _nothing(file: str, inside: str) -> Unreadable:
    return Unreadable(file, "unreadable-file", f"'{inside}' in it is empty" if inside else _EMPTY)


def _wrong_text(file: str, data: bytes, said: list[str]) -> ParseProblem:
    for text in said:
        if _EXPRESSION.search(text):  # mostly it is found in the text, and told with its place
            told = "a path expression in it is ill-formed, and USD does not say which"
            return ParseProblem(file, told, 1, 1)
        if match := _OF_PROPERTY.fullmatch(text.strip()):
            return ParseProblem(file, _sentence(match[1], ""), spec=match[2])
    if not data.startswith(b"#usda"):
        return ParseProblem(file, "the first line is not '#usda 1.0'", 1, 1)
    told = "USD cannot read this, and does not say where it stops"
    return _not_utf8(file, data) or ParseProblem(file, told, 1, 1)


def _not_parsed(file: str, said: list[str]) -> ParseProblem | None:
    """What a parser says of a place in the file. It may quote another one, which counted the lines of
    a single value."""
    of_text = (text for text in said if not _EXPRESSION.search(text))
    places = list(filter(None, map(_AT.search, of_text)))
    name = os.path.basename(bytes_at(file))  # as USD knows it
    named = (m for m in places if m.string[: m.start()].endswith(name))
    match = next(named, None) or next(iter(places), None)
    if match is None:
        return None
    is_here = name in match.string[: match.start()]
    what = _QUOTING.sub("", match[3].strip())
    near = _NEAR.fullmatch(what)
    expected, found = (near[1], near[2]) if near else (what, "")
    data = _text_in(file)[0] if is_here else None
    at = _offset(data, int(match[1]), int(match[2])) if data else -1
    if data and at >= 0 and (wrong := _wrong_at(data, at, expected, found)):
        return ParseProblem(file, _strange(wrong[0], found), *_place(data, wrong[1]))
    told = _sentence(_more_exact(said) or expected, found)
    place = _place(data, at) if data and at >= 0 else (int(match[1]), int(match[2]))
    return ParseProblem(file, told, *place)


def _offset(data: bytes, line: int, column: int) -> int:
    """-1 if there is no such line."""
    start = 0
    for _ in range(line - 1):
        start = data.find(b"\n", start) + 1
        if not start:
            return -1
    return min(start + column - 1, len(data))


def _place(data: bytes, at: int) -> tuple[int, int]:
    """As editors count, for which a carriage return ends a line, too."""
    line, start = Lines(data).at(at)
    return line, at - start + 1


def _wrong_at(data: bytes, at: int, expected: str, found: str) -> tuple[str, int] | None:
    """What the text tells where USD only names a rule of its parser, or the end of what it is in."""
    expected = expected.strip()
    if found.startswith(_CONFLICT):
        return None
    if "until<" in expected:
        what = "an asset path" if "::At," in expected else "a string"
        return f"{what} is not closed", string(data, at)
    if expected == "Expected }" or "internal::eof" in expected:
        return statement(data, at)
    if "::TimeSampleMap" in expected:
        begin = data.rfind(b"\n", 0, at) + 1
        begin += len(data[begin:at]) - len(data[begin:at].lstrip())
        return samples(data, at) if data[at : at + 1] == b"{" else statement(data, begin)
    if expected == "Expected ]" and found[:1] in "\"'" and _LIST_OF_ASSETS.search(data[:at]):
        return "an asset stands between two @, as in @layer.usda@", at
    if expected in ("Expected ]", "Expected )") and (told := closing(data, at, expected[-1])):
        words = found.split()  # none of a form feed
        return f"{told}, found '{words[0][:40]}'" if words else told, at
    return None


def _more_exact(said: list[str]) -> str | None:
    """A sentence before the one that tells the place may say why."""
    if any("Not enough values" in one for one in said):
        if match := next(filter(None, map(_COMPONENTS.search, said)), None):
            return match[0]
        return "the value has fewer components than its type"
    return None


def _sentence(expected: str, near: str) -> str:
    expected = expected.strip()
    # USD quotes the rest of the line; the first word of it is what it stumbled over.
    word = next(iter(near.split()), "")
    if word.startswith(_CONFLICT):
        return f"a merge conflict is left here, found '{word[:40]}'"
    rules = ((words, rule) for rule, words in _RULES.items() if rule in expected)
    expected = next((words for words, _ in rules), expected)
    if "::" in expected or "pxrInternal" in expected:  # a rule of the parser, by its C++ name
        expected = "this is no usda"
    if "simple value" in expected:
        expected = "expected a value of another type"
    if match := _COMPONENTS.search(expected):
        expected = f"the value has not as many components as its type, {match[1]}"
    if "target paths cannot contain variant selections" in expected:
        # USD makes a relative path absolute, and then takes offence at what it made.
        return "a target can neither hold a variant selection nor, within a variant, be relative"
    expected = (expected[:1].lower() + expected[1:]).rstrip(".")
    found = "found" if expected.startswith(("expected", "this", "the ")) else "near"
    told = f"{expected}, {found} '{word[:40]}'" if word not in ("", "=") else expected
    return _strange(told, near)


def _strange(told: str, line: str) -> str:
    strange = next((what for c, what in _STRANGE.items() if c in _QUOTED.sub("", line)), "")
    return f"{told}: the line holds {strange}" if strange else told


def _not_utf8(file: str, data: bytes) -> ParseProblem | None:
    """Where text holds a byte that is no UTF-8: USD's own sentence about it cannot be read."""
    try:
        data.decode()
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        column = error.start - data.rfind(b"\n", 0, error.start)
        return ParseProblem(file, "the text is not UTF-8 from here on", line, column)
    return None


def _text_in(name: str) -> tuple[bytes | None, str]:
    """The text that USD tried to read, None if it is binary; and where it stands in the package
    that was to be opened, which is its first member."""
    file, member = split_package(name)
    inside = ""
    if file.lower().endswith(".usdz") and member is None:
        member = inside = first_member(file, None) or ""
    with open(bytes_at(file), "rb") as stream:
        data = bytes_of(stream, member) if member else stream.read()
    binary = data is None or b"\0" in data[:1024] or data.startswith((_CRATE, _PACKAGE))
    return None if binary else data, inside

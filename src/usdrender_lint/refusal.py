"""Why does USD refuse a file?

Its sentences hold C++ names and temporary paths: here are the facts in them, in other words.
"""

from __future__ import annotations

import re
from pathlib import Path

from . import crate, packages
from .discover import USD_SUFFIXES
from .handed import bytes_at
from .heads import EMPTY, LFS, POINTER, why_no_layer
from .lazily import lazily
from .unopened import ParseProblem, Unreadable
from .usda.lines import Lines
from .usda.unread import closing, samples, statement, string

_AT = lazily(r":(\d+):(\d+): (.*)", re.S)
_NEAR = lazily(r"(.*) at '(.*?)' in <(.*)>", re.S)
_OF_PROPERTY = lazily(r"(.*?) at '.*' in <(/.*\..*)>", re.S)
_COMPONENTS = lazily(r"Tuple dimensions error for attribute of type ([\w\[\]]+)")
_MISFIT = lazily(r"Error parsing (?:tuple|shaped) value: Failed to parse(?: at element (\d+))?")
_VARIABILITY = lazily(r"[Aa]ttribute ('.*') already has variability")
_VERSION = lazily(r"layer version|layer header", re.I)
_KNOWN_VERSION = lazily(
    r"version '([\d.]+)'\. The (minimum|maximum) supported version is '([\d.]+)'"
)
_CONTROL_IN_ASSET = lazily(rb"@[^@\r\n]*?([\x00-\x08\x0b\x0c\x0e-\x1f\x7f])")
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
    "Type name missing [] for shaped value": "the value is a list, and its type has no brackets",
    "nsupported spline value type": "a spline holds single numbers, and none of this type",
    "asset path must not be empty": "an asset path is empty: for a prim of this layer leave the @@ out",
}
"""What to say for a sentence of USD that holds this."""
_LIST_OF_ASSETS = lazily(rb"\b(?:subLayers|references|payload)\s*=\s*\[[^\[\]]*\Z")
_NO_HEADER = "the first line is not '#usda 1.0'"
_SUFFIXES = tuple(suffix.encode() for suffix in USD_SUFFIXES)
_CONFLICT = ("<<<<<<<", "=======", ">>>>>>>")
_QUOTED = lazily(r"\"[^\"]*\"|'[^']*'")
_STRANGE = {
    "\u201c": "a curly quote",
    "\u201d": "a curly quote",
    "\u00a0": "a no-break space",
    "\ufeff": "a byte order mark",
    "\u200b": "a zero-width space",
}
"""What editors and chats put into text, and nobody sees."""
_EXPRESSION = lazily(r"Ill-formed path expression|<input>:1:\d+: parse error")
"""Before 26.11 USD tells of a line, but it is that of the expression alone."""


def why_not(file: str, said: list[str]) -> Unreadable | ParseProblem:
    """From what USD said of the file."""
    if problem := _not_parsed(file, said):
        return problem
    for text in said:
        if match := _PACKED.search(text):
            told = f"'{match[1]}' in it is {match[2]}, and USD reads no such file in a package"
            return Unreadable(packages.split_package(file)[0], "unreadable-file", told)
    if why := of_member(file):
        return why
    data, inside = _text_in(file)
    if data is not None:
        return _wrong_text(file, data, said) if data else _nothing(file, inside)
    detail = "truncated or damaged"
    for text in said:
        if "version" in text.lower():
            detail = "written by a version of USD that this one does not read"
    told = f"USD cannot open '{inside}' in it" if inside else "USD cannot open it"
    return Unreadable(file, "unreadable-file", f"{told}: {detail}")


def of_member(name: str) -> Unreadable | None:
    """What keeps USD from a member of a package, which it opens by name as it does a file."""
    file, member = packages.split_package(name)
    if not file.lower().endswith(".usdz"):
        return None
    if member is None and (why := packages.unread(file)):
        return Unreadable(file, "unreadable-file", why)
    inside = member or packages.first_member(file, None) or ""
    plain = inside.rstrip("]")
    with Path(bytes_at(file)).open("rb") as stream:
        head = (packages.bytes_of(stream, inside) or b"")[:1024]
    if not head or not plain.lower().endswith(USD_SUFFIXES):
        return None
    what = POINTER if head.startswith(LFS) else why_no_layer(plain, head)
    return Unreadable(file, "unreadable-file", f"'{inside}' in it: {what}") if what else None


def _nothing(file: str, inside: str) -> Unreadable:
    return Unreadable(file, "unreadable-file", f"'{inside}' in it is empty" if inside else EMPTY)


def _wrong_text(file: str, data: bytes, said: list[str]) -> ParseProblem:
    for text in said:
        if _EXPRESSION.search(text):  # mostly it is found in the text, and told with its place
            told = "a path expression in it is ill-formed, and USD does not say which"
            return ParseProblem(file, told, 1, 1)
        if "control character" in text and (control := _CONTROL_IN_ASSET.search(data)):
            told = "an asset path holds a control character"
            return ParseProblem(file, told, *_place(data, control.start(1)))
        if match := _OF_PROPERTY.fullmatch(text.strip()):
            return ParseProblem(file, _sentence(match[1], ""), spec=match[2])
    if not data.startswith(b"#usda"):
        return ParseProblem(file, _no_header(data), 1, 1)
    told = "USD cannot read this, and does not say where it stops"
    return _not_utf8(file, data) or ParseProblem(file, told, 1, 1)


def _no_header(data: bytes) -> str:
    conflict = next((one for one in _CONFLICT if data.startswith(one.encode())), None)
    if conflict:
        return _sentence("", conflict)
    only = data.strip().lower()
    if only.endswith(_SUFFIXES) and len(only.split()) == 1:
        return "it holds the path of another file: a symbolic link that was checked out as text"
    return _NO_HEADER


def _not_parsed(file: str, said: list[str]) -> ParseProblem | None:
    """What a parser says of a place in the file. It may quote another one, which counted the lines of
    a single value."""
    of_text = (text for text in said if not _EXPRESSION.search(text))
    places = list(filter(None, map(_AT.search, of_text)))
    name = Path(bytes_at(file)).name  # as USD knows it
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
    if _VERSION.search(expected):
        return _header(data, expected), 0
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


def _header(data: bytes, said: str) -> str:
    """What is wrong with the first line."""
    if match := _KNOWN_VERSION.search(said):
        bound = "older" if match[2] == "minimum" else "later"
        return f"it is written for usda {match[1]}, and USD reads none {bound} than {match[3]}"
    if b"\r" in data[:80] and b"\n" not in data:
        return "its lines end in carriage returns alone, which USD does not know: save it with line feeds"
    return _NO_HEADER


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
    if match := _MISFIT.match(expected):
        which = f"element {int(match[1]) + 1} of the value" if match[1] else "a number in the value"
        expected = f"{which} does not fit its type"
    if match := _VARIABILITY.match(expected):
        expected = f"the attribute {match[1]} is declared twice, once as uniform and once not"
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
    file, member = packages.split_package(name)
    inside = ""
    if file.lower().endswith(".usdz") and member is None:
        member = inside = packages.first_member(file, None) or ""
    with Path(bytes_at(file)).open("rb") as stream:
        data = packages.bytes_of(stream, member) if member else stream.read()
    binary = data is None or b"\0" in data[:1024] or data.startswith((crate.MAGIC, packages.MAGIC))
    return None if binary else data, inside

"""What is wrong with the usda text at which USD stops reading?

USD tells what it would have read next, and mostly that is the brace behind a statement which it
cannot read. What is wrong with the statement stands in its text.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from ..lazily import lazily
from ..likeness import most_alike

Wrong = tuple[str, int]
"""A sentence, and the byte that it is about."""

_OPERATIONS = (b"add", b"append", b"delete", b"prepend", b"reorder")
_VARIABILITIES = (b"config", b"uniform", b"varying")
_MODIFIERS = (*_OPERATIONS, b"custom", *_VARIABILITIES)
_SPECIFIERS = (b"class", b"def", b"over")
_KEYWORDS = tuple(one.decode() for one in (*_MODIFIERS, *_SPECIFIERS, b"rel", b"variantSet"))
_CLOSES = {b"}": b"{", b"]": b"[", b")": b"("}
_ALIKE = 0.6
_TYPE = lazily(
    rb"bool|string|token|asset|opaque|group|timecode|duration|pathExpression"
    rb"|uchar|u?int(?:64)?|int[234]|(?:half|float|double)[234]?|(?:color|point|vector|normal|texCoord)[234][hfd]|quat[hfd]"
    rb"|matrix[234]d|frame4d"
)

_STRING = rb'"(?:[^"\\\r\n]|\\.)*"' + rb"|'(?:[^'\\\r\n]|\\.)*'"
_WORD = rb"[A-Za-z_\x80-\xff][\w:\x80-\xff]*"
_TOKEN = lazily(_STRING + rb"|" + _WORD + rb"|\[[ \t]*\]|\S")
_MARK = lazily(
    rb'"""(?:[^"\\]++|\\.|"(?!""))*+"""' + rb"|'''(?:[^'\\]++|\\.|'(?!''))*+'''"
    rb"|(?!\"\"\"|''')(?:" + _STRING + rb")|@@@(?:[^@\r\n]|@(?!@@))*+@@@+|(?!@@@)@[^@\r\n]*@"
    rb"|#[^\r\n]*|//[^\r\n]*|/\*.*?\*/|[({\[\])}]|(?P<open>\"\"\"|'''|@@@|[\"'@]|/\*)",
    re.S,
)
_NUMBER = lazily(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_REST = lazily(rb"[\w.]*")
"""Of a word or a number."""
_VALUE = lazily(rb"(?!\"\"\"|''')" + rb"(?:" + _STRING + rb"|[-+]?[\w.]+)")
_TARGET = lazily(rb"<[^<>\r\n]*>")
_PADDING = lazily(rb"(?:[ \t]|/\*.*?\*/)*+", re.S)
_CURLY = lazily(rb"\xe2\x80[\x98-\x9f]")
_BLANKS = lazily(rb"(?:\s|;|#[^\r\n]*|//[^\r\n]*|/\*.*?\*/)*+", re.S)


def statement(data: bytes, at: int) -> Wrong:
    """Why a statement is none. It begins at a byte, where USD expects the end of what is around it."""
    if data[at : at + 1] in (b"\v", b"\f", b"\x1a"):
        return f"'\\x{data[at]:02x}' stands here, a control character that is no blank to USD", at
    tokens = list(_TOKEN.finditer(data, at, _line_end(data, at)))
    if not tokens:
        opened = _left_open(data, at, b"}")
        return ("this { is not closed", opened[1]) if opened else ("something is missing here", at)
    first = tokens[0][0]
    curly = next((one for one in tokens if not _is_string(one) and _CURLY.search(one[0])), None)
    if curly:
        return 'quotes are straight, as in "name"', curly.start()
    if data.startswith(b"/*", at):
        return "a comment is not closed", at
    if first in _CLOSES:
        return f"nothing is open that '{first.decode()}' closes", at
    if first in _SPECIFIERS:
        return _prim(data, tokens) or _unclosed(data, tokens[0]) or _unknown(data, at)
    return _property(data, tokens) or _unknown(data, at)


def closing(data: bytes, at: int, mark: str) -> str | None:
    """Which bracket USD wants to be closed, if it stands on a line above."""
    found = _left_open(data, at, mark.encode())
    if not found or not data.count(b"\n", found[1], at):
        return None
    comma = mark == "]" and data[:at].rstrip()[-1:] not in (b"[", b",")
    return f"expected a comma, or {found[0]}" if comma else f"expected {found[0]}"


def string(data: bytes, at: int) -> int:
    """Where the string or asset path begins that is not closed."""
    opened = (m.start() for m in _MARK.finditer(data, 0, at) if m["open"])
    return next(opened, at)


def samples(data: bytes, at: int) -> Wrong | None:
    """Which of some time samples is none. At a byte they begin, with a brace."""
    while (at := _after(data, at + 1)) < len(data) and data[at] != 0x7D:
        number = _NUMBER.match(data, at)
        colon = _after(data, number.end()) if number else at
        found = _TOKEN.match(data, colon)
        if not found or found[0] != b":" or number is None:
            what = f", found '{_text(found)}'" if found else ""
            return f"expected {':' if number else 'a time'}{what}", colon
        value = _after(data, colon + 1)
        if data[value : value + 1] in (b"(", b"["):
            at = _after(data, _close(data, value))
        elif simple := _VALUE.match(data, value) or _MARK.match(data, value):
            at = _after(data, simple.end())
        else:
            return None
        if data[at : at + 1] != b",":
            break
    return None


def is_type(word: bytes) -> bool:
    """Whether attributes are declared with that word; a test holds it against those that USD has."""
    return _TYPE.fullmatch(word) is not None


def _left_open(data: bytes, at: int, mark: bytes) -> Wrong | None:
    opened: list[tuple[bytes, int]] = []
    for match in _MARK.finditer(data, 0, at):
        if match[0] in _CLOSES.values():
            opened.append((match[0], match.start()))
        elif match[0] in _CLOSES and opened:
            opened.pop()
    if not opened or opened[-1][0] != _CLOSES[mark]:
        return None
    found, start = opened[-1]
    line = data.count(b"\n", 0, start) + 1
    return f"{mark.decode()} for the {found.decode()} of line {line}", start


def _unclosed(data: bytes, token: re.Match[bytes]) -> Wrong | None:
    """Where nothing is wrong with a statement, what it stands in may never end."""
    at = token.start()
    opened = _left_open(data, len(data), b"}")
    if opened is None or opened[1] > at:
        return None
    return f"expected {opened[0]}, found '{_text(token)}'", at


def _line_end(data: bytes, at: int) -> int:
    end = data.find(b"\n", at)
    return end if end >= 0 else len(data)


def _unknown(data: bytes, at: int) -> Wrong:
    word = data[at : _line_end(data, at)].split()[0].decode(errors="replace")[:40]
    return f"'{word}' begins no statement that USD can read", at


def _misspelt(token: re.Match[bytes]) -> Wrong:
    word = _text(token)
    (likeness, known), *_ = most_alike(word, _KEYWORDS, 1)
    meant = f": did you mean '{known}'?" if likeness >= _ALIKE else ""
    return f"'{word}' is no keyword{meant}", token.start()


def _text(token: re.Match[bytes]) -> str:
    return token[0].decode(errors="replace")[:40]


def _is_word(token: re.Match[bytes]) -> bool:
    return token[0][:1].isalpha() or token[0][:1] == b"_" or token[0][0] >= 0x80


def _is_string(token: re.Match[bytes]) -> bool:
    return token[0][:1] in (b'"', b"'")


def _prim(data: bytes, tokens: list[re.Match[bytes]]) -> Wrong | None:
    """`def Type "name" (...) {`"""
    specifier, *rest = tokens
    name = next((one for one in rest if _is_string(one)), None)
    if name is None:
        words = [one for one in rest if _is_word(one)]
        if words:
            said = f'the name of a prim stands in quotes, as in "{_text(words[-1])}"'
            return said, words[-1].start()
        return f"a name in quotes is missing after '{_text(specifier)}'", specifier.start()
    between = rest[: rest.index(name)]
    if strange := next((one for one in between if not _is_word(one)), None):
        said = f"expected a type or a name in quotes, found '{_text(strange)}'"
        return said, strange.start()
    if len(between) > 1:
        said = f"one type stands between '{_text(specifier)}' and the name"
        return f"{said}, and not '{_text(between[1])}'", between[1].start()
    after = _after(data, name.end())
    if data[after : after + 1] == b"(":
        after = _after(data, _close(data, after))
    if data[after : after + 1] == b"{":
        return _behind(data, _close(data, after), b"#")
    found = _TOKEN.match(data, after)
    what = f"found '{_text(found)}'" if found else "found the end of the text"
    if found and found[0] == b"(" and data.find(b"(", name.end(), after) >= 0:
        return "a prim has its metadata in one pair of parentheses", after
    said = f"expected {{ after the name of a prim, {what}"
    if not found:
        return said, name.start()
    return _conflict(data, after) or (said, after)


def _conflict(data: bytes, at: int) -> Wrong | None:
    mark = next((m for m in (b"<<<<<<<", b"=======", b">>>>>>>") if data.startswith(m, at)), None)
    return (f"a merge conflict is left here, found '{mark.decode()}'", at) if mark else None


def _after(data: bytes, at: int) -> int:
    match = _BLANKS.match(data, at)
    return match.end() if match else at


def _close(data: bytes, at: int) -> int:
    depth = 0
    for match in _MARK.finditer(data, at):
        depth += (match[0] in _CLOSES.values()) - (match[0] in _CLOSES)
        if not depth:
            return match.end()
    return len(data)


def _property(data: bytes, tokens: list[re.Match[bytes]]) -> Wrong | None:
    """`prepend custom uniform type[] name.suffix = value`"""
    ahead = list(_modifiers(tokens))
    if wrong := _in_disorder(ahead):
        return wrong
    rest = tokens[len(ahead) :]
    if not rest:
        return f"something is missing after '{_text(ahead[-1])}'", ahead[-1].start()
    kind, *rest = rest
    if not _is_word(kind):
        return None
    if kind[0] == b"dictionary":
        return "no attribute is a dictionary: it stands in metadata, in parentheses", kind.start()
    array = rest[:1] and rest[0][0][:1] == b"["
    rest = rest[bool(array) :]
    if not rest or rest[0][0] == b"}":
        return None
    name, *rest = rest
    if _is_string(name):
        if not array and (not rest or rest[0][0] in (b"{", b"(")):
            said = f"'def', 'over' or 'class' is missing before '{_text(kind)}'"
            return (said, kind.start()) if kind[0][:1].isupper() else _misspelt(kind)
        if kind[0] == b"variantSet":
            return _unclosed(data, kind)
        if kind[0].lower() == b"variantset":
            return _misspelt(kind)
    is_known = kind[0] == b"rel" or is_type(kind[0])
    if not is_known and _is_word(name) and rest and (_is_word(rest[0]) or _is_string(rest[0])):
        return _misspelt(kind)
    return _named(data, kind, name, rest)


def _named(
    data: bytes, kind: re.Match[bytes], name: re.Match[bytes], rest: list[re.Match[bytes]]
) -> Wrong | None:
    if name[0] == b"=":
        return f"a name is missing after '{_text(kind)}'", name.start()
    if name[0].isdigit():
        return f"a name cannot begin with '{_text(name)}'", name.start()
    if not _is_word(name):
        said = f"expected the name of a property after '{_text(kind)}', found '{_text(name)}'"
        return said, name.start()
    if name[0].endswith(b":") or b"::" in name[0]:
        return f"'{_text(name)}' is no name of a property", name.start()
    if not _text(name).replace(":", "_").isidentifier():
        said = f"'{_text(name)}' is no name of a property: it is made of letters, digits and _"
        return said, name.start()
    if rest and rest[0].start() == name.end() and rest[0][0] not in (b".", b"=", b"(", b";", b"#"):
        return f"'{_text(rest[0])}' cannot stand in the name of a property", rest[0].start()
    if rest and rest[0][0] == b".":
        suffix = rest[1:2]
        known = (b"connect", b"default", b"spline", b"timeSamples")
        if not suffix or suffix[0][0] not in known:
            found = suffix[0] if suffix else rest[0]
            said = "after the '.' of an attribute stands 'timeSamples', 'connect' or 'spline'"
            return f"{said}, and not '{_text(found)}'", found.start()
        rest = rest[2:]
    if not rest or rest[0][0] in (b"(", b";", b"#"):
        return None
    if rest[0][0] != b"=":
        return f"expected '=', found '{_text(rest[0])}'", rest[0].start()
    if len(rest) == 1 or rest[1][0] == b"#":
        return "a value is missing after '='", rest[0].start()
    return _value(data, kind, rest[1:])


def _value(data: bytes, kind: re.Match[bytes], rest: list[re.Match[bytes]]) -> Wrong | None:
    value = rest[0]
    at, first = value.start(), value[0][:1]
    if kind[0] == b"rel":
        if first in b"<[" or value[0] == b"None":
            return _behind_value(data, at)
        said = "a target stands in angle brackets, as in </World/camera>"
        return f"{said}, and not '{_text(value)}'", at
    if number := _NUMBER.match(data, at):
        behind = _REST.match(data, number.end())
        if behind and behind[0]:
            return f"'{data[at : behind.end()].decode(errors='replace')[:40]}' is no number", at
    elif _is_word(value):
        said = f"'{_text(value)}' is no value"
        if value[0].lower() == b"none":
            return (f"{said}: did you mean None?", at) if value[0] != b"None" else None
        return f"{said}: text stands in quotes", at
    elif first not in b"\"'@<[({":
        meant = ": text stands in quotes" if first == b"/" else ""
        return f"no value begins with '{_text(value)}'{meant}", at
    return _behind_value(data, at)


def _behind_value(data: bytes, at: int) -> Wrong | None:
    if data[at : at + 1] in (b"(", b"[", b"{"):
        end = _close(data, at)
    elif simple := _VALUE.match(data, at) or _TARGET.match(data, at) or _MARK.match(data, at):
        end = simple.end()
    else:
        return None
    metadata = _in_line(data, end)
    if data[metadata : metadata + 1] == b"(":
        end = _close(data, metadata)
    return _behind(data, end, b"#;")


def _behind(data: bytes, at: int, ends: bytes) -> Wrong | None:
    """What stands in a line behind the end of a statement."""
    at = _in_line(data, at)
    found = _TOKEN.match(data, at)
    if not found or found[0] in ends or data.startswith((b"\r", b"\n", b"//"), at):
        return None
    return f"expected the end of the line, found '{_text(found)}'", at


def _in_line(data: bytes, at: int) -> int:
    match = _PADDING.match(data, at)
    return match.end() if match else at


def _modifiers(tokens: list[re.Match[bytes]]) -> Iterator[re.Match[bytes]]:
    for token in tokens:
        if token[0] not in _MODIFIERS:
            return
        yield token


def _in_disorder(ahead: list[re.Match[bytes]]) -> Wrong | None:
    ranks = [0 if one[0] in _OPERATIONS else 1 if one[0] == b"custom" else 2 for one in ahead]
    for (before, rank), (token, own) in zip(
        zip(ahead, ranks, strict=True), zip(ahead[1:], ranks[1:], strict=True), strict=False
    ):
        if own < rank:
            return f"'{_text(token)}' stands before '{_text(before)}'", token.start()
        if own == rank:
            said = f"'{_text(token)}' stands after '{_text(before)}', and only one of them may"
            return said, token.start()
    return None

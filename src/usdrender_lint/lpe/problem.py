"""What is said of a text that is no light path expression?"""

from __future__ import annotations

from ..lazily import lazily
from ..records import dataclass
from .dialects import ALL, CAMERA, MEANINGS, Dialect, titles

PREFIX = lazily(r"[A-Za-z_][A-Za-z0-9_]*;")
CLOSING = {"(": ")", "[": "]", "<": ">", "{": "}"}
_NAME = lazily(r"[A-Za-z_][A-Za-z0-9_]*")
_BLANKS = {" ": "a space", "\t": "a tab", "\n": "a line break", "\r": "a line break"}
_LOOKALIKES = {
    "\u0410": "A", "\u0412": "B", "\u0421": "C", "\u041e": "O", "\u0422": "T", "\u0405": "S",
    "\u0391": "A", "\u0392": "B", "\u039f": "O", "\u03a4": "T", "\u0455": "s", "\u0445": "x",
    "\u2018": "'", "\u2019": "'", "\u00b4": "'", "`": "'", "\u2032": "'",
    "\u2217": "*", "\u00d7": "*", "\u00b7": ".", "\u2026": "...", "\u2039": "<", "\u203a": ">",
}  # fmt: skip
"""What word processors, web pages and other alphabets make of a letter: V-Ray's own page of
presets writes one T in Cyrillic."""
_STRAIGHT = str.maketrans(_LOOKALIKES)


@dataclass(frozen=True, slots=True)
class Problem:
    """Why a text is not an expression."""

    message: str
    column: int
    """In code points, from 1; one past the end if something is missing there."""


def unknown(text: str, at: int, opened: int | None, dialect: Dialect) -> Problem:
    """Of a character that cannot stand there; `opened` is where the innermost bracket does."""
    return Problem(*_unknown(text, at, opened, dialect))


def _unknown(text: str, at: int, opened: int | None, dialect: Dialect) -> tuple[str, int]:
    head = text[at]
    if head in CLOSING.values():
        return _closes_nothing(text, at, opened), at + 1
    if head == "|":
        return "'|' inside '[ ]': there every item is an alternative already", at + 1
    if head in dialect.repetitions:
        return f"'{head}' has nothing to repeat", at + 1
    if head in _BLANKS:
        return f"{_BLANKS[head]} is not allowed", at + 1
    if head == "^":
        return "'^' belongs right after '[', as in [^LO]", at + 1
    if head == '"':
        return "labels are quoted with ', not with \"", at + 1
    if head == "x":
        return "'x' (none) stands only inside '< >'", at + 1
    if alike := lookalike(head):
        return alike, at + 1
    if head.isalpha() or head == "_":
        return _no_event(text, at, dialect)
    return _foreign(head, text[at - 1 : at]), at + 1


def _closes_nothing(text: str, at: int, opened: int | None) -> str:
    if opened is None:
        return f"'{text[at]}' closes nothing"
    opening = text[opened]
    closing = CLOSING[opening]
    return (
        f"'{text[at]}' closes nothing: '{opening}' of column {opened + 1} waits for its '{closing}'"
    )


def _foreign(head: str, before: str) -> str:
    numbering = tuple(d for d in ALL if before and before in d.lobes)
    if head.isdecimal() and numbering:
        return f"'{before}{head}': only {titles(numbering)} numbers its lobes"
    if head == "?":
        return f"only {_readers(tuple(d for d in ALL if d.optional))} '?': write {{0,1}}"
    if combining := tuple(d for d in ALL if head in d.operators):
        return f"only {titles(combining)} combines expressions by '{head}'"
    if head == "$":
        return "'$': is a variable left that nothing has replaced?"
    return f"{shown(head)} has no meaning here"


def _no_event(text: str, at: int, dialect: Dialect) -> tuple[str, int]:
    head = text[at]
    upper = head.upper() if head.isascii() and head.upper() in dialect.letters else ""
    if head.islower() and _NAME.fullmatch(text) and not (upper and text[0] == CAMERA):
        return f"'{short(text)}' is a name, not an expression", 1
    if readers := tuple(d for d in ALL if head in d.letters):
        meaning = f" ({MEANINGS[head]})" if head in MEANINGS else ""
        return f"only {_readers(readers)} '{head}'{meaning}", at + 1
    if upper:
        return f"'{head}' is no event: {upper} is", at + 1
    events = " ".join(CAMERA + dialect.ends + dialect.bounces)
    scatterings = " ".join(dialect.scatterings)
    message = f"{shown(head)} is no event: there are {events}, and scatterings {scatterings}"
    return message, at + 1


def unknown_prefix(name: str, dialect: Dialect) -> str:
    """Of a prefix that a dialect does not have."""
    if readers := tuple(d for d in ALL if name in d.prefixes):
        return f"only {_readers(readers)} the prefix '{name};'"
    known = dialect.prefixes or {p for d in ALL for p in d.prefixes}
    meant = nearest(name, known)
    hint = f": did you mean '{meant};'?" if meant else ""
    return f"'{short(name)};' is no prefix{hint}"


def nearest(name: str, known: frozenset[str] | set[str]) -> str:
    """The one most like it, or nothing. The time `difflib` takes grows with the square."""
    import difflib

    return next(iter(difflib.get_close_matches(name[:99], sorted(known), n=1)), "")


def _readers(dialects: tuple[Dialect, ...]) -> str:
    return f"{titles(dialects)} {'read' if len(dialects) > 1 else 'reads'}"


def shown(character: str) -> str:
    """A character as a message can quote it."""
    if character in _BLANKS:
        return _BLANKS[character]
    return f"'{character}'" if character.isprintable() else f"U+{ord(character):04X}"


def lookalike(character: str) -> str:
    """What a character only looks like, or nothing."""
    if not (meant := _LOOKALIKES.get(character)):
        return ""
    return f"{shown(character)} (U+{ord(character):04X}) only looks like {meant}"


def straightened(text: str) -> str:
    """With the letters that others only look like."""
    return text.translate(_STRAIGHT)


def short(text: str) -> str:
    return text if len(text) <= 40 else f"{text[:37]}..."


def quoted(text: object) -> str:
    """A part of an expression as a message can name it; a label has quotes already."""
    part = short(str(text))
    return part if part.startswith("'") else f"'{part}'"

"""Does a line get the hash that GitHub gives it?

The vectors are those of `fingerprints.test.ts` in github/codeql-action.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from usdrender_lint.report import fingerprint
from usdrender_lint.report.fingerprint import file_line_hashes, line_hashes

ALL = range(1, 1000)

VECTORS = {
    "": ["c129715d7a2bc9a3:1"],
    " a\nb\n  \t\tc\n d": [
        "271789c17abda88f:1",
        "54703d4cd895b18:1",
        "180aee12dab6264:1",
        "a23a3dc5e078b07b:1",
    ],
    "Lorem ipsum dolor sit amet.\n" * 10: [
        *(f"a7f2ff13bc495cf2:{count}" for count in range(1, 7)),
        "a7f2ff1481e87703:1",
        "a9cf91f7bbf1862b:1",
        "55ec222b86bcae53:1",
        "cc97dc7b1d7d8f7b:1",
        "c129715d7a2bc9a3:1",
    ],
    "x = 2\nx = 1\nprint(x)\nx = 3\nprint(x)\nx = 4\nprint(x)\n": [
        "e54938cc54b302f1:1",
        "bb609acbe9138d60:1",
        "1131fd5871777f34:1",
        "5c482a0f8b35ea28:1",
        "54517377da7028d2:1",
        "2c644846cb18d53e:1",
        "f1b89f20de0d133:1",
        "c129715d7a2bc9a3:1",
    ],
}


def slowly(text: str) -> list[str]:
    """The algorithm as it is told: one window that rolls over all the text."""
    unified = text.replace("\r\n", "\n").replace("\r", "\n").replace(" ", "").replace("\t", "")
    data = unified.encode("utf-16-le", "surrogatepass")
    units = [int.from_bytes(data[i : i + 2], "little") for i in range(0, len(data), 2)]
    units += [0xFFFF] + [0] * 100
    starts = [0] + [i + 1 for i, unit in enumerate(units) if unit == 10]
    hashes: list[str] = []
    for start in starts:
        value = 0
        for unit in units[start : start + 100]:
            value = (value * 37 + unit) % 2**64
        count = sum(h.startswith(f"{value:x}:") for h in hashes) + 1
        hashes.append(f"{value:x}:{count}")
    return hashes


@pytest.mark.parametrize("text", VECTORS, ids=["empty", "blanks", "repeated lines", "program"])
def test_vectors(text: str) -> None:
    assert list(line_hashes(text, ALL).values()) == VECTORS[text]


@pytest.mark.parametrize("line_break", ["\r", "\r\n"])
def test_every_line_break_counts_as_a_line_feed(line_break: str) -> None:
    text = "x = 2\nx = 1\n\nprint(x)\n"
    assert line_hashes(text.replace("\n", line_break), ALL) == line_hashes(text, ALL)


@pytest.mark.parametrize(
    "text",
    [
        'def "Schöne Größe"\n{\n    string 名前 = "光"\n}\n' * 5,
        "😀 = 1\n\n" * 150,
        "\ufeff#usda 1.0\n" + "a" * 300 + "\n" + "a" * 300,
        "\n" * 120,
        "Aj\n" + "\0" * 3 + "\nBE",
    ],
    ids=["not ASCII", "beyond UTF-16", "byte order mark", "empty lines", "no last line break"],
)
def test_the_quick_way_is_the_slow_way(text: str) -> None:
    assert list(line_hashes(text, ALL).values()) == slowly(text)


def test_stops_after_the_window_of_the_last_line_with_the_same_result() -> None:
    text = "".join(f"float size{number % 40} = {number % 3}\n" for number in range(500))
    everything = line_hashes(text, ALL)

    assert all(
        line_hashes(text, {line}) == {line: everything[line]} for line in (1, 2, 77, 499, 500, 501)
    )


def test_lines_that_are_not_there_have_no_hash() -> None:
    assert list(line_hashes("a\n", {1, 2, 3})) == [1, 2]
    assert line_hashes("a\n", set()) == {}


def test_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    layer = tmp_path / "layer.usda"
    layer.write_bytes(b" a\r\nb\r\n  \t\tc\r\n d")

    assert file_line_hashes(str(layer), {2}) == {2: "54703d4cd895b18:1"}
    assert file_line_hashes(str(tmp_path / "missing.usda"), {2}) == {}

    monkeypatch.setattr(fingerprint, "LIMIT", layer.stat().st_size - 1)
    assert file_line_hashes(str(layer), {2}) == {}


def test_bytes_that_are_not_utf8_are_read_as_replacement_characters(tmp_path: Path) -> None:
    layer = tmp_path / "latin1.usda"
    layer.write_bytes(b"Gr\xf6\xdfe\n")

    assert file_line_hashes(str(layer), {1}) == line_hashes("Gr\ufffd\ufffde\n", {1})

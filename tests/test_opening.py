"""What does not open is told as what it is, by the line, the member or the object that USD names."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from usdrender_lint.lint import lint
from usdrender_lint.results import Location, Report

GOOD = '#usda 1.0\ndef Scope "Render"\n{\n}\n'
ILL_FORMED = '#usda 1.0\ndef "A"\n{\n    pathExpression x = "//{"\n}\n'


def linted(file: Path) -> Report:
    return lint([str(file)], cwd=file.parent)


def told(file: Path) -> tuple[str, Location]:
    """The one finding, which is that something does not parse."""
    report = linted(file)
    assert report.problems == ()
    (finding,) = report.findings
    assert finding.rule.id == "syntax-error"
    return finding.message, finding.location


def refused(file: Path) -> tuple[str, str]:
    """The one problem of what cannot be read at all: its path and what is told."""
    report = linted(file)
    assert report.findings == ()
    (problem,) = report.problems
    return problem.path, problem.message


def package(
    folder: Path, *members: tuple[str, bytes], compression: int = zipfile.ZIP_STORED
) -> Path:
    file = folder / "shot.usdz"
    with zipfile.ZipFile(file, "w", compression) as archive:
        for name, data in members:
            info = zipfile.ZipInfo(name)
            info.compress_type = compression
            # The data of a member begins at a multiple of 64 bytes, as USD wants it.
            header = archive.fp.tell() if archive.fp else 0
            info.extra = (
                b"\x86\x19" + bytes([(pad := -(header + 30 + len(name) + 4) % 64), 0]) + bytes(pad)
            )
            archive.writestr(info, data)
    return file


@pytest.mark.parametrize(
    ("text", "message", "line"),
    [
        ("\n#usda 1.0\n", "the first line is not '#usda 1.0'", 1),
        ("#USDA 1.0\n", "the first line is not '#usda 1.0'", 1),
        ("#sdf 1.4.32\n", "the first line is not '#usda 1.0'", 1),
        (
            "#usda 1.0\n<<<<<<< HEAD\n",
            "a merge conflict is left here, found '<<<<<<<'",
            2,
        ),
        (
            "#usda 1.0\ndef Scope \u201cRender\u201d {\n}\n",
            'quotes are straight, as in "name": the line holds a curly quote',
            2,
        ),
        (
            '#usda 1.0\ndef "\u201c" {\n}\n',
            "'\u201c' is not a valid prim name, near '\"\u201c\"'",
            2,
        ),
        ('#usda 1.0\ndef "A {\n}\n', "a string is not closed", 2),
        (
            '#usda 1.0\ndef "A" (\n    references = @x.usda\n) {\n}\n',
            "an asset path is not closed",
            3,
        ),
        ("# only a comment\n", "the first line is not '#usda 1.0'", 1),
        (
            '#usda 1.0\n\ndef "A"\n{\n    int2 x = (1, 2, 3)\n}\n',
            "the value has not as many components as its type, int2",
            5,
        ),
        (
            '#usda 1.0\ndef "A" (\n    customData = {\n        pathExpression e = "//{"\n    }\n)\n{\n}\n',
            "ill-formed path expression '//{', at its end: something is left open",
            4,
        ),
        (
            '#usda 1.0\ndef "A"\n{\n    variantSet "v" = {\n        "one" {\n'
            '            def "B"\n            {\n                rel r = <../C>\n            }\n'
            "        }\n    }\n}\n",
            "a target can neither hold a variant selection nor, within a variant, be relative",
            8,
        ),
        (
            '#usda 1.0\ndef "A"\n{\n    int x = "a"\n}\n',
            "expected a value of another type, found '\"a\"'",
            4,
        ),
    ],
)
def test_text_that_does_not_parse(tmp_path: Path, text: str, message: str, line: int) -> None:
    file = tmp_path / "main.usda"
    file.write_text(text, "utf-8")
    said, at = told(file)
    assert (said, at.span and at.span.line) == (message, line)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be"])
def test_text_in_utf_16_is_told_as_such(tmp_path: Path, encoding: str) -> None:
    file = tmp_path / "main.usda"
    file.write_bytes(GOOD.encode(encoding))
    assert "UTF-16 text" in refused(file)[1]


@pytest.mark.parametrize(
    ("data", "message", "line"),
    [
        (b'#usda 1.0\ndef "A"\n{\n  what\n}\n', "'what' begins no statement that USD can read", 4),
        (b"#usda 1.0\n# caf\xe9\n", "the text is not UTF-8 from here on", 2),
        (b"# a comment\n", "the first line is not '#usda 1.0'", 1),
        (ILL_FORMED.encode(), "ill-formed path expression '//{', at its end: something is left open", 4),
    ],
)  # fmt: skip
def test_the_root_layer_of_a_package(tmp_path: Path, data: bytes, message: str, line: int) -> None:
    said, at = told(package(tmp_path, ("main.usda", data)))
    assert (said, at.path, at.member) == (message, "shot.usdz", "main.usda")
    assert at.span
    assert at.span.line == line


def test_an_ill_formed_expression_in_a_member_that_is_sublayered(tmp_path: Path) -> None:
    main = b"#usda 1.0\n(\n    subLayers = [@./other.usda@]\n)\n"
    said, at = told(package(tmp_path, ("main.usda", main), ("other.usda", ILL_FORMED.encode())))
    assert "ill-formed path expression '//{'" in said
    assert (at.member, at.span and at.span.line) == ("other.usda", 4)


def test_a_compressed_member_is_told_as_such(tmp_path: Path) -> None:
    file = package(tmp_path, ("main.usda", GOOD.encode() * 9), compression=zipfile.ZIP_DEFLATED)
    assert refused(file) == (
        "shot.usdz",
        "'main.usda' in it is compressed, and USD reads no such file in a package",
    )


def test_an_empty_member_is_told_as_such(tmp_path: Path) -> None:
    file = package(tmp_path, ("main.usda", b""))
    assert refused(file) == ("shot.usdz", "'main.usda' in it is empty")


def test_a_package_that_begins_with_an_image(tmp_path: Path) -> None:
    file = package(tmp_path, ("a.png", b"\x89PNG"), ("main.usda", GOOD.encode()))
    assert "'a.png'" in refused(file)[1]


def test_a_package_of_nothing(tmp_path: Path) -> None:
    assert refused(package(tmp_path))[1] == "a zip package without a file in it"


def test_a_package_whose_end_is_lost(tmp_path: Path) -> None:
    file = package(tmp_path, ("main.usda", GOOD.encode()))
    file.write_bytes(file.read_bytes()[:60])
    assert refused(file)[1] == "the package is truncated or damaged"


def test_a_package_that_asks_for_a_later_zip(tmp_path: Path) -> None:
    """USD does not mind; Python's own reader refuses, with an error of its own kind."""
    file = package(tmp_path, ("main.usda", b"#usda 1.0\ndef\n"))
    data = bytearray(file.read_bytes())
    data[data.rfind(b"PK\x01\x02") + 6] = 204
    file.write_bytes(data)
    with pytest.raises(NotImplementedError):
        zipfile.ZipFile(file)
    report = lint([str(file)], cwd=tmp_path)
    assert report.problems == ()
    assert [f.rule.id for f in report.findings] == ["syntax-error"]


def broken_target(folder: Path, *more: tuple[str, bytes]) -> Path:
    text = """#usda 1.0
def Scope "Render"
{
    def RenderSettings "S"
    {
        rel camera = </World/gone>
    }
}
"""
    return package(folder, ("main.usda", text.encode()), *more)


def places(file: Path) -> list[tuple[str, str | None, int | None]]:
    report = linted(file)
    assert report.problems == ()
    found = [f.location for f in report.findings if f.rule.id == "unresolved-target"]
    return [(at.path, at.member, at.span.line if at.span else None) for at in found]


CENTRAL, END = b"PK\x01\x02", b"PK\x05\x06"


@pytest.mark.parametrize(
    "damage",
    [
        pytest.param(lambda d: d.replace(b"gone", b"lost"), id="another checksum"),
        pytest.param(lambda d: d[: d.index(END)], id="no end"),
        pytest.param(lambda d: d[: d.index(CENTRAL)], id="no directory"),
        pytest.param(lambda d: d[:-6] + b"\5\0\0\0" + d[-2:], id="another start of the directory"),
        pytest.param(lambda d: d[:-2] + b"\x16\0" + d[-22:], id="an end in the comment"),
        pytest.param(lambda d: d + b"more", id="something behind it"),
    ],
)
def test_usd_reads_a_package_from_its_start(
    tmp_path: Path, damage: Callable[[bytes], bytes]
) -> None:
    """Without its directory, which Python's own reader begins with: so there is a line to show."""
    file = broken_target(tmp_path)
    file.write_bytes(damage(file.read_bytes()))
    assert places(file) == [("shot.usdz", "main.usda", 6)]


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_of_two_members_of_one_name_usd_reads_the_first(tmp_path: Path) -> None:
    file = broken_target(tmp_path, ("main.usda", b"#usda 1.0\n" * 9))
    assert places(file) == [("shot.usdz", "main.usda", 6)]


def test_a_package_whose_root_layer_is_a_package(tmp_path: Path) -> None:
    inner = broken_target(tmp_path).read_bytes()
    file = package(tmp_path, ("inner.usdz", inner))
    assert places(file) == [("shot.usdz", "inner.usdz[main.usda]", 6)]


MEMBERS = {
    "main.usda": [
        (GOOD.encode("utf-16"), "UTF-16 text"),
        (b"\xef\xbb\xbf" + GOOD.encode(), "begins with a UTF-8 byte order mark"),
        (b"version https://git-lfs.github.com/spec/v1\n", "a Git LFS pointer"),
        (b"\0" * 99, "begins with nothing but zero bytes"),
        (b"PXR-USDC" + b"\0" * 99, "named .usda, but holds a binary crate"),
    ],
    "main.usdc": [(GOOD.encode(), "named .usdc, but holds usda text")],
}


@pytest.mark.parametrize(
    ("name", "held", "what"), [(name, *one) for name, all_ in MEMBERS.items() for one in all_]
)
def test_a_member_is_looked_at_as_a_file_is(
    tmp_path: Path, name: str, held: bytes, what: str
) -> None:
    path, message = refused(package(tmp_path, (name, held)))
    assert path == "shot.usdz"
    assert message.startswith(f"'{name}' in it: {what}")


def test_a_package_that_was_written_as_a_stream(tmp_path: Path) -> None:
    class Stream(io.BytesIO):
        def seekable(self) -> bool:
            return False

        def tell(self) -> int:
            raise OSError

    held = Stream()
    with zipfile.ZipFile(held, "w") as archive:
        archive.writestr("main.usda", GOOD)
    (tmp_path / "shot.usdz").write_bytes(held.getvalue())
    said = "'main.usda' in it has its size behind it, where USD does not look"
    assert refused(tmp_path / "shot.usdz") == ("shot.usdz", said)


def test_a_package_with_sizes_of_zip64(tmp_path: Path) -> None:
    with (
        zipfile.ZipFile(tmp_path / "shot.usdz", "w") as archive,
        archive.open("main.usda", "w", force_zip64=True) as member,
    ):
        member.write(GOOD.encode())
    said = "'main.usda' in it is written as zip64, which USD does not read"
    assert refused(tmp_path / "shot.usdz") == ("shot.usdz", said)


def test_a_package_with_the_name_of_a_layer(tmp_path: Path) -> None:
    file = package(tmp_path, ("main.usda", GOOD.encode())).rename(tmp_path / "shot.usd")
    assert refused(file)[1] == "named .usd, but holds a zip package: USD opens it by its name"


def test_a_sublayered_member_that_is_latin_1(tmp_path: Path) -> None:
    main = b"#usda 1.0\n(\n    subLayers = [@./other.usda@]\n)\n"
    said, at = told(package(tmp_path, ("main.usda", main), ("other.usda", b"#usda 1.0\n# \xe9\n")))
    assert (said, at.member) == ("the text is not UTF-8 from here on", "other.usda")
    assert at.span
    assert at.span.line == 2

"""How the names of products are read."""

from __future__ import annotations

import pytest

from usdrender_lint.renderers import renderer
from usdrender_lint.rules._names import (
    _FRAME_TOKEN,
    extension_of,
    frame_number,
    frame_token,
    has_placeholder,
    is_plain,
    quoted,
    without_expanded,
    without_tokens,
)
from usdrender_lint.rules.product_name import _DRIVE, _faults


@pytest.mark.parametrize(
    ("name", "token"),
    [
        ("/out/b.$F4.exr", "$F4"),
        ("/out/b.$F.exr", "$F"),
        ("/out/b.${F4}.exr", "${F4}"),
        ("/out/b.$FF.exr", "$FF"),
        ("/out/b.<F4>.exr", "<F4>"),
        ("/out/b.<frame>.exr", "<frame>"),
        ("/out/b.####.exr", "####"),
        ("/out/b.#.exr", "#"),
        ("/out/b.%04d.exr", "%04d"),
        ("/out/b.{frame:04d}.exr", "{frame:04d}"),
        ("/out/b.$FRAME.exr", "$FRAME"),
        ("/out/b.0001.exr", None),
        ("/out/$FOO/b.exr", None),
        ("/out/take#2/b.exr", None),
        ("/out/100%done/b.exr", None),
    ],
)
def test_frame_token(name: str, token: str | None) -> None:
    assert frame_token(name) == token


@pytest.mark.parametrize(
    ("name", "extension"),
    [
        ("/out/b.exr", ".exr"),
        ("/out/b.EXR", ".EXR"),
        ("/out/b.exr.0001", ".exr"),
        ("/out/b.exr.$F4", ".exr"),
        ("/out/b.0001.exr", ".exr"),
        ("/out/v1.2/b", ""),
        (r"C:\out\v1.2\b", ""),
        ("/out/.b", ""),
        ("", ""),
    ],
)
def test_extension(name: str, extension: str) -> None:
    assert extension_of(name) == extension


@pytest.mark.parametrize("name", ["$SHOT/b.exr", "${SHOT}.exr", "%SHOT%.exr", "{shot}.exr", "<x>"])
def test_what_is_to_be_filled_in(name: str) -> None:
    assert has_placeholder(name)


def test_what_is_not_to_be_filled_in() -> None:
    assert not has_placeholder("/out/100% done/b_v012.exr")


@pytest.mark.parametrize(
    ("name", "number"),
    [("/out/b.0007.exr", "0007"), ("render000009.exr", "000009"), ("b_v012_beauty.exr", None)],
)
def test_frame_number(name: str, number: str | None) -> None:
    assert frame_number(name) == number


def test_what_a_renderer_expands() -> None:
    name = "$HIP/b.$F4.####.exr"
    assert without_expanded(name, renderer("any")) == name
    assert without_expanded(name, renderer("karma")) == "/b..####.exr"
    assert without_tokens(name, renderer("any")) == "$HIP/b...exr"


def test_control_characters_are_spelled_out() -> None:
    assert quoted("C:\renders") == "'C:\\x0denders'"


def test_in_a_plain_name_nothing_is_found() -> None:
    """It is not looked at again: so no character of it may be one that means something."""
    plain = "".join(c for c in map(chr, range(1, 0x250)) if is_plain(c))
    assert {*"/out/b_v012-final.0001.exr"} <= {*plain}
    for odd in (plain, "a.F4.exr", "frame.0001.exr", "/d/04d.exr", "", ".", "..", "-"):
        assert is_plain(odd)
        assert _FRAME_TOKEN.search(odd) is None
        assert not has_placeholder(odd)
        assert list(_faults(odd)) == []
        assert _DRIVE.match(odd) is None


@pytest.mark.parametrize("mark", "$<{[@#% ~\\:*?|`'\"\n\r\t")
def test_what_means_something_is_not_plain(mark: str) -> None:
    assert not is_plain(f"/out/b{mark}.exr")
    assert not is_plain(f"/out/b{mark}")

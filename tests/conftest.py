"""The one switch that rewrites everything expected, and the places tests read from."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update",
        action="store_true",
        help="rewrite marks, golden files and generated passages to what is true today",
    )
    parser.addoption("--fuzz", type=int, metavar="N", help="inputs of each kind, for test_fuzz.py")
    parser.addoption("--fuzz-seed", type=int, default=0, metavar="N", help="other inputs")


@pytest.fixture
def update(request: pytest.FixtureRequest) -> bool:
    return bool(request.config.getoption("--update"))


@pytest.fixture
def expect_text(update: bool) -> Callable[[Path, str], None]:
    """Compare a text with a golden file, or write the file."""

    def check(file: Path, text: str) -> None:
        if update:
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, "utf-8")
        assert file.exists(), f"{file} is missing: run pytest --update, and read it"
        assert file.read_text("utf-8") == text

    return check

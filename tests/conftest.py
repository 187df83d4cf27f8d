"""The one switch that rewrites everything expected, and the places tests read from."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from importlib import metadata
from pathlib import Path

import pytest

from usdrender_lint import lint_file
from usdrender_lint.rule import Context
from usdrender_lint.run import Crash, Rules, Subject, Told, run

ROOT = Path(__file__).parents[1]

TOO_NARROW = (
    "these findings are lost, because the stage shows nothing that their rule is `about`. Add what "
    "brings them about, an attribute, a relationship or a Sign, or leave `about=` out"
)
"""For the author of a rule."""


def installed() -> tuple[int, ...]:
    """The version of usd-core."""
    return tuple(map(int, metadata.version("usd-core").split(".")))


def since(*version: int) -> pytest.MarkDecorator:
    """For what holds of this version of usd-core and newer ones."""
    reason = f"usd-core {'.'.join(map(str, version))} is the first of which it holds"
    return pytest.mark.skipif(installed() < version, reason=reason)


def before(*version: int) -> pytest.MarkDecorator:
    """For what holds of versions of usd-core that are older than this one."""
    reason = f"it holds before usd-core {'.'.join(map(str, version))}"
    return pytest.mark.skipif(installed() >= version, reason=reason)


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


@pytest.fixture(autouse=True, scope="session")
def spared_rules_are_silent() -> Iterator[None]:
    """On every stage that any test lints here: a rule does not run where it has nothing to say, and
    nowhere else."""

    def checked(
        rules: Rules, subjects: Iterable[Subject], context: Context
    ) -> tuple[list[Told], list[Crash]]:
        subjects = list(subjects)
        ran = run(rules, subjects, context)
        all_rules = Rules(replace(r, about=frozenset()) for r in rules)
        all_ran = run(all_rules, subjects, context)
        if missed := [one for one in _said(all_ran) if one not in _said(ran)]:
            pytest.fail(f"{missed}: {TOO_NARROW}")
        assert _said(ran) == _said(all_ran)
        return ran

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lint_file, "run", checked)
        yield


def _said(ran: tuple[list[Told], list[Crash]]) -> list[tuple[str, object]]:
    told, crashes = ran
    crashed = [(c.rule.id, f"{c.subject}: {c.error}") for c in crashes]
    return [*((t.rule.id, t.finding) for t in told), *crashed]

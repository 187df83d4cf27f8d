"""Every rule has a page, every page a rule, and what a page shows is what the rule does."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from conftest import since
from usdrender_lint.pages import Case, facts_line, parse
from usdrender_lint.registry import all_rules
from usdrender_lint.testing import (
    HEADER,
    check_page,
    files_of,
    lint_bad,
    marked,
)

ROOT = Path(__file__).parents[1]
RULES = ROOT / "rules"
CONTRIBUTING = ROOT / ".github" / "CONTRIBUTING.md"
IDS = sorted(p.stem for p in RULES.glob("*.md") if p.stem != "README")


def test_every_rule_has_a_page() -> None:
    missing = sorted(set(all_rules()) - set(IDS))
    assert not missing, f"create {', '.join(f'rules/{i}.md' for i in missing)}"


def test_every_page_has_a_rule() -> None:
    assert not set(IDS) - set(all_rules())


NEWER = {"disallowed-token": since(26, 5)}
"""Pages that show what an older USD does not know: the mode of a collection is one of its attributes."""


@pytest.mark.parametrize("rule_id", [pytest.param(i, marks=NEWER.get(i, ())) for i in IDS])
def test_page(rule_id: str, update: bool) -> None:
    """The bad blocks are found as marked, and nothing in the good ones."""
    file = RULES / f"{rule_id}.md"
    if update:
        file.write_text(_updated(file.read_text("utf-8"), rule_id), "utf-8")
    page = parse(file.read_text("utf-8"))
    assert page.title == rule_id
    assert page.facts == facts_line(all_rules()[rule_id])
    assert page.cases("Bad")
    assert page.cases("Good")
    assert check_page(page) == []


@pytest.mark.parametrize("rule_id", IDS)
def test_links_lead_to_pages(rule_id: str) -> None:
    text = (RULES / f"{rule_id}.md").read_text("utf-8")
    linked = re.findall(r"\]\(([a-z0-9-]+)\.md\)", text)
    assert not [name for name in linked if name not in IDS]


@pytest.mark.parametrize("rule_id", IDS)
def test_sources_come_first_and_other_rules_last(rule_id: str) -> None:
    assert _wrong_references((RULES / f"{rule_id}.md").read_text("utf-8")) == []


def test_the_page_that_contributors_begin_with_has_the_form_of_all() -> None:
    template = re.search(
        r"^````markdown\n(.*?)^````$", CONTRIBUTING.read_text("utf-8"), re.M | re.S
    )
    assert template is not None
    assert parse(template[1]).title == "my-rule"
    assert _wrong_references(template[1]) == []


def _wrong_references(page: str) -> list[str]:
    """Lines of "See also" that are sentences, or that name other rules elsewhere than in a last line
    for all of them."""
    lines = page.partition("## See also\n")[2].strip().splitlines()
    link = r"\[[a-z0-9-]+\]\([a-z0-9-]+\.md\)"
    if lines and re.fullmatch(rf"- Related: {link}(, {link})*", lines[-1]):
        lines.pop()
    return [line for line in lines if not re.fullmatch(r"- .+[^.]", line) or re.search(link, line)]


def _updated(text: str, rule_id: str) -> str:
    page = parse(text)
    text = text.replace(page.facts, facts_line(all_rules()[rule_id]), 1)
    for case in page.cases("Bad"):
        text = _fill_case(text, case, rule_id)
    return text


def _fill_case(text: str, case: Case, rule_id: str) -> str:
    files = files_of(case)
    _, found = lint_bad(all_rules()[rule_id], files)
    for name, block in [("main.usda", case.main), *case.files.items()]:
        new = marked(files[name], [m for m in found if m.file == name], rule_id)
        if not block.startswith("#usda") and name == "main.usda":
            new = new.removeprefix(HEADER)
        text = text.replace(block, new, 1)
    return text

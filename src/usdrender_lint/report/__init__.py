"""What do the reporters share? The program's name and addresses, and one way to write JSON."""

from __future__ import annotations

# Not `import json`: the submodule `report.json` becomes this package's attribute `json`.
from json import dumps

NAME = "usdrender-lint"
HOME = f"https://github.com/usdrender-lint/{NAME}"


def page_url(rule_id: str) -> str:
    """Where a rule's page can be read on the web."""
    return f"{HOME}/blob/main/rules/{rule_id}.md"


def to_json(value: object) -> str:
    """JSON text in the order of the keys, readable, and encodable as UTF-8 whatever it holds."""
    text = dumps(value, indent=2, ensure_ascii=False)
    # A file name that is not UTF-8 brings lone surrogates; `\udcXX` is legal in a JSON string.
    return text.encode("utf-8", "backslashreplace").decode("utf-8") + "\n"

"""What do the rules about collections have in common?"""

from __future__ import annotations

from ..model import Collection, ValueState

VISIBILITY = ("renderVisibility", "cameraVisibility")
UNSEEN = {
    "renderVisibility": "is not rendered",
    "cameraVisibility": "is hidden from the camera",
    "matte": "is no matte",
}
"""What becomes of geometry that is no member, by collection."""


def is_written(collection: Collection) -> bool:
    return collection.expression.state is ValueState.AUTHORED and bool(collection.expression.value)


def includes_all(collection: Collection) -> bool:
    """By `includeRoot`, where that counts."""
    by_rule = collection.expansion_rule.value != "explicitOnly"
    return collection.include_root.value and by_rule and collection.mode.value != "expression"

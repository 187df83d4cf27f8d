"""Which material purposes stand for all?"""

from __future__ import annotations

ALL_PURPOSE = ("", "allPurpose")
"""The schema's spelling, and the token's name, which Houdini writes."""

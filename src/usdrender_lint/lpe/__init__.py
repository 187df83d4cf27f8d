"""What does a light path expression say, who can read it, and is it what was meant?

    read(text) -> Expression | Problem      in the dialects that count, the best of them
    suspicions(expression)                  it is read, and still matches nothing, or something else
    suspicions_in(text)                     the same of the text, judged once
    extensions(text)                        what in it is not Open Shading Language
    looks_like_lpe(text)                    of a sourceName that does not say so

No function here raises, whatever the text; each takes time linear to its length.
"""

from __future__ import annotations

from .dialects import ALL, DIALECTS, OSL, Dialect, titles
from .parse import parse
from .portable import Extension, extensions
from .problem import Problem
from .read import accepted_by, has_variable, looks_like_lpe, read, strip_prefix, suspicions_in
from .suspect import mended, suspicions
from .suspicion import Edit, Suspicion
from .tree import Expression

__all__ = [
    "ALL",
    "DIALECTS",
    "OSL",
    "Dialect",
    "Edit",
    "Expression",
    "Extension",
    "Problem",
    "Suspicion",
    "accepted_by",
    "extensions",
    "has_variable",
    "looks_like_lpe",
    "mended",
    "parse",
    "read",
    "strip_prefix",
    "suspicions",
    "suspicions_in",
    "titles",
]

"""Which path expressions of a text layer are ill-formed?

In a root or referenced layer such an expression makes the stage fail to open without naming file
or line; in a sublayer the stage opens, nothing is said, and the value is empty though authored
(26.11). So the text itself is asked.
"""

from __future__ import annotations

from pxr import Sdf, Tf

from ..model import Layer, Site
from ..stage import sentences
from .text import Texts, text_of


def ill_formed_expressions(texts: Texts, file: str) -> list[Layer]:
    data = text_of(texts.full_name(file))
    if data is None or b"pathExpression" not in data:
        return []
    text = texts.of_file(file)
    found = []
    for expression in text.expressions() if text else ():
        if problem := _problem(expression.text):
            site = Site("/", "syntax", layer=file, spec=expression.path)
            found.append(Layer(file, site, problem))
    return found


def _problem(text: str) -> str | None:
    try:
        Sdf.PathExpression(text)
    except Tf.ErrorException as error:
        what = "".join(sentences(error.args)).rpartition("at character ")[2].rstrip(": ")
        where = f"at character {what}" if what else "USD takes only ASCII letters in it"
        return f"ill-formed path expression {text!r}: {where}"
    return None

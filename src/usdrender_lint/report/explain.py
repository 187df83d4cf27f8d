"""How does a rule's page look on a terminal? Like a manual page."""

from __future__ import annotations

from io import StringIO

MAX_WIDTH = 100
"""Longer lines of prose are hard to read."""


def render(text: str, *, color: bool, width: int) -> str:
    """The page for a terminal, or without color the Markdown as it is written."""
    return _terminal(text, min(width, MAX_WIDTH)) if color else text


def _terminal(text: str, width: int) -> str:
    # Here, since nothing else needs rich, which takes longer to import than a small stage to lint.
    from markdown_it import MarkdownIt
    from rich import markdown
    from rich.console import Console, ConsoleOptions, RenderResult
    from rich.segment import Segment
    from rich.theme import Theme

    class Heading(markdown.Heading):
        """At the left margin in every version of rich, without a frame."""

        def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
            self.text.justify = "left"
            yield self.text

    class CodeBlock(markdown.CodeBlock):
        """As written: not wrapped, no tab expanded, so that it can be copied."""

        def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
            style = console.get_style("cyan")
            for line in self.text.plain.rstrip("\n").split("\n"):
                yield Segment(line, style)
                yield Segment.line()

    class Manual(markdown.Markdown):
        elements = {  # noqa: RUF012 - rich's own name and form
            **markdown.Markdown.elements,
            "heading_open": Heading,
            "fence": CodeBlock,
            "code_block": CodeBlock,
        }

    # By its own parser </World> is HTML and vanishes, and <https://...> is printed twice.
    parser = MarkdownIt("commonmark", {"html": False}).enable(["strikethrough", "table"])
    page = Manual("", hyperlinks=False)
    page.parsed = parser.disable("autolink").parse(text)
    output = StringIO()
    console = Console(
        file=output,
        width=width,
        force_terminal=True,
        color_system="standard",
        no_color=False,
        legacy_windows=False,
        # rich's own code is cyan on black, which is a stain on a light terminal.
        theme=Theme({"markdown.h2": "bold", "markdown.code": "cyan"}),
    )
    console.print(page, crop=False)
    # rich fills lines up to the width; when the window narrows, that wraps.
    return "\n".join(line.rstrip(" ") for line in output.getvalue().split("\n"))

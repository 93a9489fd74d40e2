"""A prompt as lines of text: drawn large, above its plain line. No Textual is needed to draw it."""

from sar_tui.framework.messages import Prompt
from sar_tui.widgets.large_characters import draw

FIXATION = "·"
Line = tuple[str, bool]
"""A line at its full indentation, and whether it is bold."""


def plain_lines(prompt: Prompt | None, width: int, height: int) -> list[Line]:
    """Draw a prompt in the middle of ``width`` by ``height`` cells; without a prompt, the fixation point."""
    glyph, text, hint = (prompt.glyph, prompt.text, prompt.hint) if prompt else ("", "", "")
    drawn = draw(glyph, width - 2, height - 3) if glyph else (FIXATION,)
    block = [*((line, True) for line in drawn), ("", False), (text, True), (hint, False)]
    top = max(0, (height - len(block)) // 2)
    return [("", False)] * top + [(centred(line, width), bold) for line, bold in block]


def centred(line: str, width: int) -> str:
    """Indent a line so that it stands in the middle of ``width`` cells."""
    return " " * max(0, (width - len(line)) // 2) + line

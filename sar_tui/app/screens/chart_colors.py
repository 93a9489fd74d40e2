"""Colours of the characters of charts in text."""

from textual.content import Content

from sar_tui.reports.session_chart import AREA, BAND, CHOSEN, POINT, RULE

_COLORS = {
    POINT: "$accent",
    BAND: "$text-muted",
    AREA: "$border",
    RULE: "$text-muted",
    CHOSEN: "$accent",
}


def colored(lines: list[str]) -> Content:
    """Return lines of text, with the characters of charts in their colours."""
    pieces: list[str | tuple[str, str]] = []
    for line in lines:
        for character in f"{line}\n":
            style = _COLORS.get(character, "")
            last = pieces[-1] if pieces else None
            if isinstance(last, tuple) and last[1] == style:
                pieces[-1] = (last[0] + character, style)
            else:
                pieces.append((character, style))
    return Content.assemble(*pieces)

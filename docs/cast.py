"""An animated picture of the app: one SVG without a script, a font or a player.

Each frame shows its rows for a time, by keyframes of CSS. A row that looks the same in several
frames is drawn once and used again, and all frames share their styles. For people who prefer
reduced motion one frame stands still.
"""

import re
from typing import Any

from textual.app import App

_LINE = 24.4
_CHROME = 9, 41
"""Left and top edge of the screen in the picture, of which the first is a margin, too."""
_STYLE = re.compile(r"\.terminal-\d+-(r\d+) \{ ([^}]*?);? *\}")
_RECT = re.compile(r'<rect (fill="[^"]*") x="([^"]*)" y="([^"]*)" width="([^"]*)"[^>]*>')
_TEXT = re.compile(
    r'<text class="terminal-\d+-(r\d+)" x="([^"]*)" y="([^"]*)" textLength="([^"]*)"[^>]*>'
    r"([^<]*)</text>"
)
_SIZE = re.compile(r'viewBox="0 0 (\S+) (\S+)"')
_BACKGROUND = re.compile(r'<rect fill="(#\w+)" stroke=')


class Cast:
    """Frames of an app, each with the time for which it is shown.

    Args:
        still: number of the frame that is shown where no motion is wanted, from 0; the last by
            default.
    """

    def __init__(self, still: int = -1) -> None:
        self._frames: list[tuple[str, float]] = []
        self._still = still

    def show(self, app: App[Any], seconds: float) -> None:
        """Add the screen as it is now, or show it longer if it has not changed."""
        frame = app.export_screenshot(title="sar-tui")
        frame = re.sub(r"terminal-\d+", "terminal-0", frame)
        if self._frames and self._frames[-1][0] == frame:
            seconds += self._frames.pop()[1]
        self._frames.append((frame, seconds))

    def keep_still(self) -> None:
        """Let the newest frame stand where no motion is wanted."""
        self._still = len(self._frames) - 1

    @property
    def seconds(self) -> float:
        """Duration of a round."""
        return sum(seconds for _, seconds in self._frames)

    def svg(self) -> str:
        """Return the picture."""
        rows, styles = _Numbered("l"), _Numbered("s")
        groups, timing, began = [], [], 0.0
        for number, (frame, seconds) in enumerate(self._frames):
            uses = (
                f'<use href="#{name}" y="{_short(line * _LINE)}"/>'
                for line, name in _rows(frame, rows, styles)
            )
            groups.append(f'<g class="f f{number}">{"".join(uses)}</g>')
            timing.append(_keyframes(number, began, began + seconds, self.seconds))
            began += seconds
        first = self._frames[0][0]
        width, height = _SIZE.search(first).groups()  # type: ignore[union-attr]
        ground = _BACKGROUND.search(first)[1]  # type: ignore[index]
        still = self._still % len(self._frames)
        return "\n".join(
            (
                f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}">',
                "<style>",
                "text { font: 20px monospace; white-space: pre }",
                *(f".{name} {{ {style} }}" for style, name in styles.named.items()),
                f".f {{ visibility: hidden; animation-duration: {_short(self.seconds)}s;"
                " animation-timing-function: step-end; animation-iteration-count: infinite }",
                *timing,
                "@media (prefers-reduced-motion: reduce) {"
                f" .f {{ animation: none }} .f{still} {{ visibility: visible }} }}",
                "</style>",
                "<defs>",
                *(f'<g id="{name}">{row}</g>' for row, name in rows.named.items()),
                "</defs>",
                f'<rect width="{width}" height="{height}" rx="8" fill="{ground}"/>',
                '<g transform="translate(26,22)"><circle r="7" fill="#ff5f57"/>'
                '<circle cx="22" r="7" fill="#febc2e"/><circle cx="44" r="7" fill="#28c840"/></g>',
                f'<g transform="translate({_CHROME[0]},{_CHROME[1]})">',
                *groups,
                "</g>",
                "</svg>",
                "",
            )
        )


class _Numbered:
    """Short names of texts, in the order in which they came."""

    def __init__(self, letter: str) -> None:
        self.named: dict[str, str] = {}
        self._letter = letter

    def __getitem__(self, text: str) -> str:
        return self.named.setdefault(text, f"{self._letter}{len(self.named)}")


def _rows(frame: str, rows: _Numbered, styles: _Numbered) -> list[tuple[int, str]]:
    """Return the lines of a frame that are not empty, each with the name of what it shows."""
    known = {name: styles[style.strip()] for name, style in _STYLE.findall(frame)}
    parts: dict[int, list[str]] = {}
    for fill, x, y, width in _RECT.findall(frame):
        line = round((float(y) - 1.5) / _LINE)
        parts.setdefault(line, []).append(
            f'<rect {fill} x="{_short(x)}" y="1.5" width="{_short(width)}" height="24.65"/>'
        )
    for style, x, y, length, text in _TEXT.findall(frame):
        if text.replace("&#160;", "").strip():
            line = round((float(y) - 20) / _LINE)
            parts.setdefault(line, []).append(
                f'<text class="{known[style]}" x="{_short(x)}" y="20" '
                f'textLength="{_short(length)}">{text.replace("&#160;", " ")}</text>'
            )
    return [(line, rows["".join(found)]) for line, found in sorted(parts.items())]


def _keyframes(number: int, begins: float, ends: float, of: float) -> str:
    """Return the rules by which a frame is visible for its time in each round."""
    first, last = 100 * begins / of, 100 * ends / of
    hidden = "0% { visibility: hidden } " if begins else ""
    return (
        f"@keyframes k{number} {{ {hidden}{first:.3f}% {{ visibility: visible }}"
        f" {last:.3f}% {{ visibility: hidden }} }} .f{number} {{ animation-name: k{number} }}"
    )


def _short(number: float | str) -> str:
    """Return a number with as many digits as a picture needs."""
    return f"{float(number):.1f}".removesuffix(".0")

"""Lines of the panel's log."""

from typing import Literal, NamedTuple

MAX_LINES = 40
Tone = Literal["plain", "good", "bad"]


class Line(NamedTuple):
    """Line of the log: time (ns, session clock; 0 if unknown), text, tone, and how often in a row
    it happened.
    """

    at: int
    text: str
    tone: Tone = "plain"
    times: int = 1

    @property
    def text_with_count(self) -> str:
        """The text, with the count if it happened more than once."""
        return f"{self.times} times: {self.text}" if self.times > 1 else self.text


def append(lines: tuple[Line, ...], line: Line) -> tuple[Line, ...]:
    """Return the log with one more line. A repetition is counted instead, so that it pushes nothing
    else out.
    """
    if lines and (lines[-1].text, lines[-1].tone) == (line.text, line.tone):
        return (*lines[:-1], line._replace(times=lines[-1].times + 1))
    return (*lines, line)[-MAX_LINES:]

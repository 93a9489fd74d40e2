"""Log of the panel: lines about the session, and the operator's own acts with their outcome."""

from typing import Any, Literal, NamedTuple

from msgspec.structs import replace

from sar_tui.framework.bus import Topic
from sar_tui.framework.clock import MS, SECOND
from sar_tui.framework.messages import Message, PeerRequestRefused
from sar_tui.link.peer import Frame
from sar_tui.operator.text_charts import cut

MAX_LINES = 40
SLOW = 3 * SECOND
"""An act that the session has not confirmed after this time may never have arrived."""
_LONGEST = 56
Tone = Literal["plain", "good", "bad"]


class Line(NamedTuple):
    """Line of the log: time (ns, session clock), text, tone, and how often in a row it happened."""

    at: int
    text: str
    tone: Tone = "plain"
    times: int = 1

    @property
    def text_with_count(self) -> str:
        """The text, with the count if it happened more than once."""
        return f"{self.times} times: {self.text}" if self.times > 1 else self.text


def append(lines: tuple[Line, ...], line: Line) -> tuple[Line, ...]:
    """Return the log with one more line. A repetition is counted instead, so that it pushes nothing else out."""
    if lines and (lines[-1].text, lines[-1].tone) == (line.text, line.tone):
        return (*lines[:-1], line._replace(times=lines[-1].times + 1))
    return (*lines, line)[-MAX_LINES:]


class SentAct(NamedTuple):
    """Act of this operator: its text in the log, what was sent, and the time (ns) from key to session once known."""

    text: str
    topic: str
    message: Any
    latency: int | None = None
    refused: bool = False

    @property
    def is_pending(self) -> bool:
        """True until the session confirms or refuses it."""
        return self.latency is None and not self.refused

    def line(self, now: int) -> Line:
        """Return its line with the outcome so far."""
        text = cut(self.text, _LONGEST)  # leave room for the outcome
        if self.refused:
            return Line(self.message.at, f"{text}: refused", "bad")
        if self.latency is None and now - self.message.at > SLOW:
            return Line(self.message.at, f"{text}: the session has not confirmed it", "bad")
        if self.latency is None:
            return Line(self.message.at, f"{text} …")
        return Line(self.message.at, f"{text} · link {max(0, self.latency) / MS:.0f} ms", "good")


class ActLog:
    """Acts of this operator, oldest first, and why others were not sent."""

    def __init__(self) -> None:
        self.acts: list[SentAct] = []
        self._reports: list[Line] = []

    def lines(self, now: int) -> list[Line]:
        """Return all lines with the outcomes so far."""
        return [*(act.line(now) for act in self.acts), *self._reports]

    def report(self, at: int, text: str) -> None:
        """Log why something was not done."""
        self._reports = [*self._reports, Line(at, text, "bad")][-MAX_LINES:]

    def add(self, text: str, topic: Topic[Any], message: Message) -> None:
        """Log an act that was sent."""
        self.acts = [*self.acts, SentAct(text, topic.name, message)][-MAX_LINES:]

    def receive(self, frame: Frame, me: str) -> None:
        """Mark the pending act that a message of the session confirms or refuses.

        The session sets the actor and may correct the time, so neither is compared.
        """
        if getattr(frame.message, "actor", None) != me:
            return
        refused = frame.message.what if isinstance(frame.message, PeerRequestRefused) else ""
        for index, act in enumerate(self.acts):
            if not act.is_pending:
                continue
            if act.topic == refused:
                self.acts[index] = act._replace(refused=True)
                return
            if act.topic == frame.topic.name and _content(act.message) == _content(frame.message):
                self.acts[index] = act._replace(latency=frame.at - act.message.at)
                return


def _content(message: Any) -> Any:
    return replace(message, actor="", at=0)

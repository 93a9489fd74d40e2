"""What this operator did: each act until the session has it, and how long that took."""

from typing import Any, NamedTuple

from msgspec.structs import replace

from sar_tui.framework.bus import Topic
from sar_tui.framework.clock import MS, SECOND
from sar_tui.framework.messages import ActRefused, Message
from sar_tui.link.peer import Frame
from sar_tui.operator.event_log import Line
from sar_tui.operator.text_charts import cut

KEPT = 40
_LONGEST = 56
SLOW = 3 * SECOND
"""An act that the session does not confirm for so long may never have arrived."""


class Act(NamedTuple):
    """An act: what it is called, what was sent, and how long (ns) after its key the session had it, once it has."""

    words: str
    topic: str
    message: Any
    latency: int | None = None
    refused: bool = False

    @property
    def is_pending(self) -> bool:
        """Whether nothing is known of it yet."""
        return self.latency is None and not self.refused

    def line(self, now: int) -> Line:
        """As it stands in the log."""
        words = cut(self.words, _LONGEST)  # what became of it has to fit on the line, too
        if self.refused:
            return Line(self.message.at, f"{words}: refused", "bad")
        if self.latency is None and now - self.message.at > SLOW:
            return Line(self.message.at, f"{words}: the session has not confirmed it", "bad")
        if self.latency is None:
            return Line(self.message.at, f"{words} …")
        return Line(self.message.at, f"{words} · link {max(0, self.latency) / MS:.0f} ms", "good")


class ActLog:
    """The acts of one operator, oldest first, and what became of them here."""

    def __init__(self) -> None:
        self.acts: list[Act] = []
        self._told: list[Line] = []

    def lines(self, now: int) -> list[Line]:
        """All of it, as it stands now."""
        return [*(act.line(now) for act in self.acts), *self._told]

    def told(self, at: int, words: str) -> None:
        """Something was not done, and the operator has to know why."""
        self._told = [*self._told, Line(at, words, "bad")][-KEPT:]

    def sent(self, words: str, topic: Topic[Any], message: Message) -> None:
        """An act was sent."""
        self.acts = [*self.acts, Act(words, topic.name, message)][-KEPT:]

    def hear(self, frame: Frame, me: str) -> None:
        """A message of the session's: perhaps it is one of these, arrived, or tells that one was refused.

        The session puts in who it was and may set the time right, so these two do not tell which act it is.
        """
        if getattr(frame.message, "actor", None) != me:
            return
        refused = frame.message.what if isinstance(frame.message, ActRefused) else ""
        for index, act in enumerate(self.acts):
            if act.is_pending and act.topic == refused:
                self.acts[index] = act._replace(refused=True)
                return
            if act.is_pending and act.topic == frame.topic.name and _bare(act.message) == _bare(frame.message):
                self.acts[index] = act._replace(latency=frame.at - act.message.at)
                return


def _bare(message: Any) -> Any:
    return replace(message, actor="", at=0)

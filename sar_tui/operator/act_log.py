"""Log of acts: this operator's and those of others, each with its outcome."""

from typing import Any

from msgspec.structs import replace

from sar_tui.link.peer import Frame, Welcome
from sar_tui.loop.bus import Topic
from sar_tui.model.messages import Message, PeerRequestRefused
from sar_tui.operator.act import ACTS, REFUSED, SLOW, Act
from sar_tui.operator.act_text import KindsOfAction, act_text, is_stop
from sar_tui.operator.event_log import MAX_LINES, Line
from sar_tui.operator.event_text import short_name


class ActLog:
    """Acts, oldest first, and why others were not sent.

    Attributes:
        acts: of this operator, as sent.
        others: of other operators and of the therapist, as the session published them.
    """

    def __init__(self) -> None:
        self.acts: list[Act] = []
        self.others: list[Act] = []
        self._reports: list[Line] = []
        self._kinds = KindsOfAction()

    def awaits_outcome(self, now: int) -> bool:
        """Return True while the lines may change without a message of the session: a missing
        outcome is noted late.
        """
        return any(
            act.is_open and now - act.message.at <= 2 * SLOW for act in (*self.acts, *self.others)
        )

    def lines(self, now: int) -> list[Line]:
        """Return all lines with the outcomes so far. A stop that has arrived has a line of its own
        (`stop.Stop`).
        """
        acts = [
            act
            for act in (*self.acts, *self.others)
            if act.state != "received" or not is_stop(act.message)
        ]
        return [*(act.line(now) for act in acts), *self._reports]

    def report(self, at: int, text: str) -> Line:
        """Log why something was not done; return its line."""
        line = Line(at, text, "bad")
        self._reports = [*self._reports, line][-MAX_LINES:]
        return line

    def add(
        self, text: str, topic: Topic[Any], message: Message, when: str = "", typed: str = ""
    ) -> None:
        """Log an act that was sent."""
        self.acts = [*self.acts, Act(text, topic.name, message, when=when, typed=typed)][
            -MAX_LINES:
        ]

    def unused_text(self, topic: Topic[Any], action: str = "") -> str:
        """Return the text typed last for a topic, or for a decision on an action, if it was
        refused; else empty.
        """
        last = next(
            (act for act in reversed(self.acts) if act.is_typed_for(topic.name, action)), None
        )
        return last.unused_text if last else ""

    def rejoined(self) -> None:
        """Forget what the session will send again, and give up acts whose outcome was missed."""
        self.others = []
        self.acts = [
            act.failed("the outcome is not known") if act.is_open and not act.is_pending else act
            for act in self.acts
        ]

    def receive(self, frame: Frame, me: Welcome) -> None:
        """Follow the outcome of acts, and log those of others."""
        self._kinds.receive(frame.message)
        actor = getattr(frame.message, "actor", None)
        if isinstance(frame.message, PeerRequestRefused) and actor == me.name:
            self._refused(frame.message.what)
        elif frame.topic.name in ACTS:
            self._received(frame, me)
        self.acts = [act.step(frame) for act in self.acts]
        self.others = [act.step(frame) for act in self.others]

    def _refused(self, topic: str) -> None:
        for index, act in enumerate(self.acts):
            if act.is_pending and act.topic == topic:
                self.acts[index] = act.failed(REFUSED if act.typed else "refused")
                return

    def _received(self, frame: Frame, me: Welcome) -> None:
        """Confirm the pending act that the session has published, or log another's."""
        message: Any = frame.message
        if message.actor == me.name:
            for index, act in enumerate(self.acts):
                if act.is_pending and act.is_echoed_by(frame):
                    self.acts[index] = act.received(frame)
                    return
            if any(act.is_echoed_by(frame) for act in self.acts):
                return  # it was confirmed before the connection was lost
        if text := act_text(message, me, self._kinds):
            by = "you" if message.actor == me.name else short_name(message.actor)
            # the therapist's keys have no time stamp
            timed = replace(message, at=message.at or frame.at)
            act = Act(text, frame.topic.name, timed, by=by).received(frame)
            self.others = [*self.others, act][-MAX_LINES:]

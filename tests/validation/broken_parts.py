"""Parts of the framework with one thing broken each, for the controls of the requirements."""

from typing import Any

from msgspec.structs import replace

from sar_tui.loop.bus import Topic
from sar_tui.loop.node import on
from sar_tui.loop.nodes.event_handler import EventHandler
from sar_tui.loop.nodes.memory import Memory
from sar_tui.loop.nodes.perception import Perception
from sar_tui.loop.topics import REPORT
from sar_tui.model.messages import AttemptEnded, Feedback, KeyPerceived, OutputReport
from sar_tui.model.units import MS

LATE_MS = 150
WRONG_BY_MS = 100.0


class LatePerception(Perception):
    """Perceives each key 150 ms late, so that all reaction times are too long."""

    def emit(self, topic: Topic[Any], message: Any) -> None:
        if isinstance(message, KeyPerceived):
            message = replace(message, at=message.at + LATE_MS * MS)
        super().emit(topic, message)


class PraisingEventHandler(EventHandler):
    """Praises every attempt."""

    def emit(self, topic: Topic[Any], message: Any) -> None:
        if isinstance(message, Feedback):
            message = replace(message, valence="positive", reason="goal")
        elif isinstance(message, AttemptEnded) and message.feedback != "none":
            message = replace(message, feedback="positive")
        super().emit(topic, message)


class MisinformedEventHandler(EventHandler):
    """Tells the agent a result that is 100 ms off."""

    def emit(self, topic: Topic[Any], message: Any) -> None:
        if isinstance(message, Feedback) and message.metric is not None:
            message = replace(message, metric=message.metric + WRONG_BY_MS)
        super().emit(topic, message)


class DistractedEventHandler(EventHandler):
    """Goes back to the first level whenever a body has made a gesture."""

    @on(REPORT)
    def body_reported(self, report: OutputReport) -> None:
        """Set the level."""
        if report.part == "gesture" and report.state == "done":
            self.session.scores.set_level(1)


class OwnMemory(Memory):
    """A memory that a task brings along."""

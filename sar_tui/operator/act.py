"""An act of an operator, from the key to its outcome. Pure."""

from typing import Any, Literal, NamedTuple

from msgspec.structs import replace

from sar_tui.link.peer import Frame
from sar_tui.loop.topics import COMMAND, DECISION, LEVEL, MODE, NOTE_ADDED, REMARK
from sar_tui.model.messages import (
    Action,
    ArbiterState,
    Dropped,
    Halt,
    LateDecision,
    LevelDecided,
    OutputReport,
    PromptVoided,
    SessionEnded,
    StepEnded,
    TrialEnded,
    TrialMarked,
    Waiting,
)
from sar_tui.model.units import MS, SECOND
from sar_tui.operator.event_log import Line
from sar_tui.operator.text_charts import cut

ACTS = frozenset(topic.name for topic in (COMMAND, DECISION, REMARK, MODE, NOTE_ADDED))
"""Names of the topics of acts."""
REFUSED = "refused, the text is kept"
"""Why an act failed with a text that somebody typed, and that is offered again."""
_TOO_LATE = "too late, it was decided already"
SLOW = 3 * SECOND
"""An act that the session has not confirmed after this time may never have arrived."""
_LONGEST = 36
_DOING = {
    "Approved": "Approving",
    "Cancelled": "Cancelling",
    "Edited": "Editing",
    "Ended": "Ending",
    "Marked": "Marking",
    "Noted": "Noting",
    "Paused": "Pausing",
    "Repeated": "Repeating",
    "Resumed": "Resuming",
    "Said": "Saying",
    "Skipped": "Skipping",
    "Stopped": "Stopping",
    "Vetoed": "Vetoing",
}
State = Literal["sent", "received", "queued", "under way", "done", "failed"]


class Act(NamedTuple):
    """An act, and what became of it.

    Attributes:
        text: for the log, once it has happened: "Approved feedback".
        topic, message: as sent.
        by: who did it, if it was somebody else.
        when: what a remark waits for: "after the response".
        state: ``sent`` until the session confirms it; ``received``; a remark is then ``queued`` and
            ``under way``; ``done`` only when it has happened.
        latency: time (ns) from the key to the session.
        why: why it failed.
        action: id of the action that it is about.
        typed: text that the operator typed for it.
        parts: of that action, by output, that have begun and not ended.
    """

    text: str
    topic: str
    message: Any
    by: str = ""
    when: str = ""
    state: State = "sent"
    latency: int | None = None
    why: str = ""
    action: str = ""
    typed: str = ""
    parts: frozenset[tuple[str, str]] = frozenset()

    @property
    def is_pending(self) -> bool:
        """True until the session confirms or refuses it."""
        return self.state == "sent"

    @property
    def is_open(self) -> bool:
        """True until its outcome is known."""
        return self.state not in ("done", "failed")

    @property
    def unused_text(self) -> str:
        """Text that was typed, and that the session has refused; else empty."""
        return self.typed if self.state == "failed" and self.why in (REFUSED, _TOO_LATE) else ""

    def is_typed_for(self, topic: str, action: str) -> bool:
        """Return True if its text may be offered again for a topic, or for a decision on an action.

        A decision that came too late can still be said, if it has words.
        """
        if not self.typed:
            return False
        if topic == REMARK.name and self.topic == DECISION.name:
            return self.why == _TOO_LATE and self.message.text is not None
        return self.topic == topic and getattr(self.message, "action", "") == action

    def line(self, now: int) -> Line:
        """Return its line with the outcome so far. Only what has happened is marked as good."""
        text, at = self._named(doing(self.text)), self.message.at
        is_slow = now - at > SLOW
        if self.state == "done":
            link = (
                f" · link {max(0, self.latency) / MS:.0f} ms"
                if self.latency is not None and not self.by
                else ""
            )
            return Line(at, f"{self._named(self.text)}{link}", "good")
        if self.state == "failed":
            return Line(at, f"{text}: {self.why}", "bad")
        if self.state == "sent" and is_slow:
            return Line(at, f"{text}: the session has not confirmed it", "bad")
        if self.state == "queued":
            return Line(at, f"{text}: queued{f', {self.when}' if self.when else ''}")
        if self.state == "received" and is_slow and self.topic != REMARK.name:
            return Line(at, f"{text}: it had no effect", "bad")
        return Line(at, f"{text} …")

    def _named(self, text: str) -> str:
        # leave room for the outcome
        return cut(f"{self.by}: {text}" if self.by else text, _LONGEST)

    def is_echoed_by(self, frame: Frame) -> bool:
        """Return True if the session has published this act. It sets the actor and may correct the
        time.
        """
        return self.topic == frame.topic.name and _content(self.message) == _content(frame.message)

    def received(self, frame: Frame) -> "Act":
        """Return the act after the session has published it. Changes of mode and notes need nothing
        more.
        """
        is_done = self.topic in (MODE.name, NOTE_ADDED.name)
        return self._replace(
            state="done" if is_done else "received",
            latency=frame.at - self.message.at,
            action=getattr(frame.message, "action", ""),
        )

    def failed(self, why: str) -> "Act":
        """Return the act after it has failed."""
        return self._replace(state="failed", why=why)

    def step(self, frame: Frame) -> "Act":
        """Return the act after a message of the session that may tell its outcome."""
        if not self.is_open or self.state == "sent":
            return self
        message = frame.message
        if self.topic == COMMAND.name:
            return self._carried_out(message) if _is_done(self.message, frame) else self
        if self.topic == DECISION.name:
            return self._decided(message)
        return self._said(message)

    def _carried_out(self, message: Any) -> "Act":
        """Return a command after it was carried out: the key of the mark that is on a trial removes
        it.
        """
        is_removed = isinstance(message, TrialMarked) and not message.mark
        text = self.text.replace("Marked", "Unmarked", 1) if is_removed else self.text
        return self._replace(state="done", text=text)

    def _decided(self, message: Any) -> "Act":  # noqa: PLR0911
        match message:
            case LateDecision() if message.what == f"{self.message.verdict} {self.action}":
                return self.failed(_TOO_LATE)
            case Action(id=self.action) | LevelDecided(id=self.action) if self._is_mine(message):
                return self._replace(state="done")
            case Dropped(id=self.action, reason="vetoed") if self._is_mine(message):
                return self._replace(state="done")
            case ArbiterState() if any(
                one.id == self.action and self._is_mine(one) for one in message.queued
            ):
                return self._replace(state="done")
            case Halt(action=self.action, reason="vetoed"):
                return self._replace(state="under way")
            case OutputReport(action=self.action, state="failed") if self.state == "under way":
                return self.failed(f"not confirmed: {message.output}")
            case ArbiterState() if self.state == "under way" and not _is_current(
                message, self.action
            ):
                return self._replace(state="done")
        return self

    def _said(self, message: Any) -> "Act":
        match message:
            case ArbiterState() if self.state == "received":
                action = next(
                    (one.id for one in reversed(message.queued) if self._is_remark(one)), ""
                )
                return self._replace(state="queued", action=action) if action else self
            case Action() if (
                self.state == "received" and self._is_remark(message)
            ) or message.id == self.action:
                return self._replace(state="under way", action=message.id)
            case Dropped(id=self.action):
                return self.failed(f"not done ({message.reason})")
            case OutputReport(action=self.action):
                return self._reported(message)
        return self

    def _reported(self, report: OutputReport) -> "Act":
        """Follow the parts of a remark. Text on a screen counts as shown at once: it stays until
        other text comes.
        """
        part = (report.output, report.part)
        if report.state == "queued":
            return self._replace(parts=self.parts | {part})
        why = {
            "failed": f"not confirmed: {report.output}",
            "aborted": "stopped before its end",
        }.get(report.state, "")
        is_over = report.state != "started" or report.part == "show"
        after = self._replace(parts=self.parts - {part}, why=self.why or why) if is_over else self
        if after.parts or not is_over:
            return after
        return after.failed(after.why) if after.why else after._replace(state="done")

    def _is_mine(self, message: Any) -> bool:
        return bool(message.actor == self.message.actor)

    def _is_remark(self, action: Action) -> bool:
        """Return True if an action is what the session made of this remark."""
        own, remark = action.decision == "initiated" and self._is_mine(action), self.message
        return (
            own
            and (action.seat, action.text) == (remark.seat, remark.text)
            and (not remark.gesture or action.gesture == remark.gesture)
        )


def doing(text: str) -> str:
    """Return the text of an act that has not happened yet: "Approving feedback" for "Approved
    feedback".
    """
    first, _, rest = text.partition(" ")
    word = first.rstrip(":")
    return f"{_DOING.get(word, word)}{first[len(word) :]} {rest}".strip()


def _is_current(state: ArbiterState, id: str) -> bool:
    return state.current is not None and state.current.id == id


def _is_done(act: Any, frame: Frame) -> bool:  # noqa: PLR0911
    """Return True if a message shows that a command was carried out."""
    message = frame.message
    match act.command:
        case "pause":
            return isinstance(message, Waiting) and message.stage == "paused"
        case "resume":
            return isinstance(message, Waiting) and message.stage != "paused"
        case "end":
            return isinstance(message, SessionEnded) or (
                isinstance(message, Waiting) and message.stage == "ended"
            )
        case "skip":
            if act.reason == "step":
                return isinstance(message, StepEnded) and message.number == act.value
            is_rest_over = isinstance(message, Waiting) and message.stage == "attempt"
            return isinstance(message, TrialEnded) or (act.reason == "rest" and is_rest_over)
        case "repeat":
            return isinstance(message, PromptVoided) and message.reason == "repeat"
        case "mark":
            return isinstance(message, TrialMarked)
        case "level":
            return frame.topic.name == LEVEL.name
    return False


def _content(message: Any) -> Any:
    return replace(message, actor="", at=0)

"""Node that sends a session's markers."""

import threading
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, ClassVar, Literal

from sar_tui.loop import topics as t
from sar_tui.loop.bus import Bus, Topic
from sar_tui.loop.clock import Clock
from sar_tui.loop.node import Node
from sar_tui.loop.topics import MARKERS
from sar_tui.model import messages as m
from sar_tui.model.messages import MarkersChanged, Message, Shown
from sar_tui.outputs.markers.marker import Destination, Fields, Marker
from sar_tui.outputs.markers.sender import Changed, Sender


class MarkerNode(Node):
    """Sends markers of the session's messages, and reports what became of them.

    It hands each marker to the threads that send it, and never waits.

    Args:
        destinations: where to.
        session: the session's id.
        task: its task's name.
        seats: the task's seats.
        clock: the session's clock.
    """

    name = "markers"
    emits: ClassVar[tuple[Topic[MarkersChanged], ...]] = (MARKERS,)

    def __init__(
        self,
        destinations: Sequence[Destination],
        session: str,
        task: str,
        seats: Sequence[str],
        clock: Clock,
    ) -> None:
        self._translation = Translation(session, seats)
        self._clock = clock
        self._early: list[MarkersChanged] | None = []
        self._lock = threading.Lock()
        self._is_attached = self._is_detached = False
        self._senders = [
            Sender(destination, session, task, self._change_of(destination.address), clock.now)
            for destination in destinations
        ]

    def attach(self, bus: Bus) -> None:
        """Join a bus, and report what happened to the destinations until now."""
        super().attach(bus)
        for topic in self._translation.topics:
            bus.subscribe(topic, partial(self._handle, topic), self.name)
        self._is_attached = True
        with self._lock:
            early, self._early = self._early, None
        for change in early or ():
            bus.post(MARKERS, change)

    def detach(self) -> None:
        """Send what is left, and report how many markers were sent and lost."""
        if self._is_detached:
            return
        self._is_detached = True
        for sender in self._senders:
            sender.finish()
            late_ms = sender.late_ms
            self._report(
                MarkersChanged(
                    destination=sender.address,
                    state="closed",
                    at=self._clock.now(),
                    detail=sender.closing,
                    sent=sender.sent,
                    lost=sender.lost,
                    unheard=sender.unheard,
                    late_ms=late_ms[0] if late_ms else None,
                    latest_ms=late_ms[1] if late_ms else None,
                )
            )

    def shown(self, shown: Shown) -> None:
        """Send the marker of a prompt that has just reached the terminal. Called from the thread
        that wrote it.
        """
        for marker in self._translation.shown(shown):
            self._put(marker)

    def _handle(self, topic: Topic[Any], message: Message) -> None:
        """Send the markers of a message, unless it was kept from an earlier run."""
        if self._is_attached:
            for marker in self._translation.markers(topic, self.now, message):
                self._put(marker)

    def _put(self, marker: Marker) -> None:
        for sender in self._senders:
            sender.put(marker)

    def _change_of(self, address: str) -> Changed:
        """Return the function that a sender's thread calls when its destination changes."""

        def changed(state: Literal["open", "failing", "working"], detail: str) -> None:
            self._report(
                MarkersChanged(
                    destination=address, state=state, at=self._clock.now(), detail=detail
                )
            )

        return changed

    def _report(self, change: MarkersChanged) -> None:
        with self._lock:
            if self._early is not None:
                self._early.append(change)
                return
        self.bus.post(MARKERS, change)


_PARTS = {"say": "utterance", "show": "text", "gesture": "gesture", "tone": "tone", "gaze": "gaze"}
_OVER = ("done", "aborted", "failed")
_Key = tuple[int, int, int]
"""A presentation of a prompt: attempt, trial, presentation."""


class Translation:
    """Turns messages into markers.

    Times are the stamps in the messages: of a prompt the flush of its frame, of a response its key.
    Only an event that has no stamp of its own is at the time of its message. What was said, codes
    of participants, names of operators and reasons for a pause never become part of a marker.

    Args:
        session: the session's id.
        seats: of the task; a marker has a ``seat`` only if there are several.
    """

    def __init__(self, session: str, seats: Sequence[str] = ("A",)) -> None:
        self._session = session
        self._has_seats = len(seats) > 1
        self._prompt: m.Prompt | None = None
        self._onsets: tuple[_Key, dict[int, int]] = (0, 0, 0), {}
        self._kinds: dict[str, str] = {}
        self._started: set[tuple[str, str, str]] = set()
        self._translate: dict[Topic[Any], Callable[[int, Any], Sequence[Marker]]] = {
            t.SESSION: self._session_started,
            t.SESSION_ENDED: lambda at, ended: [
                Marker("session_end", at, {"status": ended.status})
            ],
            t.ATTEMPT_STARTED: self._attempt_started,
            t.ATTEMPT_ENDED: self._attempt_ended,
            t.CUE: self._cued,
            t.SYNC: self._signalled,
            t.PROMPT: self._prompted,
            t.SHOWN: lambda _, shown: self.shown(shown),
            t.TONE_BEGAN: self._tone_began,
            t.VOIDED: lambda at, voided: [Marker("prompt_cancelled", at, self._trial(voided))],
            t.TRIAL: self._trial_ended,
            t.TRIAL_FEEDBACK_SHOWN: lambda _, seen: [
                Marker("trial_feedback", seen.at, self._trial(seen))
            ],
            t.ACTION: self._acted,
            t.REPORT: self._reported,
            t.DECISION: lambda at, made: [
                self._act("decision", at, made, action=made.action, is_=made.verdict)
            ],
            t.REMARK: lambda at, made: [self._act("remark", at, made, source=made.source)],
            t.COMMAND: self._commanded,
            t.MARKED: self._marked,
            t.NOTE_ADDED: lambda at, note: [self._act("note", at, note, label=note.label)],
            t.LEVEL: lambda at, change: [
                Marker("level", at, self._seat(change) | {"level": change.level})
            ],
        }

    @property
    def topics(self) -> tuple[Topic[Any], ...]:
        """The topics with messages that matter."""
        return tuple(self._translate)

    def markers(self, topic: Topic[Any], at: int, message: m.Message) -> Sequence[Marker]:
        """Return the markers of a message of one of the topics, which was published ``at`` (ns)."""
        return self._translate[topic](at, message)

    def shown(self, shown: m.Shown) -> Sequence[Marker]:
        """Return the marker of an onset of a prompt or of one of its later frames; none if it was
        returned before.

        May be called from the writing thread.
        """
        key = shown.attempt, shown.trial, shown.presentation
        if self._onsets[0] != key:
            self._onsets = key, {}
        if shown.frame in self._onsets[1]:
            return ()
        self._onsets[1][shown.frame] = shown.at
        fields: Fields = {
            "attempt": shown.attempt,
            "trial": shown.trial,
            "presentation": shown.presentation,
        }
        if shown.frame:
            return [Marker("frame_onset", shown.at, fields | {"frame": shown.frame})]
        prompt = self._prompt
        if prompt and (prompt.attempt, prompt.trial, prompt.presentation) == key:
            fields |= self._seat(prompt) | {"level": prompt.level, "stimulus": prompt.stimulus}
        return [Marker("prompt_onset", shown.at, fields)]

    def _session_started(self, at: int, started: m.SessionStarted) -> Sequence[Marker]:
        return [
            Marker(
                "session_start",
                at,
                {"session": self._session, "task": started.task, "run": started.run},
            )
        ]

    def _attempt_started(self, at: int, started: m.AttemptStarted) -> Sequence[Marker]:
        fields: Fields = {
            "attempt": started.attempt,
            "level": started.level,
            "practice": started.practice,
        }
        return [Marker("attempt_start", at, self._seat(started) | fields)]

    def _attempt_ended(self, at: int, ended: m.AttemptEnded) -> Sequence[Marker]:
        if ended.ended != at:  # scored again
            return ()
        return [Marker("attempt_end", ended.ended, self._seat(ended) | {"attempt": ended.attempt})]

    def _cued(self, at: int, cue: m.CueGiven) -> Sequence[Marker]:
        return [Marker("cue", at, self._trial(cue) | {"side": cue.side})]

    def _signalled(self, _: int, signal: m.SyncSignal) -> Sequence[Marker]:
        return [Marker(f"sync_{signal.what}", signal.at, {"source": signal.source})]

    def _prompted(self, _: int, prompt: m.Prompt) -> Sequence[Marker]:
        self._prompt = prompt
        return ()

    def _tone_began(self, _: int, began: m.ToneBegan) -> Sequence[Marker]:
        if began.source == "failed":
            return ()
        return [
            Marker(
                "prompt_tone",
                began.at,
                self._trial(began) | {"frame": began.frame, "source": began.source},
            )
        ]

    def _trial_ended(self, at: int, trial: m.TrialEnded) -> Sequence[Marker]:
        fields: Fields = self._trial(trial) | {"stimulus": trial.stimulus, "correct": trial.correct}
        if trial.response_at is None:
            return [Marker("miss", at, fields)]
        key, onsets = self._onsets
        is_known = key[:2] == (trial.attempt, trial.trial)
        if trial.onset is None or not is_known or trial.onset in onsets.values():
            return [
                Marker("response", trial.response_at, fields | {"response": trial.response or ""})
            ]
        return [
            Marker("movement_start", trial.onset, fields),
            Marker("movement_end", trial.response_at, fields),
        ]

    def _acted(self, _: int, action: m.Action) -> Sequence[Marker]:
        self._kinds[action.id] = action.kind
        return ()

    def _reported(self, _: int, report: m.OutputReport) -> Sequence[Marker]:
        """Return the beginning of a part, and the end of one that began."""
        key = report.output, report.action, report.part
        if report.state == "started" and key not in self._started:
            self._started.add(key)
            end = "start"
        elif report.state in _OVER and key in self._started:
            self._started.remove(key)
            end = "end"
        else:
            return ()
        fields: Fields = {"action": report.action, "output": report.output}
        if kind := self._kinds.get(report.action):
            fields["kind"] = kind
        if end == "end":
            fields["state"] = report.state
        return [Marker(f"{_PARTS[report.part]}_{end}", report.at, fields)]

    def _commanded(self, at: int, act: m.SessionCommand) -> Sequence[Marker]:
        """Return the marker of a command, except a mark, whose effect has one."""
        return [] if act.command == "mark" else [self._act("command", at, act, command=act.command)]

    def _marked(self, at: int, marked: m.TrialMarked) -> Sequence[Marker]:
        return [
            Marker(
                "mark", at, self._trial(marked) | {"mark": marked.mark, "correct": marked.correct}
            )
        ]

    def _act(self, event: str, at: int, act: Any, is_: str = "", **fields: str) -> Marker:
        """Return the marker of an operator's act, at the stamp of their key if it has one."""
        verdict: Fields = {"verdict": is_} if is_ else {}
        return Marker(event, act.at or at, {**fields, **verdict})

    def _trial(self, message: Any) -> Fields:
        return self._seat(message) | {"attempt": message.attempt, "trial": message.trial}

    def _seat(self, message: m.Message) -> Fields:
        return {"seat": message.seat} if self._has_seats and message.seat else {}

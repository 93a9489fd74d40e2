"""A live session in the app: its run, its two workers, and its end."""

import asyncio
import contextlib
import secrets
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import msgspec
from msgspec.structs import replace

from sar_tui.app.guarded_view import GuardedView
from sar_tui.app.screen_output import ScreenOutput
from sar_tui.inputs.keyboard import Keyboard
from sar_tui.loop.bus import FAULT
from sar_tui.loop.clock import Clock, LiveClock
from sar_tui.loop.node import Node
from sar_tui.loop.session import Session
from sar_tui.loop.task import Task
from sar_tui.loop.topics import COMMAND, MARKERS, PRESENCE, RECALL, SYNC, TONE_BEGAN
from sar_tui.model.messages import (
    Fault,
    MarkersChanged,
    OperatorChanged,
    Recall,
    SessionCommand,
    SyncSignal,
    ToneBegan,
)
from sar_tui.model.theme import Theme
from sar_tui.model.units import SECOND
from sar_tui.outputs.prompt_tones import PromptTones
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import TaskParameters
from sar_tui.runs.plan import Failed, Plan
from sar_tui.runs.run import Progress, Run, output_nodes, resume, start
from sar_tui.store import sessions
from sar_tui.store.database import StoreError, connect, connect_to_read

if TYPE_CHECKING:
    from textual.app import App

    from sar_tui.app.screen_output import Stage
    from sar_tui.inputs.imu_feed import ImuFeed
    from sar_tui.link.broker_process import BrokerProcess
    from sar_tui.link.node import LinkNode
    from sar_tui.outputs.markers.node import MarkerNode
    from sar_tui.store.database import StoreConnection

_NOT_MARKED = "The session was started by mistake, but it could not be marked as such, and counts."
LAST_WRITE_SECONDS = 5.0
"""Longest wait for the disk at the end of a session."""


class LiveSession:
    """Starts, runs and ends a session.

    It has two Textual workers: ``session`` runs the bus with perception and event handling;
    ``storage`` is the thread that writes to the database. ``close`` ends both.

    Args:
        refusal: returns why the prompts of a task cannot be shown here, with this seed; empty if
            they can.
        is_plain: True if its stage appends lines.

    Attributes:
        markers: sends markers; None if nobody asked for them.
        study: name of the study that the session belongs to; empty if it is of none.
        trouble: says to the therapist why markers are lost, tones not heard or visits not possible,
            until somebody was told; else empty.
        visitors: names of those who watch, after the participant has agreed to it.
    """

    def __init__(
        self,
        folder: Path,
        catalogue: Catalogue,
        clock: Clock | None = None,
        feeds: "Sequence[ImuFeed]" = (),
        link: "BrokerProcess | None" = None,
        markers: Sequence[str] = (),
        refusal: Callable[[Task, int], str] = lambda task, seed: "",
        *,
        is_plain: bool = False,
    ) -> None:
        self._refusal = refusal
        self._is_plain = is_plain
        self.clock = clock or LiveClock(asyncio.get_running_loop())
        self._feeds = feeds
        self._link = link
        self._peers: LinkNode | None = None
        self._destinations = markers
        self.markers: MarkerNode | None = None
        self.trouble = ""
        self.keyboard = Keyboard()
        self.screen: ScreenOutput
        self.view: GuardedView
        self.run: Run
        self.codes: dict[str, str] = {}
        self._folder = folder
        self._catalogue = catalogue
        self._stopping = False
        self._closed = False
        self.is_mistake = False
        self.study = ""
        self.visitors: tuple[str, ...] = ()
        self._had_visitor = False

    def open(self, stage: "Stage", what: Plan | str, progress: Progress | None = None) -> None:
        """Open a new session (a plan) or an interrupted one (its id). Raises like `runs.run.start`
        and `resume`.
        """
        self._stage = stage
        self._session_id = what.id if isinstance(what, Plan) else what
        try:
            where = self._folder, self._catalogue, self.clock, self._nodes
            if isinstance(what, Plan):
                self.run = start(what, *where, plain=self._is_plain)
            else:
                self.run = resume(what, *where, progress, plain=self._is_plain)
        except BaseException:
            if self.markers:
                self.markers.detach()
            raise
        self.codes = self.run.participants
        self.study = self._study_of(what)
        if self._link and self._peers:
            from sar_tui.link.peer import session_welcome

            session = self.run.session
            task = session.task
            self._peers.trial_mark = lambda: session.trial_mark
            self._peers.welcome = session_welcome(
                task, self.run.id, self._link.link, self.run.participants
            )

    def _study_of(self, what: Plan | str) -> str:
        """Return the name of the study that a session belongs to; empty if it is of none."""
        if isinstance(what, Plan):
            return what.study.study if what.study else ""
        with closing(connect_to_read(self._folder)) as database:
            row = sessions.stored(database, what)
        return str(row["study"]["study"]) if row and row["study"] else ""

    def _nodes(self, task: Task, theme: Theme, seed: int) -> list[Node]:
        """Make the nodes for keyboard, sensors, the task's view, the outputs and the link.

        The link comes first, so that it is told which sensors and outputs there are. Raises Failed
        if the task's prompts cannot be shown here.
        """
        if why := self._refusal(task, seed):
            raise Failed(why)
        shows_agent = "screen" in task.parameters.outputs
        self.screen = ScreenOutput(self._stage, theme, shows_agent=shows_agent)
        self.view = GuardedView(task)
        inputs = [*self._linked(), self.keyboard, *self._marked(task)]
        outputs = [
            self.view,
            self.screen,
            PromptTones(task.parameters.speech),
            *output_nodes(task, theme),
        ]
        if not task.sensor_seats(task.parameters):
            return [*inputs, *outputs]
        from sar_tui.runs.sensors import open_sensors, sensor_nodes

        feeds = self._feeds or open_sensors(
            type(task), task.parameters, seed, self.clock, self._folder
        )
        return [*inputs, *sensor_nodes(task, seed, *feeds), *outputs]

    @property
    def can_be_joined(self) -> bool:
        """True if operators can join, or may have joined, through a link; in a visit, if somebody
        has.
        """
        return self._link is not None and (not self._link.is_visit or self._had_visitor)

    def _presence_changed(self, change: OperatorChanged) -> None:
        self.visitors = tuple(change.peers)
        self._had_visitor |= bool(self.visitors)

    def _linked(self) -> "list[LinkNode]":
        """Return the node of the link, if there is a link."""
        if self._link:
            from sar_tui.link.node import LinkNode

            self._peers = LinkNode(self._link)
        return [self._peers] if self._peers else []

    def _marked(self, task: Task) -> "list[MarkerNode]":
        """Return the node that sends markers, if somebody asked for them."""
        if self._destinations:
            from sar_tui.outputs.markers.destinations import make_destinations
            from sar_tui.outputs.markers.node import MarkerNode

            made = make_destinations(self._destinations)
            self.markers = MarkerNode(made, self._session_id, task.name, task.seats, self.clock)
        return [self.markers] if self.markers else []

    def begin(self, app: "App[int]", broken: Callable[[str], None]) -> None:
        """Start both workers and the loop. ``broken`` is called with a sentence if the task fails."""
        if isinstance(self.clock, LiveClock):
            app.run_worker(
                self.clock.run(),
                name="session",
                group="session",
                description="bus, perception, events",
            )
            app.run_worker(
                self._store, name="storage", group="storage", thread=True, description="SQLite"
            )
        self.begin_loop(broken)

    def begin_loop(self, broken: Callable[[str], None]) -> None:
        """Start the loop: the caller runs the clock, and calls ``store``."""

        def faulted(fault: Fault) -> None:
            if self.run.session.broken is fault:
                broken(
                    f"The task {self.session.task.name} failed ({fault.error}, {fault.place}). "
                    "What was done so far is kept."
                )

        self.run.session.bus.subscribe(FAULT, faulted)
        self.run.session.bus.subscribe(MARKERS, self._markers_changed)
        self.run.session.bus.subscribe(TONE_BEGAN, self._tone_began)
        if self._link and self._link.is_visit:
            self.run.session.bus.subscribe(PRESENCE, self._presence_changed)
        self.clock.call_soon(self.run.begin)

    def _markers_changed(self, change: MarkersChanged) -> None:
        if change.state == "failing":
            self.trouble = f"No markers go to {change.destination}: {change.detail}"
        elif change.state == "working" and self.trouble:
            self.trouble = f"{self.trouble} Later they did again."

    def _tone_began(self, began: ToneBegan) -> None:
        if began.source == "failed":
            self.trouble = f"The tones of the prompts are not heard. {began.detail}"

    def signal(
        self, what: Literal["flash", "tone"], at: int, source: Literal["flush", "refresh", "sound"]
    ) -> None:
        """Report a signal for cameras to the session, from any thread."""
        self.run.session.bus.post(SYNC, SyncSignal(what=what, at=at, source=source))

    def stamp(self, seconds: float) -> float:
        """Convert the time of a terminal event to the session's clock (s), which differs if it is
        advanced by hand.
        """
        return seconds if isinstance(self.clock, LiveClock) else self.clock.now() / SECOND

    def store(self) -> None:
        """Write to the database until the session is stopped. Call it once, in a thread of its
        own.
        """
        self.run.recorder.run(lambda: self._stopping)

    def _store(self) -> None:
        from textual.worker import get_current_worker

        worker = get_current_worker()
        self.run.recorder.run(lambda: self._stopping or worker.is_cancelled)

    def operate(self, act: SessionCommand) -> None:
        """Send an operator's act to the session. Operators' panels show what became of a
        therapist's.
        """
        if act.actor == "therapist":
            act = replace(act, id=secrets.token_hex(8))
        self.run.session.bus.post(COMMAND, act)

    def undo_keys(self, *actors: str) -> tuple[str, ...]:
        """Return the keys that take back now what one of these people did last. In a trial,
        Backspace may be a response; while somebody types, it deletes.
        """
        if self.session.undoable(*actors) is None:
            return ()
        return ("ctrl+z",) if self.session.takes_backspace else ("ctrl+z", "backspace")

    def undo(self, *actors: str) -> None:
        """Take back what one of these people did last, if it can be."""
        if done := self.session.undoable(*actors):
            self.operate(SessionCommand(command="undo", actor=done.actor))

    @property
    def session(self) -> Session:
        """The session, once it is open."""
        return self.run.session

    @property
    def is_closed(self) -> bool:
        """True once the session was closed."""
        return self._closed

    @property
    def in_first_attempt(self) -> bool:
        """True as long as no attempt is finished: until then the session may have been started by
        mistake.
        """
        session = self.session
        seats = session.task.seats
        return not any(session.bus.call(RECALL, Recall(seat=seat)).attempts for seat in seats)

    @property
    def asks_after(self) -> bool:
        """True if pain and tiredness are to be asked now: the session was ended, and is in the
        database.
        """
        session = self.run.session
        asks = session.task.parameters.ask_wellbeing and not (
            self.is_mistake or session.awaits_agreement
        )
        return asks and session.ended and not (self.rescued or self.unsaved)

    @property
    def rescued(self) -> str:
        """Text that says where the session is, and why, if it is not in the database; else
        empty.
        """
        return self.run.recorder.safeguard.text if self.run.recorder.safeguard else ""

    @property
    def unsaved(self) -> int:
        """Number of messages that are not yet on the disk."""
        return self.run.recorder.pending

    def release(self) -> None:
        """Release devices at once; their last reports are recorded if the recorder still runs."""
        self.run.session.detach()
        if not self.run.recorder.wait(0):
            self.run.session.bus.drain()

    def stop(self, app: "App[int]") -> None:
        """Release devices and stop both workers; the storage thread first writes the remaining
        messages.
        """
        self.release()
        self._stopping = True
        app.workers.cancel_group(app, "session")
        self.run.recorder.wake()

    def is_written(self, seconds: float) -> bool:
        """Return True if a stopped session has written all that it can, at the latest after
        ``seconds``.
        """
        return not isinstance(self.clock, LiveClock) or self.run.recorder.wait(seconds)

    def write_rest(self) -> bool:
        """Let the storage thread write what is left, and stop. Return False if that takes too long.
        From any thread.
        """
        self._stopping = True
        self.run.recorder.wake()
        return self.is_written(LAST_WRITE_SECONDS)

    def close(self, app: "App[int]") -> None:
        """Stop both workers, write the remaining messages, and close the session.

        If the disk is too slow, the session stays locked while the thread writes, and ``unsaved``
        counts the messages that are left.
        """
        if not self._closed:
            self.stop(app)
            self.finish()

    def finish(self) -> None:
        """Write what is left of a session that was stopped, and close it: as `close` says."""
        self._closed = True
        if not self.is_written(LAST_WRITE_SECONDS):
            self.trouble = _NOT_MARKED if self.is_mistake else self.trouble
            return
        if not isinstance(self.clock, LiveClock):
            with contextlib.suppress(StoreError):
                self.run.recorder.write()
        is_stored = not (self.rescued or self.unsaved)
        self.run.close()
        if self.is_mistake:
            if is_stored:
                self._discard()
            else:
                self.trouble = _NOT_MARKED

    def _discard(self) -> None:
        """Mark the session as started by mistake, so that it does not count."""
        from sar_tui.store.record_changes import BY_MISTAKE, change_status

        try:
            with closing(connect(self._folder)) as database:
                change_status(
                    database,
                    self._folder,
                    self.run.id,
                    "discarded",
                    actor="participant",
                    reason=BY_MISTAKE,
                )
        except StoreError as error:
            self.trouble = f"{_NOT_MARKED} {error}"


@contextlib.contextmanager
def link_of(
    what: Plan | str,
    database: "StoreConnection",
    folder: Path,
    warn: Callable[[str], object] = lambda why: None,
) -> Iterator["BrokerProcess | None"]:
    """Open the link of a session for the duration of the block, if its settings let operators join,
    or this is a home that dials out; else give None.

    It listens on this machine only, as with ``sar-tui run --operator``; or nowhere.

    Args:
        what: the plan of a new session, which has an id; or the id of an interrupted one.
        database, folder: where that session is.
        warn: told why nobody can visit this home, although it dials out.

    Raises:
        StoreError: there is no such session.
        LinkError: the link cannot be opened.
    """
    if isinstance(what, Plan):
        session, task, can_join = what.id, what.task.name, what.parameters.operator_joins
        codes, settings = what.participants, msgspec.to_builtins(what.parameters)
        lost_ms = what.parameters.operator_lost_ms
        study = what.study.study if what.study else ""
    else:
        row, default = sessions.find(database, folder, what), TaskParameters()
        session, task, codes = row["id"], row["task"], sessions.codes(row)
        settings = row["parameters"]
        can_join = settings.get("operator_joins", default.operator_joins)
        lost_ms = settings.get("operator_lost_ms", default.operator_lost_ms)
        study = str(row["study"]["study"]) if row["study"] else ""
    if not can_join:
        from sar_tui.app.visits import open_visits

        with open_visits(folder, database, settings, codes, study, lost_ms, warn) as link:
            yield link
        return
    from sar_tui.link.listening import ListenOptions, open_link

    with open_link(
        folder, session, task, codes, ListenOptions(operator=True, end=None), lost_ms
    ) as link:
        yield link

"""A run of the program on a session: starts or resumes it, with its nodes, recorder and locks."""

import sqlite3
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any, TypedDict

from filelock import BaseFileLock

from sar_tui.loop.bus import Record
from sar_tui.loop.clock import Clock, VirtualClock
from sar_tui.loop.node import Node
from sar_tui.loop.session import RULES, Parts, ReplayError, Session
from sar_tui.loop.task import Task
from sar_tui.model.language import Sentence
from sar_tui.model.messages import SessionStarted
from sar_tui.model.session_mode import SessionMode, is_personal
from sar_tui.model.theme import Theme
from sar_tui.plugins import DEFAULT_THEME, Catalogue, PluginError, task_code, task_source
from sar_tui.rules.declaration import ParameterError
from sar_tui.rules.limits import Dose, limits_day, reached_of_day
from sar_tui.rules.parameters import build, fields
from sar_tui.runs.plan import EnoughToday, Failed, Plan, set_up
from sar_tui.runs.start_level import with_start_level
from sar_tui.store import locks, messages, participants, sessions
from sar_tui.store.database import StoreError, commit_unsynced, connect, open_file
from sar_tui.store.people_events import check_may_record
from sar_tui.store.provenance import machine, measured_timing, software
from sar_tui.store.record_changes import check_not_erased
from sar_tui.store.recorder import Recorder
from sar_tui.store.rescue import rescue_files
from sar_tui.store.safeguard import Safeguard, forget
from sar_tui.store.training_days import done_on_day, utc

_LAST_WAIT_MS = 1000
"""Longest wait for a database that another program keeps locked, while a session is written and
left.
"""

_TOLD_EVERY = 100
"""Messages of a replay from one report of its progress to the next."""

Progress = Callable[[int, int], None]
NodeFactory = Callable[[Task, Theme, int], Sequence[Node]]
"""Makes the input and output nodes of a session from its task, theme and seed."""


class Run:
    """A session in progress in this program. Made by ``start`` or ``resume``; always call ``close``
    at its end.

    Attributes:
        theme_notice: text that says why the session goes on with another theme than it began with;
            else empty.
    """

    def __init__(
        self,
        session_id: str,
        number: int,
        session: Session,
        recorder: Recorder,
        database: sqlite3.Connection,
        held: Sequence[BaseFileLock],
        folder: Path,
        now: Callable[[], str],
    ) -> None:
        self.id = session_id
        self._folder = folder
        self.theme_notice = ""
        self.number = number
        self.session = session
        self.recorder = recorder
        self._database = database
        self._locks = held
        self._now = now

    @property
    def participants(self) -> dict[str, str]:
        """The participants' codes by seat."""
        return {
            row["seat"]: row["participant"]
            for row in sessions.rows(self._database, "seats", self.id)
        }

    def begin(self) -> None:
        """Start the loop."""
        self.session.begin(self.number)

    def check(self) -> None:
        """Raise Failed if a vital node has failed."""
        if fault := self.session.broken:
            name = self.session.task.name
            raise Failed(
                f"The task {name} failed ({fault.error}, {fault.place}). What was done so far is "
                "kept."
            )

    def close(self) -> None:
        """Detach the nodes and release the locks. A session that has not ended is stored as
        interrupted.
        """
        try:
            self.session.detach()
            if self.rescue_file:
                with closing(open_file(self.rescue_file)) as database:
                    self._leave(database)
            else:
                self._database.execute(f"PRAGMA busy_timeout={_LAST_WAIT_MS}")
                self._leave(self._database)
                if self.recorder.safeguard:
                    forget(self._database, self._folder, self.id)
        except (StoreError, sqlite3.Error):
            pass  # a session that is running but not locked counts as interrupted, too
        finally:
            _release(self._database, self._locks)

    def _leave(self, database: sqlite3.Connection) -> None:
        if not self.session.ended:
            sessions.interrupt(database, self.id, self._now())

    @property
    def rescue_file(self) -> Path | None:
        """The rescue file in which the session went on; None if it is in the database."""
        return self.recorder.safeguard.file if self.recorder.safeguard else None


def start(
    plan: Plan,
    folder: Path,
    catalogue: Catalogue,
    clock: Clock,
    make_nodes: NodeFactory,
    parts: Parts | None = None,
    began: datetime | None = None,
    *,
    plain: bool = False,
) -> Run:
    """Store a new session, and build its run, ready to begin.

    Args:
        plan: the session to start.
        folder: the data folder.
        catalogue: where the theme is found.
        clock: live or virtual.
        make_nodes: makes the input and output nodes.
        parts: the classes of the framework's nodes, if not its own.
        began: when the session begins, of which all its times of day follow by the clock; None for
            the present, and times of day as they are.
        plain: True if prompts are lines that are appended, which is stored with the terminal.

    Raises:
        StoreError: the database cannot be used, or a participant is in a live session.
        PluginError: the theme cannot be loaded.
        ParameterError: an output cannot be opened.
        Failed: the task cannot be set up, or (`EnoughToday`) the participant has done enough today.
    """
    theme = catalogue.theme(plan.theme, plan.parameters.language)
    task = set_up(plan.task, plan.parameters)
    database = connect(folder)
    if plan.mode == "demonstration":
        commit_unsynced(database)
    held: list[BaseFileLock] = []
    with _released_on_failure(database, held):
        if is_personal(plan.mode):
            task = set_up(plan.task, with_start_level(database, task, plan.participant))
        nodes = make_nodes(task, theme, plan.seed)
        codes = list(plan.participants)
        if is_personal(plan.mode):
            codes = [participants.add(database, code, began) for code in codes]
            held += [locks.hold(folder, "participant", code) for code in codes]
        facts = _participant_facts(database, task, codes, plan.mode, now=began)
        _check_day(task, codes[0], facts["done_today"])
        session = Session(
            task, theme, clock, plan.seed, nodes, **facts, steps=plan.steps, parts=parts
        )
        session_id = plan.id or sessions.new_id()
        held.append(locks.hold(folder, "session", session_id))
        provenance = _provenance(plan.task, theme.name, folder, catalogue, plain=plain)
        sessions.create(
            database,
            session_id,
            task=task.name,
            theme=theme.name,
            participant=codes[0],
            seed=plan.seed,
            parameters=task.parameters,
            mode=plan.mode,
            partner=codes[1] if len(codes) > 1 else "",
            programme=plan.programme,
            study=plan.study,
            now=began,
            **provenance,
        )
        number = sessions.begin_run(
            database, session_id, clock_ns=clock.now(), now=began, **provenance
        )
        now = _time_of_day(clock, began) if began else utc
        return _with_recorder(session_id, number, session, folder, database, held, now)


def resume(
    session_id: str,
    folder: Path,
    catalogue: Catalogue,
    clock: Clock,
    make_nodes: NodeFactory,
    progress: Progress | None = None,
    *,
    plain: bool = False,
) -> Run:
    """Bring an interrupted session to the state at its interruption by a replay, and build its run,
    ready to begin.

    Args:
        session_id: the session, or the beginning of its id.
        folder, catalogue, clock, make_nodes: as for `start`.
        progress: called during the replay with the number of messages that are done, and of all.
        plain: as for `start`.

    Raises:
        StoreError: there is no such session, or it is live, or it has ended.
        PluginError: its task does not exist any more. In place of its theme, it can go on with the
            default one.
        Failed: its replay differs from the record.
    """
    database = connect(folder)
    held: list[BaseFileLock] = []
    with _released_on_failure(database, held):
        row = find_resumable(database, folder, session_id)
        codes = list(sessions.codes(row))
        held += [locks.hold(folder, "participant", code) for code in codes]
        held.append(locks.hold(folder, "session", row["id"]))
        # another program may have ended it before we held it
        status = sessions.stored_status(database, row["id"])
        if status not in ("running", "interrupted"):
            raise _not_resumable(row["id"], status or "gone")
        check_rules(database, row["id"])
        kind = catalogue.task(row["task"])
        try:
            parameters = build(kind.Parameters, row["parameters"])
            theme = _theme_of(row, catalogue, parameters.language)
            task = set_up(kind, parameters)
            facts = _participant_facts(database, task, codes, "live", without=row["id"])
            nodes = make_nodes(task, theme, row["seed"])
            provenance = _provenance(kind, theme.name, folder, catalogue, plain=plain)
            session = Session(task, theme, clock, row["seed"], nodes, **facts)
            session.replay(told_history(database, row["id"], progress or (lambda done, of: None)))
        except (ParameterError, ReplayError) as error:
            raise Failed(f"The session {row['id']} cannot be resumed. {error}") from error
        number = sessions.begin_run(
            database, row["id"], clock_ns=clock.now(), now=None, **provenance
        )
        run = _with_recorder(row["id"], number, session, folder, database, held, utc)
        if theme.name != row["theme"]:
            run.theme_notice = (
                f"The theme {row['theme']} of session {row['id']} cannot be loaded any more: it "
                "went on with "
                f"{theme.name}, whose words and looks differ."
            )
        return run


def _theme_of(row: sessions.Row, catalogue: Catalogue, language: str) -> Theme:
    """Load the theme of a stored session, or the default one if it is not there any more. Raises
    PluginError.
    """
    try:
        return catalogue.theme(row["theme"], language)
    except PluginError:
        return catalogue.theme(DEFAULT_THEME, language)


def told_history(
    database: sqlite3.Connection, session_id: str, progress: Progress
) -> Iterator[Record]:
    """Yield the messages of a session, and tell the progress."""
    _, last = messages.extent(database, session_id)
    for count, record in enumerate(sessions.history(database, session_id)):
        if count % _TOLD_EVERY == 0:
            progress(record.seq, last)
        yield record


def find_resumable(database: sqlite3.Connection, folder: Path, name: str) -> sessions.Row:
    """Return the interrupted session that `store.sessions.find` finds for a name.

    Raises:
        StoreError: there is no such session, or it is live, or it has ended, or it is of another
            site or computer; part of it was erased, or somebody has withdrawn.
    """
    row = sessions.find(database, folder, name)
    if files := rescue_files(folder, row["id"]):
        raise StoreError(
            f"The last messages of session {row['id']} are in {files[0]}. Run `sar-tui rescue` "
            "first.",
            bad_input=True,
        )
    if row["site"]:
        raise StoreError(
            f"The session {row['id']} is of {row['site']}: it can be resumed only there.",
            bad_input=True,
        )
    if row["status"] == "interrupted" and sessions.came_by_letter(database, row["id"]):
        raise StoreError(
            Sentence(
                "The session {session} was begun on another computer, and goes on only there.",
                session=row["id"],
            ),
            bad_input=True,
        )
    if row["status"] != "interrupted" or not is_personal(row["mode"]):
        raise _not_resumable(row["id"], row["status"] if is_personal(row["mode"]) else row["mode"])
    check_not_erased(database, row["id"])
    check_may_record(database, sessions.codes(row))
    return row


def check_rules(database: sqlite3.Connection, session_id: str) -> None:
    """Raise StoreError if a session was recorded by rules that this version does not have."""
    for record in sessions.history(database, session_id):
        if isinstance(record.message, SessionStarted):
            if record.message.rules != RULES:
                raise StoreError(
                    f"The session {session_id} was recorded by another version of sar-tui (rules "
                    f"{record.message.rules} of the loop, not {RULES}): export it with that "
                    "version.",
                    bad_input=True,
                )
            return


def _not_resumable(session_id: str, state: str) -> StoreError:
    return StoreError(
        f"The session {session_id} is {state}; only a live one that was interrupted can be "
        "resumed.",
        bad_input=True,
    )


def output_nodes(task: Task, theme: Theme) -> list[Node]:
    """Open the session's outputs, except the screen."""
    if set(task.parameters.outputs) <= {"screen"}:
        return []
    from sar_tui.outputs.outputs import open_outputs

    return [*open_outputs(task.parameters.outputs, task.parameters.speech, theme)]


class _ParticipantFacts(TypedDict):
    """The arguments of a Session that concern its participants."""

    best: dict[str, float]
    others_best: dict[str, dict[str, float]]
    names: dict[str, str]
    done_today: dict[str, float]


def _participant_facts(
    database: sqlite3.Connection,
    task: Task,
    codes: Sequence[str],
    mode: SessionMode,
    without: str = "",
    now: datetime | None = None,
) -> _ParticipantFacts:
    """Look up the best results of earlier live sessions, and the codes if the agent addresses
    participants by them.
    """
    best: list[dict[str, float]] = [{} for _ in codes]
    is_of_people = is_personal(mode)
    if is_of_people:
        best = [sessions.best(database, code, task, without=without) for code in codes]
    seats = "AB"[: len(codes)]
    limited = is_of_people and limits_day(task.parameters)
    return {
        "best": best[0],
        "others_best": dict(zip(seats[1:], best[1:], strict=True)) if is_of_people else {},
        "names": dict(zip(seats, codes, strict=True))
        if len(codes) > 1 and task.address == "code"
        else {},
        "done_today": _done_today(database, task, codes[0], now).as_dict() if limited else {},
    }


def _done_today(
    database: sqlite3.Connection, task: Task, participant: str, now: datetime | None
) -> Dose:
    return done_on_day(database, participant, task.name, now or _now())


def _now() -> datetime:
    return datetime.now().astimezone()


def _time_of_day(clock: Clock, began: datetime) -> Callable[[], str]:
    """Return a function that returns the time of day by a clock, at which a session begins now."""
    since = clock.now()
    return lambda: utc(began + timedelta(microseconds=(clock.now() - since) / 1000))


def _check_day(task: Task, participant: str, done: dict[str, float]) -> None:
    """Raise EnoughToday, with a kind sentence, if the participant has done what the programme
    allows on a day.
    """
    if name := reached_of_day(task.parameters, Dose.of(done)):
        limit = next(field for field in fields(type(task.parameters)) if field.name == name)
        amount = getattr(task.parameters, name)
        raise EnoughToday(
            Sentence(
                "That is enough for {who} today: the limit of the programme is reached ({limit}: "
                "{amount}). The next session can be tomorrow.",
                who=participant,
                limit=Sentence(limit.title),
                amount=amount,
            )
        )


def _provenance(
    kind: type[Task], theme: str, folder: Path, catalogue: Catalogue, *, plain: bool
) -> dict[str, dict[str, Any]]:
    """Describe the software and the machine of a run, as they are stored."""
    here = machine()
    if plain:
        here["terminal"] = f"plain, {here['terminal']}"
    return {
        "software": software(
            kind, task_source(kind), task_code(kind), catalogue.theme_folder(theme)
        ),
        "machine": here | {"timing": measured_timing(folder)},
    }


def _with_recorder(
    session_id: str,
    number: int,
    session: Session,
    folder: Path,
    database: sqlite3.Connection,
    held: Sequence[BaseFileLock],
    now: Callable[[], str],
) -> Run:
    """Return the run of a session with a recorder. In a live session it has its own database
    connection and thread.
    """

    def withholds() -> bool:
        return session.awaits_agreement

    if isinstance(session.clock, VirtualClock):
        recorder = Recorder(
            database, session_id, number, session.bus, withholds=withholds, inline=True, now=now
        )
    else:
        own = connect(folder)
        own.execute(f"PRAGMA busy_timeout={_LAST_WAIT_MS}")
        safeguard = Safeguard(folder, session_id, own)
        recorder = Recorder(
            own, session_id, number, session.bus, withholds=withholds, safeguard=safeguard
        )
    return Run(session_id, number, session, recorder, database, held, folder, now)


@contextmanager
def _released_on_failure(database: sqlite3.Connection, held: list[BaseFileLock]) -> Iterator[None]:
    try:
        yield
    except BaseException:
        _release(database, held)
        raise


def _release(database: sqlite3.Connection, held: Sequence[BaseFileLock]) -> None:
    for lock in held:
        lock.release()
    database.close()

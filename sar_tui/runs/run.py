"""A run of the program on a session: plug-ins, store and nodes put together, the same way live and simulated."""

import sqlite3
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TypedDict

import sqlite_utils
from filelock import BaseFileLock

from sar_tui.framework.clock import Clock, VirtualClock
from sar_tui.framework.declaration import ParameterError
from sar_tui.framework.node import Node
from sar_tui.framework.parameters import build
from sar_tui.framework.session import ReplayError, Session
from sar_tui.framework.task import Task
from sar_tui.framework.theme import Theme
from sar_tui.plugins import Catalogue, task_folder
from sar_tui.runs.plan import Failed, Plan, set_up
from sar_tui.store import locks, participants, sessions
from sar_tui.store.database import StoreError, connect
from sar_tui.store.provenance import machine, measured_timing, software
from sar_tui.store.recorder import Recorder


class Run:
    """A session under way in this program: its nodes, its recorder, its locks.

    Made by ``start`` or ``resume``; ``close`` it when it is over, however it ended.
    """

    def __init__(
        self,
        session_id: str,
        number: int,
        session: Session,
        recorder: Recorder,
        database: sqlite_utils.Database,
        held: list[BaseFileLock],
    ) -> None:
        self.id = session_id
        self.number = number
        self.session = session
        self.recorder = recorder
        self._database = database
        self._locks = held

    @property
    def participants(self) -> dict[str, str]:
        """Who takes part: codes by seat."""
        return {row["seat"]: row["participant"] for row in sessions.rows(self._database, "seats", self.id)}

    def begin(self) -> None:
        """Start the loop."""
        self.session.begin(self.number)

    def check(self) -> None:
        """Raise Failed if a vital node has broken."""
        if fault := self.session.broken:
            name = self.session.task.name
            raise Failed(f"The task {name} failed ({fault.error}, {fault.place}). What was done so far is kept.")

    def close(self) -> None:
        """Let go. A session that has not ended is left as interrupted, to be gone on with."""
        try:
            self.session.detach()
            if not self.session.ended:
                sessions.interrupt(self._database, self.id)
        except (StoreError, sqlite3.Error):
            pass  # the lock tells as much: nobody holds it
        finally:
            for lock in self._locks:
                lock.release()
            self._database.conn.close()


Extra = Callable[[Task, Theme], Sequence[Node]]


"""Makes the input and output nodes for a task and a theme."""


def start(plan: Plan, folder: Path, catalogue: Catalogue, clock: Clock, extra: Extra) -> Run:
    """Enter a new session, and put its nodes together.

    Args:
        plan: what it will be.
        folder: where data lives.
        catalogue: where the theme is found.
        clock: live or virtual.
        extra: makes the input and output nodes for the task.

    Raises:
        StoreError: the database cannot be used, or a participant is in a live session.
        PluginError: there is no such theme.
        ParameterError: the task has no such level, or there is no such output.
        Failed: the task cannot be set up.
    """
    theme = catalogue.theme(plan.theme, plan.parameters.language)
    task = set_up(plan.task, plan.parameters)
    nodes = extra(task, theme)
    database = connect(folder)
    held: list[BaseFileLock] = []
    with _let_go_on_failure(database, held):
        participant, partner = plan.participant, plan.partner
        if plan.mode == "live":
            participant = participants.add(database, participant)
            partner = participants.add(database, partner) if partner else ""
            held += [locks.hold(folder, "participant", code) for code in (participant, partner) if code]
        session = Session(
            task, theme, clock, plan.seed, nodes, **_known(database, task, participant, partner, plan.mode)
        )
        session_id = plan.id or sessions.new_id()
        held.append(locks.hold(folder, "session", session_id))
        made_by = _made_by(plan.task, theme.name, folder, catalogue)
        sessions.create(
            database,
            session_id,
            task=task.name,
            theme=theme.name,
            participant=participant,
            seed=plan.seed,
            parameters=plan.parameters,
            mode=plan.mode,
            partner=partner,
            **made_by,
        )
        number = sessions.begin_run(database, session_id, **made_by)
        return _enter(session_id, number, session, folder, database, held)


class _Known(TypedDict):
    """What a session is told of who takes part in it."""

    best: dict[str, float]
    others_best: dict[str, dict[str, float]]
    names: dict[str, str]


def _known(
    database: sqlite_utils.Database, task: Task, participant: str, partner: str, mode: sessions.Mode, but: str = ""
) -> _Known:
    """Their best results of earlier sessions; and their codes, where the agent is to call them so."""
    is_live = mode == "live"
    best = sessions.best(database, participant, task, but=but) if is_live else {}
    others = {"B": sessions.best(database, partner, task, but=but)} if is_live and partner else {}
    names = {"A": participant, "B": partner} if partner and task.address == "code" else {}
    return {"best": best, "others_best": others, "names": names}


def _made_by(kind: type[Task], theme: str, folder: Path, catalogue: Catalogue) -> dict[str, object]:
    """The software and the machine of a run, as the database keeps them."""
    return {
        "software": software(kind, task_folder(kind), catalogue.theme_folder(theme)),
        "machine": machine() | {"timing": measured_timing(folder)},
    }


def resumable(database: sqlite_utils.Database, folder: Path, name: str) -> sessions.Row:
    """The interrupted session of that name, as `store.sessions.find` knows it.

    Raises:
        StoreError: there is no such session, or it is live, or it has ended.
    """
    row = sessions.find(database, folder, name)
    if row["status"] != "interrupted" or row["mode"] != "live":
        raise _not_resumable(row["id"], row["status"] if row["mode"] == "live" else row["mode"])
    return row


def stored_seed(session_id: str, folder: Path) -> int:
    """Return the seed of a recorded session. Raises StoreError."""
    database = connect(folder)
    try:
        return int(sessions.find(database, folder, session_id)["seed"])
    finally:
        database.conn.close()


def _not_resumable(session_id: str, state: str) -> StoreError:
    return StoreError(
        f"The session {session_id} is {state}; only a live one that was interrupted can be gone on with.",
        bad_input=True,
    )


def resume(session_id: str, folder: Path, catalogue: Catalogue, clock: Clock, extra: Extra) -> Run:
    """Bring an interrupted session back to where it was cut off, ready to begin.

    Raises:
        StoreError: there is no such session, or it is live, or it has ended.
        PluginError: its task or theme is gone.
        Failed: it cannot be brought back as it was.
    """
    database = connect(folder)
    held: list[BaseFileLock] = []
    with _let_go_on_failure(database, held):
        row = resumable(database, folder, session_id)
        codes = (row["participant"], row["partner"] or "")
        held += [locks.hold(folder, "participant", code) for code in codes if code]
        held.append(locks.hold(folder, "session", row["id"]))
        status = sessions.stored_status(database, row["id"])  # another program may have ended it before we held it
        if status not in ("running", "interrupted"):
            raise _not_resumable(row["id"], status or "gone")
        kind = catalogue.task(row["task"])
        try:
            parameters = build(kind.Parameters, row["parameters"])
            theme = catalogue.theme(row["theme"], parameters.language)
            task = set_up(kind, parameters)
            known = _known(database, task, *codes, "live", but=row["id"])
            session = Session(task, theme, clock, row["seed"], extra(task, theme), **known)
            session.replay(sessions.history(database, row["id"]))
        except (ParameterError, ReplayError) as error:
            raise Failed(f"The session {row['id']} cannot be gone on with. {error}") from error
        number = sessions.begin_run(database, row["id"], **_made_by(kind, row["theme"], folder, catalogue))
        return _enter(row["id"], number, session, folder, database, held)


def speaking(task: Task, theme: Theme) -> list[Node]:
    """The nodes of a session's outputs, but for the screen's."""
    if set(task.parameters.outputs) <= {"screen"}:
        return []
    from sar_tui.outputs.outputs import open_outputs

    return [*open_outputs(task.parameters.outputs, task.parameters.speech, theme)]


@contextmanager
def _let_go_on_failure(database: sqlite_utils.Database, held: list[BaseFileLock]) -> Iterator[None]:
    try:
        yield
    except BaseException:
        for lock in held:
            lock.release()
        database.conn.close()
        raise


def _enter(
    session_id: str,
    number: int,
    session: Session,
    folder: Path,
    database: sqlite_utils.Database,
    held: list[BaseFileLock],
) -> Run:
    """Record from here on."""
    inline = isinstance(session.clock, VirtualClock)
    recorder = Recorder(database if inline else connect(folder), session_id, number, session.bus, inline=inline)
    return Run(session_id, number, session, recorder, database, held)

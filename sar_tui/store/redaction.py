"""Texts, and the part of one of two participants, erased from a session's log.

The hashes of messages as they were, and as they are then, go into the log, so that all hashes still
hold, and nothing else can be put in their place.
"""

import re
import sqlite3
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from typing import Any, TypeVar

import msgspec
from msgspec.structs import replace

from sar_tui.loop import topics as t
from sar_tui.loop.bus import Topic
from sar_tui.model import messages as m
from sar_tui.store import log_hashes, messages
from sar_tui.store.log_examination import Derivation, recorded_facts
from sar_tui.store.log_hashes import Entry
from sar_tui.store.merge.people import code_at, local_code
from sar_tui.store.messages import StoredRow
from sar_tui.store.record_changes import erased_hashes, log

S = TypeVar("S", bound=msgspec.Struct)
U = TypeVar("U", bound=m.Utterance)
Change = Callable[[StoredRow, m.Message], m.Message | None]
"""Returns what remains of a message: the same one, another of its topic, or None."""


def erase_texts(
    db: sqlite3.Connection, session: str, seat: str, old: str, new: str, said: m.RecordChanged
) -> None:
    """Erase what was typed in a session, and give the participant at a seat another code.

    Args:
        db: in a transaction of the caller.
        old, new: the code of the participant, as the database has it, and the other one.
        said: what is added to the log; its details are made here.
    """
    texts = _Texts(db, session, {_code_there(db, session, old): local_code(new)})
    _redact(db, session, said, texts, lambda: _seat(db, session, seat, new))


def erase_seat(
    db: sqlite3.Connection, session: str, seat: str, old: str, new: str, said: m.RecordChanged
) -> None:
    """Erase the part of the participant at a seat of a session for two, and all that was typed in
    it. The arguments are those of `erase_texts`.
    """
    texts = _Texts(db, session, {_code_there(db, session, old): ""})
    part = _Part(db, session, seat)

    def change(row: StoredRow, message: m.Message) -> m.Message | None:
        kept = part(row, message)
        return kept and texts(row, kept)

    def rows() -> None:
        _seat(db, session, seat, new)
        streams = "(SELECT stream FROM imu_streams WHERE session=:session AND seat=:seat)"
        where = f"session=:session AND stream IN {streams}"
        for table in ("imu_chunks", "imu_streams"):
            db.execute(f"DELETE FROM {table} WHERE {where}", {"session": session, "seat": seat})

    _redact(db, session, said, change, rows)


def _seat(db: sqlite3.Connection, session: str, seat: str, new: str) -> None:
    db.execute("UPDATE seats SET participant=? WHERE session=? AND seat=?", (new, session, seat))
    db.execute("UPDATE imu_streams SET source='' WHERE session=?", (session,))


def _redact(
    db: sqlite3.Connection,
    session: str,
    said: m.RecordChanged,
    change: Change,
    change_rows: Callable[[], None],
) -> None:
    """Change the messages of a session, and the rows beside them; derive its other rows again."""
    erased = erased_hashes(db, session)
    beside: dict[str, bytes] = {"facts": recorded_facts(db, session)}
    entries: list[Entry] = [
        entry for entry in log_hashes.entries_there(db, session) if entry[0] != "run"
    ]
    for entry in entries:
        digest = log_hashes.entry_hash(db, session, entry)
        name = log_hashes.name_of(entry)
        beside[name] = erased.get((name, digest), digest)
    details: dict[str, Any] = {}
    for before, after in _change_messages(db, session, change):
        digest = log_hashes.message_hash(before)
        first = erased.get((str(before.seq), digest), digest)
        details[str(before.seq)] = f"{first.hex()} {log_hashes.message_hash(after).hex()}"
    change_rows()
    for entry in entries:
        name, now = log_hashes.name_of(entry), log_hashes.entry_hash(db, session, entry)
        if now != beside[name]:
            details[name] = f"{beside[name].hex()} {now.hex()}"
    facts = log_hashes.facts_hash(db, session, _local_seats(db, session))
    if facts != beside["facts"]:
        details["facts"] = f"{beside['facts'].hex()} {facts.hex()}"
    with closing(Derivation(db)) as derivation:
        if derivation.derive(session):
            derivation.rebuild(session)
    log(db, session, replace(said, details=details))


def _change_messages(
    db: sqlite3.Connection, session: str, change: Change
) -> Iterator[tuple[StoredRow, StoredRow]]:
    """Store what remains of each message that is changed, and yield it as it was and as it is."""
    numbers = messages.add_numbers(db, session)
    at: dict[int, int] = {}
    changed: list[tuple[StoredRow, StoredRow]] = []
    for row in messages.stored_rows(db, session):
        try:
            message = messages.decoded(row)
            kept = change(row, message)
        except (KeyError, TypeError, msgspec.MsgspecError):
            message, kept = None, None
        if kept is not None:
            at[row.run] = row.at
        if kept is None:
            changed.append((row, _as_row(row, t.ERASED, m.Erased(), at.get(row.run, 0))))
        elif kept is not message:
            changed.append((row, _as_row(row, t.ALL[row.topic], kept, row.at)))
    db.executemany(
        "UPDATE messages SET topic=?, at_ns=?, message=? WHERE session_number=? AND seq=?",
        [
            (numbers.topics[after.topic], after.at, after.text, numbers.session, after.seq)
            for _, after in changed
        ],
    )
    yield from changed


def _as_row(row: StoredRow, topic: Topic[Any], message: m.Message, at: int) -> StoredRow:
    text = messages.encoder(topic)(message)
    return StoredRow(row.seq, row.run, at, topic.name, messages.layout(topic), text)


def _local_seats(db: sqlite3.Connection, session: str) -> dict[str, str]:
    """Return the participants by seat, by the codes that the session's own site has for them."""
    return {
        seat: _code_there(db, session, code) for seat, code in log_hashes.seats(db, session).items()
    }


def _code_there(db: sqlite3.Connection, session: str, code: str) -> str:
    """Return the code that the site of a session has for a participant."""
    (site,) = db.execute("SELECT site FROM sessions WHERE id=?", (session,)).fetchone()
    return local_code(code_at(db, code, site))


# --- texts


_TYPED: Mapping[type[m.Message], Mapping[str, str]] = {
    m.NoteAdded: {"text": "", "label": ""},
    m.SensorChanged: {"source": ""},
    m.InputDropped: {"what": ""},
    m.Fault: {"error": "", "trace": ""},
}
"""Fields that are emptied in each message of a kind."""


class _Texts:
    """Takes out of messages what somebody typed, and login names.

    Results stay, also of prompts that are answered by typing.

    Args:
        codes: codes that the agent may have said, and what stands in their place.
    """

    def __init__(self, db: sqlite3.Connection, session: str, codes: Mapping[str, str]) -> None:
        self._codes = codes
        self._answers: list[tuple[int, int, int]] = []
        is_addressed = False
        for row, message in _readable(db, session, t.STEP_ENDED, t.SESSION):
            match message:
                case m.StepEnded(kind="text"):
                    self._answers.append((row.run, message.shown, message.ended))
                case m.SessionStarted(names=names):
                    is_addressed = is_addressed or any(name in codes for name in names.values())
        words = "|".join(map(re.escape, codes)) if is_addressed else ""
        self._spoken = re.compile(rf"\b(?:{words})\b") if words else None

    def __call__(self, row: StoredRow, message: m.Message) -> m.Message:
        return _with(message, **(_TYPED.get(type(message)) or self._changes(row, message)))

    def _changes(self, row: StoredRow, message: m.Message) -> Mapping[str, Any]:
        """Return the other values of the fields of a message."""
        changes: Mapping[str, Any] = {}
        match message:
            case m.Remark(source="free text") | m.Decision(text=str()):
                changes = {"text": ""}
            case m.StepEnded(kind="text"):
                changes = {"answer": message.answer and ""}
            case m.Waiting(step=m.AskedStep() as asked):
                typed = "" if asked.step.kind == "text" else asked.entry.typed
                entry = _with(asked.entry, typed=typed)
                who = self._without_codes(asked.who)
                changes = {"step": _with(asked, entry=entry, who=who)}
            case m.KeyPressed() | m.KeyPerceived() if self._is_answer(row.run, message.at):
                changes = {"key": ""}
            case m.SessionStarted():
                names = {seat: self._codes.get(name, name) for seat, name in message.names.items()}
                changes = {"names": names}
            case m.ArbiterState():
                changes = {
                    "pending": tuple(map(self._pending, message.pending)),
                    "queued": tuple(map(self._utterance, message.queued)),
                    "current": message.current and self._utterance(message.current),
                }
            case m.PendingApproval():
                changes = {"proposal": self._utterance(message.proposal)}
            case m.Utterance():
                changes = self._words(message)
            case m.RecordChanged():
                details = {} if message.change == "moved" else message.details
                changes = {"actor": "", "reason": "", "details": details}
        return changes

    def _is_answer(self, run: int, at: int) -> bool:
        """Return True if a key was pressed while an answer was typed."""
        return any(run == each and shown <= at <= end for each, shown, end in self._answers)

    def _pending(self, pending: m.PendingApproval) -> m.PendingApproval:
        return _with(pending, proposal=self._utterance(pending.proposal))

    def _utterance(self, said: U) -> U:
        return _with(said, **self._words(said))

    def _words(self, said: m.Utterance) -> Mapping[str, str]:
        """Return the words of an utterance; none if an operator typed them."""
        if isinstance(said, m.Action) and said.decision in ("edited", "initiated"):
            return {"text": "", "spoken": ""}
        return {
            "text": self._without_codes(said.text),
            "spoken": self._without_codes(said.spoken),
        }

    def _without_codes(self, text: str) -> str:
        if self._spoken is None:
            return text
        return self._spoken.sub(lambda found: self._codes[found[0]], text)


def _with(message: S, **changes: Any) -> S:
    """Return a struct with some other values; the same one if they are the same."""
    if all(getattr(message, name) == value for name, value in changes.items()):
        return message
    return replace(message, **changes)


def _readable(
    db: sqlite3.Connection, session: str, *wanted: Topic[Any]
) -> Iterator[tuple[StoredRow, m.Message]]:
    """Yield the messages of some topics that can be read."""
    for row in messages.stored_rows(db, session, topics=[topic.name for topic in wanted]):
        try:
            yield row, messages.decoded(row)
        except (KeyError, TypeError, msgspec.MsgspecError):
            continue


# --- the part of a participant


_OF_BOTH = {
    topic.name
    for topic in (
        t.SESSION, t.THEME, t.ATTEMPT_STARTED, t.SESSION_ENDED, t.LEVEL, t.GOAL, t.SETTING, t.MODE,
        t.PRESENCE, t.OUTPUT, t.STORAGE, t.RECORD_CHANGED, t.ERASED,
    )
}  # fmt: skip
"""Topics of messages that stay: they are of the session, or of both."""
_OF_ONE = {
    topic.name
    for topic in (
        t.PERCEIVED, t.REACH, t.WAITING, t.PROMPT, t.CUE, t.TYPED, t.VOIDED, t.TRIAL,
        t.TRIAL_FEEDBACK, t.MARKED, t.ATTEMPT_ENDED, t.STEP_ENDED, t.FEEDBACK, t.PROPOSED,
        t.PENDING_APPROVAL, t.DECIDED, t.ACTION, t.STORED,
    )
}  # fmt: skip
"""Topics of messages that stay if they are of the partner."""
_UTTERANCES = (t.PROPOSED, t.PENDING_APPROVAL, t.DECIDED, t.ACTION)


class _Part:
    """Takes out of a session's messages all that is not the partner's, or of both.

    Inputs have no seat: a key stays if it was perceived as the partner's, what was shown if it
    belongs to a prompt of the partner, a report if it is of an action for the partner.
    """

    def __init__(self, db: sqlite3.Connection, session: str, erased: str) -> None:
        self._erased = erased
        self._partner = "B" if erased == "A" else "A"
        self._keys: set[tuple[int, int, str]] = set()
        self._trials: set[tuple[int, int]] = set()
        self._actions: set[str] = set()
        for row, message in _readable(db, session, t.PERCEIVED, t.TRIAL, *_UTTERANCES):
            if message.seat != self._partner:
                continue
            match message:
                case m.KeyPerceived():
                    self._keys.add((row.run, message.at, message.key))
                case m.TrialEnded():
                    self._trials.add((message.attempt, message.trial))
                case m.PendingApproval():
                    self._actions.add(message.proposal.id)
                case m.Utterance():
                    self._actions.add(message.id)

    def __call__(self, row: StoredRow, message: m.Message) -> m.Message | None:
        return self._of_session(message) if self._stays(row, message) else None

    def _stays(self, row: StoredRow, message: m.Message) -> bool:
        stays = row.topic in _OF_BOTH
        if row.topic in _OF_ONE:
            stays = message.seat == self._partner
        match message:
            case m.KeyPressed():
                stays = (row.run, message.at, message.key) in self._keys
            case m.Shown() | m.FrameDue() | m.ToneDue() | m.ToneBegan() | m.TrialFeedbackShown():
                stays = (message.attempt, message.trial) in self._trials
            case m.OutputReport() | m.ProposalSeen():
                stays = message.action in self._actions
            case m.Dropped() | m.LevelDecided():
                stays = message.id in self._actions
        return stays

    def _of_session(self, message: m.Message) -> m.Message:
        """Return a message of both without what it says of the one who is erased."""
        if not isinstance(message, m.SessionStarted):
            return message
        others = {seat: best for seat, best in message.others_best.items() if seat != self._erased}
        names = {**message.names, self._erased: ""} if message.names else {}
        first: dict[str, Any] = {"best": {}, "done_today": {}} if self._erased == "A" else {}
        return _with(message, others_best=others, names=names, **first)

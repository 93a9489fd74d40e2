"""State of the homes at a clinic, and of the clinic at a home, by the letters that have arrived."""

import sqlite3
from datetime import date, datetime, timedelta

import msgspec

from sar_tui.letterbox import correspondents as stored
from sar_tui.letterbox.correspondents import Correspondent, State, missing
from sar_tui.records.kind import KindError, find
from sar_tui.store import records
from sar_tui.store.records import Record
from sar_tui.store.training_days import UTC_OFFSET, trained_at

_CLOCK_TOLERANCE = timedelta(days=1)
"""Difference of clocks from which on a home's counts as wrong. A letter may lie for weeks, so that
only a clock that is ahead, or behind the invitation, can be told.
"""
DAYS = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")
"""Days of the week, as the records of training days have them."""


class Home(msgspec.Struct, frozen=True, kw_only=True):
    """A computer of a person who trains at home.

    Attributes:
        name: the person, and the number of their computer if it is not the first.
        state: of the invitation, or that it has joined.
        heard_at: when a letter from it was taken last, UTC; empty: never.
        missing: numbers of letters that it has written and that have not arrived.
        waiting: number of letters to it that it has not acknowledged yet. ``since``: when the oldest
            of them was written, UTC.
        refused: sentences on its letters that were refused. ``refused_at``: when the last of them
            was, UTC; empty if none was.
        clock: why its clock seems to be wrong: ``ahead``, ``behind``, or empty.
        device: the computer, as it described itself.
    """

    name: str
    participant: str
    state: State
    invited_at: str
    expires_at: str
    heard_at: str
    missing: tuple[int, ...]
    waiting: int
    since: str
    refused: tuple[str, ...]
    refused_at: str
    clock: str
    device: dict[str, str]


def homes(db: sqlite3.Connection) -> list[Home]:
    """Return the homes of a clinic's database, by participant."""
    return [_home(db, one) for one in stored.correspondents(db)]


def _home(db: sqlite3.Connection, one: Correspondent) -> Home:
    arrived = stored.letters(db, one.id, "in")
    waiting = _on_the_way(stored.letters(db, one.id, "out"))
    refused = db.execute(
        "SELECT number, reason, at FROM letters WHERE correspondent=? AND state='refused' ORDER BY "
        "number",
        (one.id,),
    ).fetchall()
    return Home(
        name=one.name,
        participant=one.participant,
        state=one.state,
        invited_at=one.invited_at,
        expires_at=one.expires_at,
        heard_at=one.heard_at,
        missing=tuple(missing((each.number for each in arrived), one.void)),
        waiting=len(waiting),
        since=min((each.at for each in waiting), default=""),
        refused=tuple(f"Letter {number}: {reason}." for number, reason, _ in refused),
        refused_at=max((at for *_, at in refused), default=""),
        clock=_clock(one),
        device={name: str(value) for name, value in one.device.items()},
    )


def _on_the_way(letters: list[stored.Sent]) -> list[stored.Sent]:
    """Return the letters that bring something and that the other side has not acknowledged."""
    return [each for each in letters if each.state == "sent" and each.contents]


def _clock(one: Correspondent) -> str:
    try:
        written = datetime.fromisoformat(str(one.device.get("written_at", "")))
        heard, invited = map(datetime.fromisoformat, (one.heard_at, one.invited_at))
        if written > heard + _CLOCK_TOLERANCE:
            return "ahead"
        return "behind" if written < invited - _CLOCK_TOLERANCE else ""
    except (ValueError, TypeError):
        return ""


class LastMessage(msgspec.Struct, frozen=True, kw_only=True):
    """The newest message to a person at home.

    Attributes:
        text: what it says.
        written_at: UTC.
        has_arrived: a computer of the person has taken it.
        read_at: when it was heard that the person has read it, UTC; empty: not yet.
    """

    text: str
    written_at: str
    has_arrived: bool
    read_at: str


def last_message(db: sqlite3.Connection, participant: str) -> LastMessage | None:
    """Return the newest message to a person; None if there is none."""
    written = _of_kind(db, participant, "message-home")
    if not written:
        return None
    key = f"{written[-1].id} {written[-1].version}"
    letters = [
        letter
        for one in stored.correspondents(db)
        if one.participant == participant
        for letter in stored.letters(db, one.id, "out")
        if key in letter.contents.get("records", ())
    ]
    return LastMessage(
        text=str(written[-1].content.get("text", "")),
        written_at=written[-1].recorded_at,
        has_arrived=any(letter.state == "acknowledged" for letter in letters),
        read_at=max((letter.seen_at for letter in letters), default=""),
    )


class Clinic(msgspec.Struct, frozen=True, kw_only=True):
    """The clinic, as a home knows it.

    Attributes:
        state: joined; revoked or declined: the clinic takes no letters from here.
        heard_at: when a letter from it was taken last, UTC; empty: never.
        waiting: number of letters to it that it has not acknowledged yet. ``since``: when the oldest
            of them was written, UTC.
        missing: numbers of letters that it has written and that have not arrived.
        refused: number of letters to it that it has refused.
        arrived, seen: local day of the newest session that has arrived there, and that a person has
            looked at there; None if there is none.
    """

    participant: str
    state: State
    heard_at: str
    waiting: int
    since: str
    missing: tuple[int, ...]
    refused: int
    arrived: date | None
    seen: date | None


def clinic(db: sqlite3.Connection) -> Clinic | None:
    """Return the clinic of a home's database; None if nobody has joined."""
    known = stored.correspondents(db)
    if not known:
        return None
    one = max(known, key=lambda each: (each.state == "joined", each.invited_at))
    out = stored.letters(db, one.id, "out")
    waiting = _on_the_way(out)
    arrived = stored.letters(db, one.id, "in")
    return Clinic(
        participant=one.participant,
        state=one.state,
        heard_at=one.heard_at,
        waiting=len(waiting),
        since=min((each.at for each in waiting), default=""),
        missing=tuple(missing((each.number for each in arrived), one.void)),
        refused=sum(each.state == "refused" for each in out),
        arrived=_newest(db, [each for each in out if each.state == "acknowledged"]),
        seen=_newest(db, [each for each in out if each.seen_at]),
    )


def _newest(db: sqlite3.Connection, letters: list[stored.Sent]) -> date | None:
    """Return the local day of the newest session of some letters."""
    ids = [id for each in letters for id in each.contents.get("sessions", ())]
    found = db.execute(
        f"SELECT started_at, {UTC_OFFSET} FROM sessions WHERE id IN (SELECT value FROM json_each(?)) "
        "ORDER BY started_at DESC LIMIT 1",
        (msgspec.json.encode(ids).decode(),),
    ).fetchone()
    return trained_at(*found).date() if found else None


# --- what a clinic has written to a person


def unread(db: sqlite3.Connection, participant: str) -> list[Record]:
    """Return the messages that came by letters which nobody has looked at, the oldest first."""
    fresh = {
        key.split()[0]
        for (key,) in db.execute(
            "SELECT record.key FROM letters, json_each(letters.contents, '$.records') AS record "
            "WHERE direction='in' AND state='taken' AND seen_at=''"
        )
    }
    return [each for each in _of_kind(db, participant, "message-home") if each.id in fresh]


def training_days(db: sqlite3.Connection, participant: str) -> tuple[str, ...]:
    """Return the days of the week on which a person is to train, of `DAYS`; empty: any."""
    plans = _of_kind(db, participant, "training-days")
    given = str(plans[-1].content.get("days", "")).casefold().split() if plans else []
    return tuple(day for day in DAYS if day in given)


def requested_form(db: sqlite3.Connection, participant: str) -> str:
    """Return the name of the form that a person was asked to fill in and has not yet; empty if
    there is none.
    """
    asked = _of_kind(db, participant, "report-request")
    if not asked:
        return ""
    name = str(asked[-1].content.get("form", ""))
    try:
        if find(name).form is None:
            return ""
    except KindError:
        return ""
    # by the clock here: that of the clinic may be another one
    row = db.execute(
        "SELECT max(at) FROM letters, json_each(contents, '$.records') WHERE direction='in' AND key=?",
        (f"{asked[-1].id} {asked[-1].version}",),
    ).fetchone()
    came_at = row[0] or asked[-1].recorded_at
    answered = [
        each
        for each in records.listing(db, participant=participant, kinds=[name])
        if each.recorded_at > came_at and each.content.get("status") == "complete"
    ]
    return "" if answered else name


def _of_kind(db: sqlite3.Connection, participant: str, kind: str) -> list[Record]:
    found = records.listing(db, participant=participant, kinds=[kind])
    return sorted(found, key=lambda each: (each.recorded_at, each.id))

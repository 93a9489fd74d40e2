"""Choice of stored sessions for an export or a report: by name, of a participant, or all."""

import sqlite3
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec

from sar_tui.model.session_mode import is_personal
from sar_tui.store import people_events
from sar_tui.store.counted import is_set_aside
from sar_tui.store.database import StoreError
from sar_tui.store.merge.people import other_code
from sar_tui.store.participants import check_code, check_known
from sar_tui.store.sessions import codes, find, listing

Row = dict[str, Any]


class Request(msgspec.Struct, frozen=True, kw_only=True):
    """The sessions that are asked for: by name, those of a participant, or all.

    Attributes:
        names: ids, beginnings of ids, or ``last``.
        participant: a code; empty if not of one participant.
        everything: all sessions.
        simulated: sessions that were not played by a person, and only those.
        mixed: both.
        also_withdrawn: also of people who have withdrawn, and whose data is excluded.
    """

    names: tuple[str, ...] = ()
    participant: str = ""
    everything: bool = False
    simulated: bool = False
    mixed: bool = False
    also_withdrawn: bool = False


class Selection(msgspec.Struct, frozen=True):
    """Sessions in the order in which they were stored, and sentences on those that are left out.

    ``refused``: on those that cannot be read yet. ``set_aside``: on those that do not count, and on
    people who have withdrawn, and whose data is excluded.
    ``of``: the participant whose sessions were asked for; empty if they were chosen otherwise.
    """

    sessions: tuple[Row, ...]
    refused: tuple[str, ...] = ()
    of: str = ""
    set_aside: tuple[str, ...] = ()

    @property
    def ids(self) -> list[str]:
        """The ids of the sessions."""
        return [row["id"] for row in self.sessions]

    @property
    def participants(self) -> list[str]:
        """The codes of their participants."""
        codes = (code for row in self.sessions for code in (row["participant"], row["partner"]))
        return list(dict.fromkeys(filter(None, codes)))

    @property
    def tasks(self) -> list[str]:
        """The names of their tasks."""
        return sorted({row["task"] for row in self.sessions})


def select(
    database: sqlite3.Connection,
    folder: Path,
    request: Request,
    *,
    also_damaged: bool = False,
    only_counted: bool = False,
) -> Selection:
    """Return the sessions that are asked for. One that runs is left out.

    ``also_damaged``: those with damaged JSON as well, as `store.sessions.listing` returns them.
    ``only_counted``: for a report: sessions that were discarded or refused are left out, too.
    Sessions of people who have withdrawn, and whose data is excluded, are always left out.

    Raises:
        StoreError: there is none, all of them are running, or the request is not clear; a named
            session does not exist, or the code is not valid.
    """
    ways = sum([bool(request.names), bool(request.participant), request.everything])
    if ways > 1:
        raise StoreError(
            "Say which sessions in one way: name them, or give --participant CODE, or --all.",
            bad_input=True,
        )
    if not ways:
        raise StoreError(
            "Say which sessions: name them (`sar-tui sessions` lists them), or give --participant "
            "CODE, or --all.",
            bad_input=True,
        )
    if request.simulated and request.mixed:
        raise StoreError(
            "--simulated takes simulated sessions only, --mixed both: give one of them.",
            bad_input=True,
        )
    code = check_code(request.participant) if request.participant else ""
    if request.names:
        chosen = _named(database, folder, request, also_damaged)
    else:
        rows = listing(database, folder, participant=code or None, also_damaged=also_damaged)[::-1]
        chosen = [row for row in rows if _is_wanted(row, request)]
        if not chosen:
            raise StoreError(_none(database, rows, request, code), bad_input=True)
    running = [row for row in chosen if row["status"] == "running"]
    set_aside = [row for row in chosen if only_counted and is_set_aside(row)]
    withdrawn = {} if request.also_withdrawn else _withdrawn(database, chosen)
    left_out = [*running, *set_aside, *(row for row in chosen if row["id"] in withdrawn)]
    ended = [row for row in chosen if row not in left_out]
    excluded = tuple(dict.fromkeys(withdrawn.values()))
    if not ended:
        waits = [f"Session {row['id']} is running: wait until it has ended." for row in running]
        raise StoreError(
            " ".join([*waits, *map(_set_aside_words, set_aside), *excluded]),
            bad_input=not waits and bool(excluded),
        )
    refused = tuple(
        f"Session {row['id']} is running. It is left out until it has ended." for row in running
    )
    aside = (*map(_set_aside_words, set_aside), *excluded)
    return Selection(tuple(ended), refused, code, aside)


def _withdrawn(database: sqlite3.Connection, chosen: Sequence[Row]) -> dict[str, str]:
    """Return the sentence on each session, by its id, with a participant who has withdrawn, and
    whose data is excluded.
    """
    excluded = people_events.excluded(database)
    return {
        row["id"]: people_events.excluded_words(excluded[code])
        for row in chosen
        for code in codes(row)
        if code in excluded
    }


def _set_aside_words(row: Row) -> str:
    return f"Session {row['id']} was {row['status']}: it does not count, and is left out."


def _named(
    database: sqlite3.Connection, folder: Path, request: Request, also_damaged: bool
) -> list[Row]:
    rows = (find(database, folder, name, also_damaged=also_damaged) for name in request.names)
    found = {row["id"]: row for row in rows}
    for row in found.values():
        if not _is_wanted(row, request):
            live = is_personal(row["mode"])
            raise StoreError(
                f"Session {row['id']} is {row['mode']}: "
                + ("leave out --simulated, " if live else "add --simulated for such sessions, ")
                + "or add --mixed for both kinds together.",
                bad_input=True,
            )
    order = {
        id: number
        for number, (id,) in enumerate(database.execute("SELECT id FROM sessions ORDER BY rowid"))
    }
    return sorted(found.values(), key=lambda row: order[row["id"]])


def _is_wanted(row: Row, request: Request) -> bool:
    return request.mixed or is_personal(row["mode"]) != request.simulated


def _none(database: sqlite3.Connection, rows: Sequence[Row], request: Request, code: str) -> str:
    if code and (stored := other_code(database, code)):
        return f"{code} is {stored} here: ask for the sessions of {stored}."
    if code and not rows:
        check_known(database, code)
    of = f" of {code}" if code else ""
    kind = "" if request.mixed else " simulated" if request.simulated else " live"
    said = f"There is no{kind} session{of}."
    if rows and not request.simulated:
        said += " There are simulated ones: add --simulated."
    return said

"""Records of people: adverse events, scores, pain and tiredness, and what a clinic declares. A row
for each value.
"""

import sqlite3
from collections.abc import Collection, Iterator, Mapping
from functools import partial
from typing import Any

import msgspec

from sar_tui.export.columns import TO_SESSION, Table, Values, stored
from sar_tui.export.damage import Damage
from sar_tui.export.tables.sessions import TO_PARTICIPANT
from sar_tui.model.session_mode import is_personal
from sar_tui.records.kind import LANGUAGE, NOT_SAID, OPEN, STATUS, Kind

_HEAD = (
    "id", "version", "kind", "participant", "seat", "session", "moment", "at", "removed",
    "recorded_at",
)  # fmt: skip
_ID, _VERSION, _KIND, _SESSION, _REMOVED = (
    _HEAD.index(name) for name in ("id", "version", "kind", "session", "removed")
)
_LAST = "SELECT id, max(version) FROM records WHERE participant=? GROUP BY id"
_CODES = (LANGUAGE,)
"""Fields of forms that are texts, and were not typed."""
_IDS = ("replaces", "record")
"""Fields of studies with the code of a person, or the id of a record: they leave as texts do."""
_VALUE = ("content.field", "content.value", "content.unit", "content.option", "content.words")


_FORMS = (
    "SELECT json_extract(content, '$.record'), id FROM records WHERE participant=?"
    " AND kind='form-filled' AND json_extract(content, '$.study')=?"
)


def records(
    sessions: Collection[Mapping[str, Any]],
    kinds: Mapping[str, Kind],
    damage: Damage,
    study: str = "",
) -> Table:
    """Return the table of the records of these sessions, and of their participants without one. Of
    a form, versions that were stored while it was filled in are left out.

    Of a study only what belongs to it leaves: the records of its sessions, those that name it
    (enrolment, consent, deviations and the like), and the forms that were filled in as its blocks.

    Args:
        sessions: as `store.sessions.listing` returns them. What was told before a session that
            never began leaves with those who had a live one: simulated people tell nothing.
        kinds: those that are declared here, by name.
        damage: notes values that cannot be read.
        study: name of the study that is exported; empty if no study is.
    """
    ids = {row["id"] for row in sessions}
    live = {
        code
        for row in sessions
        if is_personal(row["mode"])
        for code in (row["participant"], row["partner"])
    }
    return Table(
        name="records",
        title="A value of a record, in one of its versions; the last version counts",
        columns=tuple(stored(f"records.{name}") for name in (*_HEAD, *_VALUE)),
        key=("record", "version", "field"),
        rows=partial(_rows, ids, live, kinds, damage, study),
        of="participant",
        references=(TO_SESSION, TO_PARTICIPANT),
    )


def _rows(
    sessions: Collection[str],
    live: Collection[str],
    kinds: Mapping[str, Kind],
    damage: Damage,
    study: str,
    database: sqlite3.Connection,
    participant: str,
) -> Iterator[Values]:
    last = dict(database.execute(_LAST, (participant,)))
    forms = _forms_of(database, participant, study) if study else set()
    for *head, content in database.execute(
        f"SELECT {', '.join(_HEAD)}, content FROM records WHERE participant=?"
        " ORDER BY at, id, version",
        (participant,),
    ):
        session, kind = head[_SESSION], kinds.get(head[_KIND])
        is_entered = kind is None or kind.form is not None or kind.entered_by == "therapist"
        leaves = participant in live or is_entered if session is None else session in sessions
        values = _read(damage, content) if leaves else {}
        if study and session is None and head[_ID] not in forms:
            is_named = kind is not None and kind.group == "study" and values.get("study") == study
            leaves = leaves and is_named
        is_begun = kind is not None and kind.form is not None and values.get(STATUS) == OPEN
        if leaves and (not is_begun or head[_VERSION] == last[head[_ID]]):
            head[_REMOVED] = bool(head[_REMOVED])
            for name, value in values.items():
                yield (*head, name, *_value(kind, name, value))


def _forms_of(database: sqlite3.Connection, participant: str, study: str) -> set[str]:
    """Return the ids of the answers to forms of a study; of another site, with its sign."""
    found = set()
    for record, id in database.execute(_FORMS, (participant, study)):
        _, sign, site = id.partition("@")
        found.add(f"{record}{sign}{site}")
    return found


def _read(damage: Damage, content: str) -> dict[str, Any]:
    """Return the values of a record; none if they are damaged."""
    try:
        return msgspec.json.decode(content, type=dict[str, Any])
    except msgspec.MsgspecError:
        damage.note("record")
        return {}


def _value(
    kind: Kind | None, name: str, value: Any
) -> tuple[float | None, str, str | None, str | None]:
    """Return a value as a number with its unit, an option, or words: whichever it is. What no kind
    declares may have been typed.
    """
    field = next((each for each in kind.fields if each.name == name), None) if kind else None
    if isinstance(value, bool | int | float):
        return float(value), field.unit if field else "", None, None
    is_declined = field is not None and field.may_decline and value == NOT_SAID
    is_name = field is not None and not field.typed and name not in _IDS
    if field is not None and (field.type == "choice" or is_declined or is_name or name in _CODES):
        return None, "", str(value), None
    return None, "", None, str(value)

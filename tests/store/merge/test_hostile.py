"""A database from another site adds what is its own, and changes nothing of this site's people,
whatever it holds.
"""

import sqlite3
import zlib
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from sar_tui.store import programmes, sessions
from sar_tui.store.database import FILE, StoreError, connect
from sar_tui.store.merge import conflicts
from sar_tui.store.tables import TABLES
from tests.store.by_hand import insert, sql
from tests.store.merge.sites import change, copy, go_on, holds, merge, play, save_programme, site


@pytest.fixture
def zurich(tmp_path: Path) -> Path:
    folder = site(tmp_path / "zurich", "ZURICH")
    play(folder, "a1")
    play(folder, "a2", status="interrupted")
    save_programme(folder, "P01", 1, '{"attempts":5}')
    return folder


_PROGRAMME = "of the programme of P01 for keyboard"
_OTHER, _DAY = '{"attempts":99}', "2026-03-09"
_RESULTS = "UPDATE trials SET response='q', correct=0 WHERE session='a2'"
_SETTINGS = f"UPDATE sessions SET parameters='{_OTHER}' WHERE id='a2'"
_EARLIER = f"UPDATE programmes SET parameters='{_OTHER}', created_at='2020-01-01'"
_OWN: Any = {"participant": "P01@ZURICH", "site": "ZURICH"}
_NEWER = {**_OWN, "version": 2, "parameters": _OTHER, "created_at": "2026-01-01"}
_RECORD = {**_OWN, "id": "abc@ZURICH", "kind": "pain", "at": _DAY, "recorded_at": _DAY}
_EXPORT = {"number": None, "exported_at": _DAY, "sessions": "[]", "options": "{}", "site": "ZURICH"}
_PERSON = {"code": "P77@ZURICH", "created_at": _DAY, "site": "ZURICH"}


@pytest.fixture
def bern(tmp_path: Path, zurich: Path) -> Path:
    """A database that holds what Zurich recorded before, and a session of its own."""
    folder = site(tmp_path / "bern", "BERN")
    play(folder, "b1")
    merge(folder, zurich)
    return folder


def listed(folder: Path) -> list[str]:
    with closing(connect(folder)) as database:
        return [row["id"] for row in sessions.listing(database, folder, participant="P01")]


def older_copy(bern: Path) -> None:
    """Let the session go on in Zurich."""
    go_on(bern.with_name("zurich"), "a2")
    change(bern, "UPDATE sessions SET status='completed' WHERE id='a2'")


def new_session(bern: Path) -> None:
    play(bern, "a9", "P01@ZURICH")
    change(bern, "UPDATE sessions SET site='ZURICH' WHERE id='a9'")


def other_author(bern: Path) -> None:
    go_on(bern, "a2", trials=9)
    change(bern, "UPDATE sessions SET site='' WHERE id='a2'")


_ALTERED: dict[str, tuple[str, Callable[[Path], None]]] = {
    "an older copy": ("", older_copy),
    "a new session": ("session a9", new_session),
    "a longer session": ("session a2", lambda bern: go_on(bern, "a2", trials=9)),
    "other results": ("session a2", lambda bern: change(bern, _RESULTS)),
    "other settings": ("session a2", lambda bern: change(bern, _SETTINGS)),
    "another author": ("session a2", other_author),
    "an earlier programme": (f"version 1 {_PROGRAMME}", lambda bern: change(bern, _EARLIER)),
    "a new programme": (f"version 2 {_PROGRAMME}", lambda bern: insert(bern, "programmes", **_NEWER)),
    "a record": ("version 1 of the record abc (pain)", lambda bern: insert(bern, "records", **_RECORD)),
    "an export": ("export of 2026-03-09", lambda bern: insert(bern, "exports", **_EXPORT)),
    "a participant": ("participant P77", lambda bern: insert(bern, "participants", **_PERSON)),
}  # fmt: skip
"""Changes of what Zurich recorded. Of two versions of a programme the earlier one counts."""


@pytest.mark.parametrize("what", _ALTERED)
def test_ones_own_records_are_never_added_or_changed_by_another_site(
    zurich: Path, bern: Path, what: str
) -> None:
    named, alter = _ALTERED[what]
    alter(bern)
    before = holds(zurich)
    merged = merge(zurich, bern)
    why = "is ZURICH's by what BERN has, and is not so here. It is left out."
    assert merged.refused == ([f"The {named} {why}"] if named else [])
    assert (merged.added, merged.updated, merged.conflicts) == (["b1"], [], [])
    with closing(connect(zurich)) as database:
        assert programmes.newest(database, "P01", "keyboard").parameters == {"attempts": 5}
    assert [table for table, rows in holds(zurich).items() if before[table] - rows] == []
    for table in ("sessions", "trials", "messages"):
        assert {row[0] for row in holds(zurich)[table] - before[table]} == {"b1"}


def test_a_record_of_one_not_in_its_session_is_refused(zurich: Path, bern: Path) -> None:
    """It would be read as said by the person of this site who has the same seat."""
    before = holds(zurich)
    kinds = {"abc": "pain", "abd": "adverse-event"}
    for id, kind in kinds.items():
        insert(bern, "records", id=id, kind=kind, session="a1", at=_DAY, recorded_at=_DAY)
    merged = merge(zurich, bern)
    why = "is of session a1 by what BERN has, and P01@BERN was not in it. It is left out."
    assert sorted(merged.refused) == [
        f"The version 1 of the record {id}@BERN ({kind}) {why}" for id, kind in kinds.items()
    ]
    assert merged.added == ["b1"]
    assert holds(zurich)["records"] == before["records"]
    change(bern, "UPDATE records SET session='b1'")
    merged = merge(zurich, bern)
    assert (merged.refused, merged.records["records"]) == ([], 2)


def test_a_session_of_another_site_is_not_one_of_ones_own_people(zurich: Path, bern: Path) -> None:
    play(bern, "b2", "P01@ZURICH")
    save_programme(bern, "P01@ZURICH", 7, "{}")
    merged = merge(zurich, bern)
    why = "is BERN's by what BERN has, but P01 is of ZURICH. It is left out."
    whats = ("session b2", "version 7 of the programme of P01 for keyboard")
    assert merged.refused == [f"The {what} {why}" for what in whats]
    assert merged.added == ["b1"]
    assert listed(zurich) == ["a2", "a1"]


def test_only_this_site_says_who_of_its_people_is_somebody_elses(zurich: Path, bern: Path) -> None:
    merge(bern, None, same=("P01=P01@ZURICH",))
    merged = merge(zurich, bern)
    assert merged.refused[0].startswith("BERN says that P01@BERN and P01@ZURICH are one person.")
    assert merged.same == []
    assert listed(zurich) == ["a2", "a1"]
    merged = merge(zurich, bern, same=("P01@BERN=P01@ZURICH",))
    assert merged.refused == []
    assert {row[2] for row in holds(zurich)["seats"]} == {"P01@BERN"}


def kept_aside(bern: Path, content: Any, kind: str = "session", key: str = "a2") -> None:
    digest = conflicts.digest(content) if isinstance(content, dict) else "x"
    packed = zlib.compress(conflicts.encoded(content))
    insert(bern, "conflicts", kind=kind, key=key, digest=digest, content=packed)


def test_ones_own_record_that_is_kept_aside_there_does_not_come(zurich: Path, bern: Path) -> None:
    row = {"participant": "P01@ZURICH", "task": "keyboard", "version": 1, "created_at": "2020-01-01", "author": "",
           "reason": "", "parameters": "{}", "theme": "calm", "site": "ZURICH"}  # fmt: skip
    kept_aside(bern, {"programmes": [row]}, "programme", "P01@ZURICH keyboard 1")
    merged = merge(zurich, bern)
    assert len(merged.refused) == 1
    assert "other version of the programme P01@ZURICH keyboard 1" in merged.refused[0]
    assert merged.conflicts == []


@pytest.mark.parametrize(
    "content",
    [
        {"trials (session) SELECT 'x' --": [{"session": "b1"}]},
        {"programmes": [{"participant) VALUES ('x') --": 1}]},
        {"programmes": []}, {}, [],
        {"sessions": [{"id": "b1"}, {"id": "b2"}]},
    ],
)  # fmt: skip
def test_what_is_no_version_kept_aside_is_refused(zurich: Path, bern: Path, content: Any) -> None:
    before = holds(zurich)
    for kind in ("session", "programme", "odd"):
        kept_aside(bern, content, kind, "b1")
        with pytest.raises(StoreError, match=r"cannot be merged: conflicts\.content"):
            merge(zurich, bern)
        change(bern, "DELETE FROM conflicts")
    assert holds(zurich) == before


def test_a_version_kept_aside_is_not_unpacked_beyond_all_bounds(
    zurich: Path, bern: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(conflicts, "_MOST_BYTES", 10_000)
    packed = zlib.compress(bytes(10_000_000))
    insert(bern, "conflicts", kind="session", key="b1", digest="x", content=packed)
    with pytest.raises(StoreError, match=r"conflicts\.content"):
        merge(zurich, bern)


_VALUES = {
    "UPDATE seats SET participant=? WHERE session='b1'":
        ["P01; DROP", "p01", "P" * 40, "", "=1+1", "P01\x1b[2J", "-P"],
    "UPDATE participants SET code=? WHERE code='P01'": ["../P01", "Anna Muster", "P01\n"],
    "UPDATE sessions SET id=? WHERE id='b1'": ["../../evil", "/tmp/evil", "b 1", "", "=b1", "b" * 99],
    "UPDATE sessions SET site=? WHERE id='b1'": ["=ZURICH", "Z\x07", "z"],
    "UPDATE sessions SET task=? WHERE id='b1'": ["../keyboard", "key board", "key\x1bboard", "=cmd"],
    "UPDATE sessions SET theme=? WHERE id='b1'": ["../../calm", "calm\n"],
    "UPDATE sessions SET started_at=? WHERE id='b1'": ["<b>now</b>", "x" * 99],
    "UPDATE seats SET seat=? WHERE session='b1'": ["C", "A\x00"],
    "UPDATE notes SET text=? WHERE session='b1'": ["\x1b]0;title\x07", "n" * 4001],
    "UPDATE notes SET author=? WHERE session='b1'": ["op\u202eana"],
    "UPDATE attempts SET level=? WHERE session='b1'": ["high", b"1"],
    "UPDATE topics SET name=?||name WHERE id>1": ["\x1b", "="],
    "INSERT INTO programmes (participant, task, version, created_at, author, reason, parameters, theme, site)"
    " VALUES ('P01','keyboard',3,'','',?,'{}','calm','')": ["r" * 501, "\x9b2J"],
    "INSERT INTO same_people VALUES ('P01@BERN',?)": ["P01@", "=P01@GENF", "p01@genf"],
    "UPDATE site SET code=?": ["../BERN", "bern", "B" * 17],
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("statement", _VALUES)
def test_codes_names_and_texts_pass_the_rules_of_typed_ones(
    zurich: Path, bern: Path, tmp_path: Path, statement: str
) -> None:
    before = holds(zurich)
    for number, value in enumerate(_VALUES[statement]):
        altered = copy(bern, tmp_path / f"altered-{number}")
        with closing(sqlite3.connect(altered / FILE)) as database, database:
            sql(database, statement, value)
            if "sessions SET id" in statement:
                for table in ("seats", "runs", "attempts", "trials", "notes"):
                    sql(database, f"UPDATE {table} SET session=? WHERE session='b1'", value)
                sql(database, "UPDATE session_numbers SET id=? WHERE id='b1'", value)
        said = r"cannot be merged|There are seats without"
        with pytest.raises(StoreError, match=said) as refused:
            merge(zurich, altered)
        assert str(refused.value).isprintable(), value
    assert holds(zurich) == before


_ENDLESS = "WITH RECURSIVE n (x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n) SELECT x FROM n"
_SCHEMAS = {
    "a view stands in place of the table same_people":
        f"CREATE VIEW same_people AS SELECT x AS code, x AS same_as FROM ({_ENDLESS})",
    "a view stands in place of the table site":
        f"CREATE VIEW site AS SELECT 1 AS number, x AS code FROM ({_ENDLESS})",
    "a virtual table stands in place of the table notes":
        "CREATE VIRTUAL TABLE notes USING fts5 (session, at_ns, author, text, label)",
    "it lacks the table conflicts": "",
    "in the table notes, label is computed":
        "CREATE TABLE notes (session TEXT, at_ns INTEGER, author TEXT, text TEXT, label TEXT AS (zeroblob(9)))",
    "in the table notes, label is missing":
        "CREATE TABLE notes (session TEXT, at_ns INTEGER, author TEXT, text TEXT)",
}  # fmt: skip


@pytest.mark.parametrize("said", _SCHEMAS)
def test_what_stands_in_place_of_a_table_is_refused(zurich: Path, bern: Path, said: str) -> None:
    """The views are endless: a merge that read one would not return."""
    before = holds(zurich)
    (table,) = (word for word in said.replace(",", "").split() if word in TABLES)
    alter_schema(bern, f"DROP TABLE {table}", _SCHEMAS[said])
    with pytest.raises(StoreError, match=f"cannot be merged: {said}"):
        merge(zurich, bern)
    assert holds(zurich) == before


def test_schemas_of_another_database_are_never_run(zurich: Path, bern: Path) -> None:
    alter_schema(
        bern,
        "CREATE TRIGGER named AFTER UPDATE ON seats BEGIN INSERT INTO same_people SELECT x, x "
        f"FROM ({_ENDLESS}); END",
        "CREATE TRIGGER left_out AFTER DELETE ON programmes BEGIN UPDATE sessions SET "
        "site='ZURICH'; END",
        "CREATE INDEX costly ON notes (hex(zeroblob(1000000)))",
        f"CREATE VIEW v_mine AS {_ENDLESS}",
        "DROP VIEW settings",
        f"CREATE VIEW settings AS {_ENDLESS}",
        "DROP TABLE exports",
        "CREATE TABLE exports (number INTEGER PRIMARY KEY, exported_at TEXT, exported_by TEXT, "
        "recipient TEXT, format TEXT, sessions TEXT, options TEXT, manifest TEXT CHECK "
        "(length(hex(zeroblob(100000000))) > 0), site TEXT)",
    )
    merged = merge(zurich, bern)
    assert (merged.added, merged.refused) == (["b1"], [])


def alter_schema(folder: Path, *statements: str) -> None:
    with closing(sqlite3.connect(folder / FILE)) as database, database:
        for statement in statements:
            database.execute(statement)

"""Letters that were changed, forged, replayed or given to another: refused, and nothing changed."""

import hashlib
import random
import sqlite3
import zlib
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from sar_tui.letterbox import identity, sealing
from sar_tui.letterbox.contents import check_rows, of_person, pack
from sar_tui.letterbox.correspondents import correspondents
from sar_tui.letterbox.sealing import Keys, Letter
from sar_tui.store.database import StoreError, connect
from sar_tui.store.tables import SESSION_TABLES, TABLES
from tests.letterbox.household import Clinic, Home, put, rows, settle


def contents(clinic: Clinic) -> dict[str, str]:
    """Return what a database holds, by table; without the list of files that were looked at."""
    with closing(connect(clinic.data)) as db:
        return {
            table: hashlib.sha256(
                repr(db.execute(f"SELECT * FROM {table}").fetchall()).encode()
            ).hexdigest()
            for table in TABLES
            if table != "letter_files"
        }


def letter_of(home: Home) -> bytes:
    """Return a letter with a session, which lies in the letterbox no longer."""
    before = {path.name for path in home.box.iterdir()}
    home.train_today()
    home.exchange()
    (path,) = (path for path in home.box.iterdir() if path.name not in before)
    sealed = path.read_bytes()
    path.unlink()
    return sealed


# --- bytes that were changed by whoever has the folder


@pytest.mark.parametrize("count", [300, pytest.param(10_000, marks=pytest.mark.slow)])
def test_no_letter_that_was_changed_is_accepted(
    count: int, clinic: Clinic, home: Home, tmp_path: Path
) -> None:
    other = clinic.home("P08", tmp_path / "other")
    settle(other, clinic, home)
    letters = [letter_of(home), letter_of(other)]
    luck, before = random.Random(count), contents(clinic)
    names = 0
    for start in range(0, count, 500):
        some = [_changed(letters, luck) for _ in range(min(500, count - start))]
        for number, sealed in enumerate(some):
            (clinic.box / f"{start + number:032x}.letter").write_bytes(sealed)
        done = clinic.exchange()
        assert not done.taken
        names += len(done.refused)
        for path in clinic.box.glob(f"{'0' * 20}*.letter"):
            path.unlink()
    assert names == count
    assert contents(clinic) == before
    (clinic.box / "whole.letter").write_bytes(letters[0])  # the letter itself is accepted
    assert clinic.exchange().taken == [("P07", 1)]


def _changed(letters: list[bytes], luck: random.Random) -> bytes:
    """Return a letter with some bytes changed, cut off, added, moved, or of another letter."""
    sealed = bytearray(luck.choice(letters))
    how = luck.randrange(6)
    at = luck.randrange(len(sealed))
    if how == 0:
        sealed[at] ^= 1 << luck.randrange(8)
    elif how == 1:
        del sealed[at:]
    elif how == 2:
        sealed += luck.randbytes(luck.randrange(1, 200))
    elif how == 3:
        for _ in range(luck.randrange(1, 100)):
            sealed[luck.randrange(len(sealed))] ^= luck.randrange(1, 256)
    elif how == 4:
        half = min(at + 1, len(letters[0]) - 1)
        sealed = bytearray(letters[0][:half] + letters[1][half:])
    else:
        sealed[: at + 1] = luck.randbytes(at + 1)
    return bytes(sealed)


# --- letters by somebody with keys


def test_a_letter_of_a_stranger_is_refused(clinic: Clinic, home: Home) -> None:
    before = contents(clinic)
    put(clinic, Keys.new())
    put(clinic, Keys.new(), secret=b"guessed" * 4, seal_key=Keys.new().public.seal)
    refused = clinic.exchange().refused
    assert ["nobody who is known here wrote it" in one for one in refused] == [True, True]
    assert contents(clinic) == before


def test_a_letter_to_another_reader_is_refused_by_who_gets_it(
    clinic: Clinic, home: Home, tmp_path: Path
) -> None:
    """The clinic of another city reads a letter, and seals what was signed to this clinic."""
    import nacl.public
    import nacl.signing

    keys = identity.require(home.data).keys
    elsewhere = Keys.new()
    letter = Letter(reader=elsewhere.public.seal, number=99, written_at="")
    theirs = sealing.seal(letter, keys)
    signed = nacl.public.SealedBox(nacl.public.PrivateKey(elsewhere.seal)).decrypt(theirs)
    me = identity.require(clinic.data).keys.public
    again = bytes(nacl.public.SealedBox(nacl.public.PublicKey(me.seal)).encrypt(signed))
    before = contents(clinic)
    (clinic.box / "again.letter").write_bytes(again)
    assert "written to another computer" in "".join(clinic.exchange().refused)
    assert contents(clinic) == before


def test_a_replayed_letter_changes_nothing(clinic: Clinic, home: Home) -> None:
    sealed = letter_of(home)
    (clinic.box / "first.letter").write_bytes(sealed)
    assert clinic.exchange().taken == [("P07", 1)]
    before = contents(clinic)
    (clinic.box / "second.letter").write_bytes(sealed)
    done = clinic.exchange()
    assert (done.taken, done.doubled) == ([], 1)
    answered = {"letters": "", "correspondents": ""}
    assert {**contents(clinic), **answered} == {**before, **answered}


def test_another_letter_with_a_number_that_was_used_is_refused_and_asked_for_again(
    clinic: Clinic, home: Home
) -> None:
    keys = identity.require(home.data).keys
    put(clinic, keys, number=1)
    assert "another one of this number" in "".join(clinic.exchange().refused)
    (one,) = [each for each in _correspondents(clinic) if each.participant == "P07"]
    assert (one.wanted, one.owes_answer) == ((), 0)  # told by the letter that was just written
    assert clinic.query("SELECT count(*) FROM letters WHERE direction='in'") == [(2,)]


def _correspondents(clinic: Clinic) -> Any:
    with closing(connect(clinic.data)) as db:
        return correspondents(db)


# --- a home that is not honest: its letters touch only its own person


def database_of(home: Home) -> bytes:
    """Return the database of a letter with all that a home may send."""
    with closing(connect(home.data)) as db:
        own = of_person(db, "P07")
    del own["programmes"], own["people_events"]
    return zlib.decompress(pack(home.data, "P07", own))


@pytest.mark.parametrize(
    ("sql", "why"),
    [
        ("UPDATE seats SET participant='P08'", "another person"),
        (
            "INSERT INTO participants (code, created_at) VALUES ('P09', '2026-01-01')",
            "another person",
        ),
        ("DELETE FROM seats", "without a person"),
        ("UPDATE trials SET session='other'", "does not bring"),
        ("UPDATE session_numbers SET id='other'", "does not bring"),
        ("UPDATE sessions SET site='ZURICH'", "another site"),
        ("UPDATE site SET code='ZURICH'", "another site"),
        ("DELETE FROM site", "another site"),
        (
            "INSERT INTO programmes (participant, task, version, parameters, theme, created_at,"
            " author, reason) VALUES ('P07', 'keyboard', 9, '{}', 'calm', '2026-01-01', '', '')",
            "programmes",
        ),
        (
            "INSERT INTO people_events (id, event, participant, at) VALUES"
            " ('x', 'erased', 'P07', '2026-01-01')",
            "people_events",
        ),
        ("INSERT INTO same_people VALUES ('P07@BERN', 'P08@ZURICH')", "same_people"),
        (
            "INSERT INTO records (id, version, kind, participant, seat, moment, at, content, recorded_at) VALUES"
            " ('ab', 1, 'message-home', 'P07', 'A', '', '2026-01-01', '{\"text\":\"x\"}', '2026-01-01')",
            "only a clinic writes",
        ),
        (
            "INSERT INTO records (id, version, kind, participant, seat, moment, at, content, recorded_at) VALUES"
            " ('ab', 1, 'adverse-event', 'P08', 'A', '', '2026-01-01', '{}', '2026-01-01')",
            "another person",
        ),
    ],
)
def test_a_home_cannot_write_what_is_not_its_own(
    sql: str, why: str, clinic: Clinic, home: Home
) -> None:
    home.train_today()
    home.record("adverse-event", "P07", what="dizzy", severity="mild")
    place = home.data.parent / "letter.db"
    place.write_bytes(database_of(home))
    before = contents(clinic)
    with closing(sqlite3.connect(place)) as changed:
        changed.executescript(sql)
    with closing(connect(clinic.data)) as db:
        db.execute("ATTACH ? AS other", (str(place),))
        with pytest.raises(StoreError, match=why):
            check_rows(db, "P07", "home")
    put(clinic, identity.require(home.data).keys, rows=sealing.packed(place.read_bytes()))
    assert len(clinic.exchange().refused) == 1
    answered = {"letters": "", "correspondents": ""}
    assert {**contents(clinic), **answered} == {**before, **answered}


def test_a_home_cannot_change_the_session_or_record_of_another_person(
    clinic: Clinic, home: Home, tmp_path: Path
) -> None:
    other = clinic.home("P08", tmp_path / "other")
    theirs = other.train_today()
    event = other.record("adverse-event", "P08", what="dizzy", severity="mild")
    settle(other, clinic)
    home.train_today()
    home.record("adverse-event", "P07", what="dizzy", severity="mild")
    place = home.data.parent / "letter.db"
    for tables, old, new in (
        (("sessions", "session_numbers", *SESSION_TABLES), "session", theirs),
        (("records",), "record", event),
    ):
        place.write_bytes(database_of(home))
        with closing(sqlite3.connect(place, isolation_level=None)) as changed:
            for table in tables:
                column = "session" if table in SESSION_TABLES else "id"
                changed.execute(f"UPDATE {table} SET {column}=?", (new,))
        with closing(connect(clinic.data)) as db:
            db.execute("ATTACH ? AS other", (str(place),))
            with pytest.raises(StoreError, match=f"would change a {old} of another person"):
                check_rows(db, "P07", "home")


@pytest.mark.parametrize("count", [40, pytest.param(600, marks=pytest.mark.slow)])
def test_a_database_in_a_letter_that_was_damaged_never_harms(
    count: int, clinic: Clinic, home: Home
) -> None:
    """A home with good keys sends databases with changed bytes: each is refused, or is the person's
    own; no other person changes, and no error escapes.
    """
    keys = identity.require(home.data).keys
    home.train_today()
    database = database_of(home)
    luck, others = random.Random(count), rows(clinic, "P08")
    for number in range(count):
        changed = bytearray(database)
        for _ in range(luck.choice((1, 3, 30))):
            changed[luck.randrange(len(changed))] = luck.randrange(256)
        if luck.random() < 0.1:
            del changed[luck.randrange(len(changed)) :]
        put(clinic, keys, number=100 + number, rows=sealing.packed(bytes(changed)))
    clinic.exchange()
    assert rows(clinic, "P08") == others
    assert clinic.query("PRAGMA integrity_check") == [("ok",)]
    arrived = clinic.query("SELECT count(*) FROM letters WHERE direction='in' AND number>=100")
    assert arrived == [(count,)]


def test_rows_that_cannot_be_unpacked_or_are_too_large_are_refused(
    clinic: Clinic, home: Home, monkeypatch: pytest.MonkeyPatch
) -> None:
    keys = identity.require(home.data).keys
    put(clinic, keys, number=50, rows=b"no zlib")
    monkeypatch.setattr(sealing, "_MOST_ROWS", 10_000)
    put(clinic, keys, number=51, rows=sealing.packed(bytes(20_000)))
    refused = "".join(clinic.exchange().refused)
    assert "cannot be unpacked" in refused
    assert "larger than any session" in refused


@pytest.mark.parametrize(
    "changes",
    [
        {"taken": ((1, 2**63),)},
        {"seen": ((-1, 5),)},
        {"wanted": (2**64 - 1,)},
        {"number": 0},
        {"number": 2**63 - 1},
    ],
)
def test_numbers_that_no_letter_has_are_refused(
    changes: dict[str, Any], clinic: Clinic, home: Home
) -> None:
    before = contents(clinic)
    put(clinic, identity.require(home.data).keys, **changes)
    assert "a number in it is wrong" in "".join(clinic.exchange().refused)
    assert contents(clinic) == before


def test_a_home_that_claims_letters_that_were_never_written_harms_only_itself(
    clinic: Clinic, home: Home, tmp_path: Path
) -> None:
    other = clinic.home("P08", tmp_path / "other")
    settle(other, clinic, home)
    put(clinic, identity.require(home.data).keys, taken=((1, 2**31),))
    clinic.exchange()
    clinic.record("message-home", "P08", text="to P08")
    clinic.record("message-home", "P07", text="to P07")
    settle(clinic, other)
    assert other.query("SELECT count(*) FROM records") == [(1,)]


def test_one_homes_keys_open_only_its_own_letters(
    clinic: Clinic, home: Home, tmp_path: Path
) -> None:
    other = clinic.home("P08", tmp_path / "other")
    for each in (home, other):
        each.train_today()
        each.exchange()
    for code in ("P07", "P08"):
        clinic.record("message-home", code, text=f"to {code}")
    clinic.exchange()
    keys = identity.require(home.data).keys
    read, closed = [], 0
    for path in clinic.box.glob("*.letter"):
        try:
            opened = sealing.open_letter(path.read_bytes(), keys)
        except sealing.Damaged:
            closed += 1
        else:
            read.append(zlib.decompress(opened.letter.rows) if opened.letter.rows else b"")
    assert read
    assert closed > len(read)  # its own letters to the clinic stay closed, too
    assert any(b"to P07" in each for each in read)
    assert not any(b"P08" in each for each in read)

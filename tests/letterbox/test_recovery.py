"""States from which both sides come back to one: records apart from their sessions, restored
backups, refusals, and computers that join again.
"""

import shutil
from contextlib import closing
from datetime import timedelta
from pathlib import Path

import pytest

from sar_tui.letterbox import exchange as exchange_module
from sar_tui.letterbox import identity, letterbox, sealing, status
from sar_tui.letterbox.correspondents import correspondents
from sar_tui.letterbox.sealing import Keys
from sar_tui.store.database import connect
from tests.letterbox.household import Clinic, Computer, Home, copy_of, put, rows, settle


def rate(home: Computer, session: str | None, code: str = "P07") -> None:
    """Record pain of a session."""
    from sar_tui.store import records

    with closing(connect(home.data)) as db:
        given = {"answer": "rated", "rating": 3}
        records.add(db, records.kind_of("pain"), code, "", given, session=session, moment="after")


def go_back(computer: Computer, earlier: Path) -> None:
    """Restore a computer from a backup."""
    shutil.rmtree(computer.data)
    shutil.copytree(earlier, computer.data)


def missing(clinic: Clinic) -> tuple[int, ...]:
    with closing(connect(clinic.data)) as db:
        return status.homes(db)[0].missing


# --- records and their sessions


def test_a_record_that_is_entered_after_its_session_was_sent_arrives(
    clinic: Clinic, home: Home
) -> None:
    session = home.train_today()
    settle(home, clinic)
    rate(home, session)
    settle(home, clinic)
    assert rows(clinic, "P07") == rows(home, "P07")
    assert clinic.query("SELECT session FROM records") == [(session,)]


def test_records_of_several_sessions_arrive_with_them(clinic: Clinic, home: Home) -> None:
    for seed in (1, 2, 3):
        rate(home, home.train_today(seed))
    rate(home, None)
    settle(home, clinic)
    assert rows(clinic, "P07") == rows(home, "P07")


def test_a_record_that_overtakes_its_session_waits_for_it(clinic: Clinic, home: Home) -> None:
    session = home.train_today()
    home.exchange()
    ((first,),) = home.query(
        "SELECT file FROM letters WHERE direction='out' AND contents LIKE '%sess%'"
    )
    rate(home, session)
    home.exchange()
    held_back = (home.box / first).rename(home.box / ".held back")
    done = clinic.exchange()
    assert "waits for a session" in "".join(done.troubles)
    assert clinic.query("SELECT count(*) FROM records") == [(0,)]
    held_back.rename(home.box / first)
    settle(home, clinic)
    assert rows(clinic, "P07") == rows(home, "P07")


def test_a_long_history_with_records_reaches_a_new_home(
    clinic: Clinic, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from sar_tui.letterbox import contents

    monkeypatch.setattr(contents, "_AT_ONCE", 3)
    monkeypatch.setattr(contents, "_NEWEST", 5)
    for seed in range(8):
        rate(clinic, clinic.train("P08", seed), "P08")
    new = clinic.home("P08", tmp_path / "new")
    settle(new, clinic)
    assert new.query("SELECT count(*) FROM sessions") == [(5,)]
    assert new.query("SELECT count(*) FROM records") == [(5,)]
    new.train_today(seed=20)
    settle(new, clinic)
    assert clinic.query("SELECT count(*) FROM sessions") == [(9,)]
    with closing(connect(clinic.data)) as db:
        assert status.homes(db)[0].refused == ()


# --- backups


def test_a_clinic_that_is_restored_gets_again_what_had_arrived(
    clinic: Clinic, home: Home, tmp_path: Path
) -> None:
    home.train_today(seed=1)
    settle(home, clinic)
    earlier = copy_of(clinic, tmp_path / "backup")
    for seed in (2, 3, 4):
        home.train_today(seed)
        settle(home, clinic)
    go_back(clinic, earlier)
    home.train_today(seed=5)
    settle(home, clinic)
    home.train_today(seed=6)
    settle(home, clinic)
    assert rows(clinic, "P07") == rows(home, "P07")
    assert len(clinic.query("SELECT id FROM sessions")) == 6
    assert missing(clinic) == ()


def test_a_home_that_is_restored_gets_again_what_the_clinic_wrote(
    clinic: Clinic, home: Home, tmp_path: Path
) -> None:
    earlier = copy_of(home, tmp_path / "backup")
    clinic.save("P07", prompts_per_attempt=5)
    clinic.record("message-home", "P07", text="Well done.")
    settle(clinic, home)
    go_back(home, earlier)
    home.train_today(seed=1)
    settle(home, clinic)
    clinic.record("message-home", "P07", text="Once more.")
    settle(clinic, home)
    assert rows(clinic, "P07") == rows(home, "P07")
    assert home.query("SELECT max(version) FROM programmes") == [(2,)]


def test_a_clinic_that_is_restored_to_before_the_home_joined_admits_it_again(
    clinic: Clinic, tmp_path: Path
) -> None:
    invited = clinic.invite("P08")
    earlier = copy_of(clinic, tmp_path / "backup")
    home = Home(tmp_path / "h", "P08", invited.file.read_bytes(), invited.code, clinic.box)
    home.train_today(seed=1)
    settle(home, clinic)
    go_back(clinic, earlier)
    home.train_today(seed=2)
    settle(home, clinic)
    home.train_today(seed=3)
    settle(home, clinic)
    assert len(clinic.query("SELECT id FROM sessions")) == 3


# --- answers and refusals


def test_an_answer_that_was_lost_is_given_again(clinic: Clinic, home: Home) -> None:
    home.train_today()
    home.exchange()
    clinic.exchange()
    for path in clinic.box.glob("*.letter"):
        path.unlink()  # the answer, too
    home.clock.true += timedelta(days=3)
    settle(home, clinic)
    with closing(connect(home.data)) as db:
        found = status.clinic(db)
    assert found is not None
    assert found.waiting == 0


def test_a_letter_of_a_newer_program_waits_until_this_one_is_updated(
    clinic: Clinic, home: Home, monkeypatch: pytest.MonkeyPatch
) -> None:
    home.train_today()
    monkeypatch.setattr(exchange_module, "VERSION", exchange_module.VERSION + 1)
    home.exchange()
    monkeypatch.undo()
    assert "newer sar-tui" in "".join(clinic.exchange().troubles)
    assert home.exchange().taken == []
    monkeypatch.setattr(exchange_module, "VERSION", exchange_module.VERSION + 1)
    settle(home, clinic)
    assert rows(clinic, "P07") == rows(home, "P07")


def test_a_home_is_told_that_a_letter_was_refused(clinic: Clinic, home: Home) -> None:
    session = home.train_today()
    with closing(connect(home.data)) as db:
        db.execute("UPDATE trials SET correct=1-correct WHERE session=?", (session,))
    settle(home, clinic)
    with closing(connect(home.data)) as db:
        found = status.clinic(db)
    assert found is not None
    assert (found.refused, found.waiting) == (1, 0)
    assert missing(clinic) == ()


def test_a_letter_whose_number_is_too_high_is_refused(clinic: Clinic, home: Home) -> None:
    put(clinic, identity.require(home.data).keys, number=2**31)
    assert "too high" in "".join(clinic.exchange().refused)
    assert missing(clinic) == ()


def test_a_letter_that_is_nested_without_end_holds_up_nobody(clinic: Clinic, home: Home) -> None:
    import nacl.public
    import nacl.signing

    me = identity.require(clinic.data).keys.public
    signer = nacl.signing.SigningKey(Keys.new().sign)
    nested = b"\x81\xa6device\x81\xa1a" + b"\x91" * 60_000 + b"\xc0"
    signed = signer.sign(sealing._LETTER + bytes(signer.verify_key) + nested)
    padded = sealing._padded(bytes(signed))
    sealed = nacl.public.SealedBox(nacl.public.PublicKey(me.seal)).encrypt(padded)
    (clinic.box / "0.letter").write_bytes(bytes(sealed))
    session = home.train_today()
    home.exchange()
    assert "not the form of a letter" in "".join(clinic.exchange().refused)
    assert clinic.query("SELECT id FROM sessions") == [(session,)]


def test_a_home_with_a_key_that_is_none_is_not_admitted(clinic: Clinic, home: Home) -> None:
    invited = clinic.invite("P08")
    secret = sealing.open_invitation(invited.file.read_bytes(), invited.code).secret
    put(clinic, Keys.new(), number=1, secret=secret, seal_key=bytes(32))
    assert "key to write back to" in "".join(clinic.exchange().refused)
    home.train_today()
    settle(home, clinic)
    assert rows(clinic, "P07") == rows(home, "P07")


# --- joining again


def test_a_revoked_home_joins_again_with_another_invitation(clinic: Clinic, home: Home) -> None:
    home.train_today(seed=1)
    settle(home, clinic)
    letterbox.revoke(clinic.data, "P07")
    settle(clinic, home)
    invited = clinic.invite("P07")
    letterbox.join(home.data, invited.file.read_bytes(), invited.code, home.box, now=home.clock())
    clinic.save("P07", prompts_per_attempt=5)
    home.train_today(seed=2)
    settle(home, clinic)
    assert rows(clinic, "P07") == rows(home, "P07")
    with closing(connect(home.data)) as db:
        found = status.clinic(db)
    assert found is not None
    assert found.state == "joined"


def test_a_home_whose_invitation_was_revoked_before_it_joined_is_told(
    clinic: Clinic, tmp_path: Path
) -> None:
    invited = clinic.invite("P08")
    letterbox.revoke(clinic.data, "P08")
    home = Home(tmp_path / "h", "P08", invited.file.read_bytes(), invited.code, clinic.box)
    for each in (home, clinic, home):
        each.exchange()
    with closing(connect(home.data)) as db:
        found = status.clinic(db)
    assert found is not None
    assert found.state == "revoked"


def test_one_invitation_makes_one_home_and_one_answer(clinic: Clinic, home: Home) -> None:
    invited = clinic.invite("P08")
    secret = sealing.open_invitation(invited.file.read_bytes(), invited.code).secret
    for _ in range(5):
        keys = Keys.new()
        put(clinic, keys, number=1, secret=secret, seal_key=keys.public.seal)
        clinic.exchange()
    with closing(connect(clinic.data)) as db:
        states = sorted(one.state for one in correspondents(db) if one.participant == "P08")
    assert states == ["declined", "joined"]


# --- people


def test_numbers_that_never_come_are_not_missing(clinic: Clinic, home: Home) -> None:
    from sar_tui.store.erasure import erase

    clinic.record("message-home", "P07", text="Well done.")
    clinic.exchange()
    for path in clinic.box.glob("*.letter"):
        path.unlink()
    erase(clinic.data, "P07", author="th", reason="asked for")
    settle(clinic, home)
    with closing(connect(home.data)) as db:
        found = status.clinic(db)
    assert found is not None
    assert found.missing == ()


def test_a_person_who_is_de_identified_writes_no_more_under_the_old_code(
    clinic: Clinic, home: Home
) -> None:
    from sar_tui.store.erasure import de_identify

    home.train_today(seed=1)
    settle(home, clinic)
    de_identify(clinic.data, "P07", author="th", reason="asked for")
    home.train_today(seed=2)
    for _ in range(2):
        home.exchange()
        clinic.exchange()
    assert clinic.query("SELECT count(*) FROM seats WHERE participant='P07'") == [(0,)]


def test_a_session_that_was_moved_to_another_person_holds_up_no_letter(
    clinic: Clinic, home: Home
) -> None:
    from sar_tui.store.record_changes import move

    moved = home.train_today(seed=1)
    settle(home, clinic)
    with closing(connect(clinic.data)) as db:
        move(db, clinic.data, moved, "A", "P08", actor="therapist", reason="wrong person")
    with closing(connect(home.data)) as db:
        from sar_tui.store.record_changes import change_status

        change_status(db, home.data, moved, "discarded", actor="therapist", reason="a test")
    second = home.train_today(seed=2)
    settle(home, clinic)
    found = dict(clinic.query("SELECT session, participant FROM seats"))
    assert found == {moved: "P08", second: "P07"}


def test_a_home_cannot_change_a_record_of_the_clinic(clinic: Clinic, home: Home) -> None:
    message = clinic.record("adverse-event", "P07", what="dizzy", severity="mild")
    settle(clinic, home)
    with closing(connect(home.data)) as db:
        from sar_tui.store import records

        records.correct(db, message, {"what": "nothing"})
    before = clinic.query("SELECT * FROM records")
    home.exchange()
    assert "would change a record of the clinic" in "".join(clinic.exchange().refused)
    assert clinic.query("SELECT * FROM records") == before


def test_a_form_that_was_filled_in_is_not_asked_again_by_a_clock_that_is_wrong(
    clinic: Clinic, home: Home
) -> None:
    from sar_tui.store import records

    clinic.record("report-request", "P07", form="NASA-TLX")
    home.clock.wrong = -timedelta(days=365)
    settle(clinic, home)
    with closing(connect(home.data)) as db:
        kind = records.kind_of("NASA-TLX")
        assert status.requested_form(db, "P07") == "NASA-TLX"
        given = {item.name: 50 for item in kind.items}
        records.add(
            db, kind, "P07", "", given, now=home.clock() + timedelta(minutes=5), is_new=False
        )
        assert status.requested_form(db, "P07") == ""


def test_a_session_that_was_interrupted_at_home_goes_on_only_there(
    clinic: Clinic, home: Home
) -> None:
    from sar_tui.runs.patient_plan import unfinished
    from sar_tui.runs.run import find_resumable
    from sar_tui.store.database import StoreError
    from sar_tui.store.sessions import latest_interrupted

    session = home.train_today(attempts=2, leave_after=1)
    settle(home, clinic)
    with closing(connect(clinic.data)) as db:
        with pytest.raises(StoreError, match="begun on another computer"):
            find_resumable(db, clinic.data, session)
        assert latest_interrupted(db, clinic.data) is None
        assert unfinished(db, clinic.data, "P07", "keyboard", clinic.clock) is None
    with closing(connect(home.data)) as db:
        assert find_resumable(db, home.data, session)["id"] == session
        assert unfinished(db, home.data, "P07", "keyboard", home.clock) == session

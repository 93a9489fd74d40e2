"""A home and a clinic exchange letters through one folder."""

from contextlib import closing
from datetime import timedelta
from pathlib import Path

import pytest

from sar_tui.letterbox import correspondents, letterbox, status
from sar_tui.letterbox.contents import Busy, alone
from sar_tui.letterbox.exchange import exchange
from sar_tui.letterbox.folder import README
from sar_tui.store.database import StoreError, connect
from tests.letterbox.household import Clinic, Home, copy_of, rows, settle


@pytest.fixture
def home(clinic: Clinic, tmp_path: Path) -> Home:
    return clinic.home("P07", tmp_path / "home")


_ON_THE_WAY = (
    "SELECT number, file FROM letters WHERE direction='out' AND state='sent' AND contents<>'{}'"
)


def test_a_finished_session_arrives_with_the_next_exchange(clinic: Clinic, home: Home) -> None:
    settle(home, clinic)
    session = home.train_today()
    assert home.exchange().written == 1
    done = clinic.exchange()
    assert done.taken == [("P07", 1)]
    assert done.changed == ["P07"]
    assert clinic.query("SELECT id FROM sessions") == [(session,)]
    assert rows(clinic, "P07") == rows(home, "P07")


def test_both_sides_fall_silent_when_all_is_said(clinic: Clinic, home: Home) -> None:
    home.train_today()
    settle(home, clinic)
    names = sorted(path.name for path in clinic.box.iterdir())
    assert not any(one.written for one in (home.exchange(), clinic.exchange()))
    assert sorted(path.name for path in clinic.box.iterdir()) == names
    assert len(names) <= 2  # what is to read, and a last answer


def test_a_new_version_of_the_programme_is_what_the_next_session_runs(
    clinic: Clinic, home: Home
) -> None:
    settle(home, clinic)
    saved = clinic.save("P07", prompts_per_attempt=5)
    clinic.exchange()
    home.exchange()
    session = home.train_today()
    assert home.query("SELECT programme FROM sessions WHERE id=?", session) == [(saved.version,)]
    assert home.query("SELECT count(*) FROM trials") == [(5,)]


def test_a_programme_is_there_before_the_clinic_has_heard_of_the_home(home: Home) -> None:
    assert home.query("SELECT participant, task, version FROM programmes") == [
        ("P07", "keyboard", 1)
    ]
    assert home.train_today()


def test_records_at_home_and_a_message_of_the_clinic_cross(clinic: Clinic, home: Home) -> None:
    settle(home, clinic)
    home.record("adverse-event", "P07", what="dizzy", severity="mild")
    clinic.record("message-home", "P07", text="Well done this week.")
    settle(home, clinic)
    assert rows(clinic, "P07") == rows(home, "P07")
    with closing(connect(home.data)) as db:
        assert [one.content["text"] for one in status.unread(db, "P07")] == ["Well done this week."]


def test_what_was_looked_at_is_told_by_the_next_letter(clinic: Clinic, home: Home) -> None:
    home.train_today()
    settle(home, clinic)

    def seen() -> object:
        with closing(connect(home.data)) as db:
            found = status.clinic(db)
            assert found is not None
            assert found.arrived == home.clock().date()
            return found.seen

    assert seen() is None
    with closing(connect(clinic.data)) as db:
        correspondents.mark_seen(db, "P07")
    settle(clinic, home)
    assert seen() == home.clock().date()


def test_history_reaches_a_new_computer_and_goes_on(clinic: Clinic, tmp_path: Path) -> None:
    old = clinic.home("P07", tmp_path / "old")
    first = old.train_today()
    settle(old, clinic)
    letterbox.revoke(clinic.data, "P07")
    new = clinic.home("P07", tmp_path / "new")
    settle(new, clinic)
    assert new.query("SELECT id FROM sessions") == [(first,)]
    second = new.train_today(seed=2)
    settle(new, clinic)
    assert {id for (id,) in clinic.query("SELECT id FROM sessions")} == {first, second}


def test_two_computers_of_one_person_know_each_others_sessions(
    clinic: Clinic, home: Home, tmp_path: Path
) -> None:
    other = clinic.home("P07", tmp_path / "other")
    home.train_today(seed=1)
    other.train_today(seed=2)
    settle(home, other, clinic)
    assert rows(home, "P07") == rows(other, "P07") == rows(clinic, "P07")
    with closing(connect(clinic.data)) as db:
        assert [one.name for one in status.homes(db)] == ["P07", "P07/2"]


def test_a_session_that_went_on_after_it_was_sent_is_sent_again(clinic: Clinic, home: Home) -> None:
    session = home.train_today()
    settle(home, clinic)
    with closing(connect(home.data)) as db:
        from sar_tui.store.record_changes import change_status

        change_status(db, home.data, session, "discarded", actor="therapist", reason="a test")
    settle(home, clinic)
    assert clinic.query("SELECT status FROM sessions") == [("discarded",)]
    assert rows(clinic, "P07") == rows(home, "P07")


def test_a_session_that_arrives_late_stands_where_it_belongs(clinic: Clinic, home: Home) -> None:
    settle(home, clinic)
    home.clock.true += timedelta(days=1)
    clinic.clock.true += timedelta(days=2)
    at_home = home.train_today()
    at_clinic = clinic.train("P07", seed=2)
    settle(home, clinic)
    for each in (clinic, home):
        assert each.query("SELECT id FROM sessions ORDER BY rowid") == [(at_home,), (at_clinic,)]


def test_letters_of_a_revoked_home_are_refused_and_it_is_told(clinic: Clinic, home: Home) -> None:
    settle(home, clinic)
    letterbox.revoke(clinic.data, "p07")
    home.train_today()
    home.exchange()
    done = clinic.exchange()
    assert "revoked" in "".join(done.refused)
    assert clinic.query("SELECT count(*) FROM sessions") == [(0,)]
    home.exchange()
    with closing(connect(home.data)) as db:
        found = status.clinic(db)
    assert found is not None
    assert found.state == "revoked"
    home.train_today(seed=2)
    assert home.exchange().written == 0


def test_an_invitation_is_used_once_and_the_second_computer_is_told(
    clinic: Clinic, tmp_path: Path
) -> None:
    invited = clinic.invite("P07")
    given = ("P07", invited.file.read_bytes(), invited.code, clinic.box)
    first, second = Home(tmp_path / "1", *given), Home(tmp_path / "2", *given)
    settle(first, clinic)
    second.train_today()
    second.exchange()
    assert "used by another computer" in "".join(clinic.exchange().refused)
    second.exchange()
    with closing(connect(second.data)) as db:
        found = status.clinic(db)
    assert found is not None
    assert found.state == "declined"
    assert clinic.query("SELECT count(*) FROM sessions") == [(0,)]


def test_an_invitation_that_arrives_too_late_is_declined(clinic: Clinic, home: Home) -> None:
    home.exchange()
    clinic.clock.true += timedelta(days=31)
    assert "too old" in "".join(clinic.exchange().refused)


def test_a_lost_letter_is_named_and_written_again(clinic: Clinic, home: Home) -> None:
    settle(home, clinic)
    home.train_today(seed=1)
    home.exchange()
    (lost,) = home.query(_ON_THE_WAY)
    home.train_today(seed=2)
    home.exchange()
    not_brought = (clinic.box / lost[1]).rename(clinic.box / ".of the home alone")
    clinic.exchange()
    with closing(connect(clinic.data)) as db:
        assert status.homes(db)[0].missing == (lost[0],)
    not_brought.rename(home.box / lost[1])
    assert home.exchange().again == 1
    assert not (home.box / lost[1]).exists()  # it has another name
    settle(home, clinic)
    with closing(connect(clinic.data)) as db:
        assert status.homes(db)[0].missing == ()
    assert rows(clinic, "P07") == rows(home, "P07")


def test_a_letter_that_nobody_acknowledges_is_put_there_again_under_another_name(
    clinic: Clinic, home: Home
) -> None:
    settle(home, clinic)
    home.train_today()
    home.exchange()
    ((_, name),) = home.query(_ON_THE_WAY)
    before = home.box / name
    before.write_bytes(before.read_bytes()[:100])
    home.clock.true += timedelta(days=2, minutes=1)
    clinic.exchange()
    assert home.exchange().again == 1
    settle(home, clinic)
    assert rows(clinic, "P07") == rows(home, "P07")


def test_a_home_that_goes_back_to_an_earlier_state_loses_nothing(
    clinic: Clinic, home: Home, tmp_path: Path
) -> None:
    import shutil

    settle(home, clinic)
    earlier = copy_of(home, tmp_path / "backup")
    for seed in range(10, 14):
        home.train_today(seed=seed)
        settle(home, clinic)
    shutil.rmtree(home.data)
    shutil.copytree(earlier, home.data)
    second = home.train_today(seed=2)
    settle(home, clinic)
    third = home.train_today(seed=3)
    settle(home, clinic)
    there = {id for (id,) in clinic.query("SELECT id FROM sessions")}
    assert {second, third} < there
    assert len(there) == 6
    refused = clinic.query("SELECT count(*) FROM letter_files WHERE refused<>''")
    assert refused <= [(2,)]  # before the home heard of it


def test_what_was_erased_at_the_clinic_is_erased_at_home(clinic: Clinic, home: Home) -> None:
    from sar_tui.store.erasure import erase

    home.train_today()
    settle(home, clinic)
    erase(clinic.data, "P07", author="th", reason="asked for")
    settle(home, clinic)
    for each in (clinic, home):
        assert each.query("SELECT count(*) FROM sessions") == [(0,)]
        assert each.query("SELECT count(*) FROM programmes WHERE participant='P07'") == [(0,)]


def test_letters_wait_while_the_folder_is_gone(clinic: Clinic, home: Home) -> None:
    settle(home, clinic)
    session = home.train_today()
    away = clinic.box.rename(clinic.box.with_name("away"))
    with pytest.raises(StoreError, match="cannot be used"):
        home.exchange()
    away.rename(clinic.box)
    settle(home, clinic)
    assert clinic.query("SELECT id FROM sessions") == [(session,)]


def test_a_wrong_folder_gets_no_letters(home: Home) -> None:
    for path in home.box.iterdir():
        path.unlink()
    with pytest.raises(StoreError, match="no letterbox"):
        home.exchange()


def test_the_folder_tells_no_code_name_or_answer(
    clinic: Clinic, home: Home, tmp_path: Path
) -> None:
    home.train_today()
    home.record("adverse-event", "P07", what="Schwindel", severity="mild")
    clinic.record("message-home", "P07", text="Gut gemacht")
    clinic.invite("P08").file.rename(clinic.box / "0123.invitation")
    for each in (home, clinic):
        each.exchange()
    paths = [path for path in clinic.box.iterdir() if path.name != README]
    assert len(paths) == 3  # a letter each way, and the invitation
    secret = ("P07", "P08", "Bern", "BERN", "Schwindel", "mild", "Gut gemacht", "keyboard")
    for path in paths:
        content = path.read_bytes()
        for word in (
            *secret,
            "SQLite",
            "sar-tui letter",
            home.query("SELECT id FROM sessions")[0][0],
        ):
            assert word not in path.name
            assert word.encode() not in content, path.name
            assert word.encode("utf-16-le") not in content
        assert path.stat().st_size in (16_432, 65_584, 65_613)  # a letter's sizes, an invitation's
        assert path.stat().st_mode & 0o777 == 0o600


def test_one_exchange_at_a_time(clinic: Clinic, home: Home) -> None:
    with alone(home.data), pytest.raises(Busy):
        exchange(home.data)

"""Records are kept with all their versions, and belong to a person, a day or a session."""

import random
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path
from sqlite3 import Connection

import pytest

from sar_tui.records.kind import NOT_SAID, find
from sar_tui.rules.wellbeing import SessionRatings, tell_therapist
from sar_tui.store import participants, records, sessions, wellbeing
from sar_tui.store.database import StoreError, connect
from sar_tui.store.integrity import flaws
from sar_tui.store.rescue import copy_session
from sar_tui.store.training_days import utc
from tests.recorded import event, score, told
from tests.store.by_hand import sql


@pytest.fixture(autouse=True)
def a_participant(database: Connection) -> None:
    participants.add(database, "P01")


def new_session(database: Connection, name: str, code: str = "P01", partner: str = "") -> None:
    participants.add(database, code)
    sessions.create(
        database, name, task="keyboard", participant=code, partner=partner, mode="live",
        theme="calm", seed=1, parameters={}, software={}, machine={},
    )  # fmt: skip


def test_a_correction_adds_a_version_and_keeps_others(database: Connection) -> None:
    given = {"what": " Cramp ", "severity": "Mild", "author": "ana"}
    first = event(database, "p01", "2026-03-01T14:30", **given)
    assert (first.at, first.content) == ("2026-03-01 14:30", {"what": "Cramp", "severity": "mild"})
    second = records.correct(database, first.id, {"outcome": "Gone"}, author="ben")
    assert second.content == {**first.content, "outcome": "Gone"}
    assert records.listing(database) == [second]
    versions = records.versions(database, first.id)
    assert [(one.version, one.recorded_by) for one in versions] == [(1, "ana"), (2, "ben")]


def test_a_new_record_never_gets_the_id_of_another(
    database: Connection, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn = iter(["aaaaaa", "aaaaaa", "bbbbbb"])
    monkeypatch.setattr("secrets.token_hex", lambda _: next(drawn))
    for id in ("aaaaaa", "bbbbbb"):
        assert event(database, "P01", "2026-03-01", what="Fell", severity="mild").id == id


def test_without_a_date_a_record_is_of_now_as_its_kind_writes_it(
    database: Connection,
) -> None:
    fall = event(database, "P01", "", what="Fell", severity="mild")
    assert records.check_date(find("adverse-event"), fall.at) == fall.at
    assert score(database, "P01", "ARAT", "", 30).at == fall.day
    assert told(database, "P01", "before", "pain", "2").at.endswith("+00:00")


def test_the_last_score_of_a_day_counts_and_one_entered_by_mistake_can_be_entered_anew(
    database: Connection,
) -> None:
    for value in (30, 31):
        last = score(database, "P01", "arat", "2026-03-01", value)
    score(database, "P01", "arat", "2026-04-01", 32)
    known = records.listing(database, kinds=("ARAT",), participant="P01")
    assert [one.content["score"] for one in known] == [31, 32]
    assert len(records.versions(database, last.id)) == 2
    assert records.listing(database, participant="P02") == []
    records.correct(database, last.id, {}, removed=True, author="ben")
    assert [one.content["score"] for one in records.listing(database)] == [32]
    assert [one.removed for one in records.listing(database, with_removed=True)] == [True, False]
    score(database, "P01", "ARAT", "2026-03-01", 33)
    assert [one.content["score"] for one in records.listing(database)] == [33, 32]


def test_what_cannot_be_corrected_is_refused(database: Connection) -> None:
    entered = event(database, "P01", "2026-03-01", what="Fell", severity="mild")
    new_session(database, "abc")
    database.execute(records.PAUSES, ("abc-7", "abc", "A", "pain", utc()))
    for id, given, says in (
        ("ffffff", {"what": "x"}, "There is no record ffffff."),
        (f"{entered.id}@BERN", {"what": "x"}, "There is no record"),
        (entered.id, {}, "Nothing would change."),
        (entered.id, {"severity": "awful"}, "Severity is mild, moderate or severe"),
        ("abc-7", {"rating": 3}, "is part of the log of its session"),
    ):
        with pytest.raises(StoreError, match=says) as refused:
            records.correct(database, id, given)
        assert refused.value.bad_input


@pytest.mark.parametrize(
    ("kind", "at", "says"),
    [
        ("ARAT", "1 March", "Day it was measured is a date, such as 2026-03-01, not '1 March'."),
        ("ARAT", "2026-03-01T10:00", "Day it was measured is a date"),
        ("adverse-event", "2026-02-30", "Onset is a date, such as 2026-03-01, or 2026-03-01T14:30"),
        ("adverse-event", "9999-01-01", "Onset 9999-01-01 is in the future."),
    ],
)
def test_an_impossible_date_is_refused(database: Connection, kind: str, at: str, says: str) -> None:
    with pytest.raises(StoreError, match=says):
        records.add(database, find(kind), "P01", at, {"score": 1} if kind == "ARAT" else {})
    assert records.listing(database) == []


def test_an_event_with_a_time_belongs_to_the_session_under_way(database: Connection) -> None:
    new_session(database, "abc")
    times = (datetime.fromisoformat(f"2026-03-01 {at}") for at in ("10:00:30", "10:20:30"))
    stamps = [time.astimezone().astimezone(UTC).isoformat() for time in times]
    sql(database, "UPDATE sessions SET started_at=?, ended_at=?", *stamps)
    for time, session in (
        (" 10:00", "abc"),
        (" 10:20", "abc"),
        (" 10:21", None),
        (" 09:59", None),
        ("", None),
    ):
        onset = f"2026-03-01{time}"
        entered = event(database, "P01", onset, what="Fell", severity="mild")
        assert entered.session == session, onset
        assert records.session_at(database, "P02", onset) is None


def test_answers_before_a_session_belong_to_it_once_it_begins(database: Connection) -> None:
    told(database, "P01", "before", "pain", "8")
    since = utc()
    told(database, "P01", "before", "pain", "2")
    told(database, "P02", "before", "pain", "1")
    new_session(database, "abc")
    records.attach(database, "abc", ["P01"], since)
    known = wellbeing.of_participant(database, "P01")
    assert [(one.session, one.content["rating"]) for one in known] == [(None, 8), ("abc", 2)]
    assert [one.session for one in wellbeing.of_participant(database, "P02")] == [None]
    assert list(flaws(database)) == []
    assert participants.codes(database) == ["P01", "P02"]


def test_a_copied_session_keeps_answers_of_the_target(database: Connection, tmp_path: Path) -> None:
    with closing(connect(tmp_path / "other")) as other:
        for each in (database, other):
            new_session(each, "abc")
        told(other, "P01", "before", "pain", "2", session="abc")
        told(database, "P01", "after", "pain", "3", session="abc")
        for _ in range(2):
            copy_session(other, database, "abc")
    known = wellbeing.of_session(database, "abc")
    assert sorted(one.content["rating"] for one in known) == [2, 3]


def test_ratings_are_the_last_answers_of_each_seat(database: Connection) -> None:
    assert wellbeing.of_session(database, "abc") == []
    new_session(database, "abc", partner="P02")
    assert wellbeing.history(database, "P01") == [SessionRatings()]
    for answer in ("4", "5"):
        told(database, "P01", "before", "pain", answer, session="abc")
    told(database, "P01", "after", "pain", NOT_SAID, session="abc")
    told(database, "P02", "after", "tiredness", "10", session="abc", seat="B")
    known = wellbeing.by_session(database, ["abc", "def"])["abc"]
    assert wellbeing.ratings(known) == SessionRatings(pain_before=5)
    assert wellbeing.ratings(known, "B") == SessionRatings(fatigue_after=10)
    assert wellbeing.history(database, "P02") == [SessionRatings(fatigue_after=10)]


def rated(database: Connection, participant: str, answers: list[tuple[str, str]]) -> None:
    """Store a session for each pain before and tiredness after it; an empty answer was not
    asked.
    """
    for number, (pain, tired) in enumerate(answers):
        new_session(database, session := f"{participant}-{number:02}", participant)
        if pain:
            told(database, participant, "before", "pain", pain, session=session)
        if tired:
            told(database, participant, "after", "tiredness", tired, session=session)


def test_the_newest_ratings_tell_what_all_of_them_do(database: Connection) -> None:
    rng = random.Random(7)
    reasons: set[str] = set()
    for number in range(20):
        pains, tired = ["", "", "0", "1", "2", "7"], ["", "", "6", "8"]
        answers = [(rng.choice(pains), rng.choice(tired)) for _ in range(24)]
        rated(database, code := f"P{number}", answers)
        told_by_all = tell_therapist(wellbeing.history(database, code))
        assert tell_therapist(wellbeing.newest_ratings(database, code)) == told_by_all, answers
        reasons |= set(told_by_all)
    assert {"stop", "tired"} <= reasons

"""Answers about pain and tiredness are stored at once, and belong to their session."""

import random
import sqlite3
from contextlib import closing
from datetime import date
from pathlib import Path

from sar_tui.app.home.contents import read_card
from sar_tui.loop.task import Task
from sar_tui.plugins import Catalogue
from sar_tui.reports.progress import progress
from sar_tui.reports.progress_words import warnings, words
from sar_tui.rules.wellbeing import SessionRatings, tell_therapist
from sar_tui.store import participants, sessions, wellbeing
from sar_tui.store.database import connect
from sar_tui.store.integrity import flaws
from sar_tui.store.session_copy import copy_session

FACTS = {"theme": "calm", "seed": 1, "parameters": {}, "software": {}, "machine": {}}


def new_session(
    database: sqlite3.Connection, name: str, participant: str = "P01", partner: str = ""
) -> None:
    participants.add(database, participant)
    sessions.create(
        database,
        name,
        task="keyboard",
        participant=participant,
        partner=partner,
        mode="live",
        **FACTS,
    )  # type: ignore[arg-type]


def test_answers_before_a_session_belong_to_it_once_it_begins(database: sqlite3.Connection) -> None:
    wellbeing.save(database, "P01", "before", "pain", "8")
    since = wellbeing.save(database, "P01", "before", "pain", "2")
    wellbeing.save(database, "P01", "before", "place", "left shoulder")
    wellbeing.save(database, "P02", "before", "pain", "1")
    new_session(database, "abc")
    wellbeing.attach(database, "abc", ["P01"], since)
    known = [(row["session"], row["answer"]) for row in wellbeing.of_participant(database, "P01")]
    assert known == [(None, "8"), ("abc", "2"), ("abc", "left shoulder")]
    assert [row["session"] for row in wellbeing.of_participant(database, "P02")] == [None]


def test_ratings_are_the_last_answers_of_each_seat(database: sqlite3.Connection) -> None:
    new_session(database, "abc", partner="P02")
    for answer in ("4", "5"):
        wellbeing.save(database, "P01", "before", "pain", answer, session="abc")
    wellbeing.save(database, "P01", "after", "pain", wellbeing.NOT_SAID, session="abc")
    wellbeing.save(database, "P02", "after", "fatigue", "10", session="abc", seat="B")
    rows = wellbeing.by_session(database, ["abc", "def"])["abc"]
    assert wellbeing.ratings(rows) == SessionRatings(pain_before=5)
    assert wellbeing.ratings(rows, "B") == SessionRatings(fatigue_after=10)
    assert wellbeing.history(database, "P02") == [SessionRatings(fatigue_after=10)]


def test_sessions_without_an_answer_are_known_without_ratings(database: sqlite3.Connection) -> None:
    new_session(database, "abc")
    assert wellbeing.of_session(database, "abc") == []
    assert wellbeing.history(database, "P01") == [SessionRatings()]


def rated(database: sqlite3.Connection, participant: str, answers: list[tuple[str, str]]) -> None:
    """Store a session for each pain before and tiredness after it; an empty answer was not
    asked.
    """
    for number, (pain, tired) in enumerate(answers):
        new_session(database, session := f"{participant}-{number:02}", participant)
        if pain:
            wellbeing.save(database, participant, "before", "pain", pain, session=session)
        if tired:
            wellbeing.save(database, participant, "after", "fatigue", tired, session=session)


def test_the_newest_ratings_tell_the_therapist_what_all_of_them_do(
    database: sqlite3.Connection,
) -> None:
    rng = random.Random(7)
    told = []
    for number in range(20):
        answers = [
            (rng.choice(["", "", "0", "1", "2", "7"]), rng.choice(["", "", "6", "8"]))
            for _ in range(24)
        ]
        rated(database, f"P{number}", answers)
        told.append(tell_therapist(wellbeing.history(database, f"P{number}")))
        assert tell_therapist(wellbeing.newest_ratings(database, f"P{number}")) == told[-1], answers
    assert {"stop", "tired"} <= {reason for each in told for reason in each}


def test_pain_over_sessions_far_apart_is_told_in_the_same_words_everywhere(
    database: sqlite3.Connection, tmp_path: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    rated(database, "P01", [("0", "2"), *[("2", "")] * 3, *[("", "")] * 12, ("3", "")])
    card = read_card(database, tmp_path, catalogue, "P01", keyboard, date(2026, 3, 1))
    found = progress("P01", [], {}.get, ratings=wellbeing.history(database, "P01"))
    assert card.told == warnings(found, words("en", None)) == [
        "Pain is new: some in each of the last four sessions, and none before. Tell the therapist."
    ]  # fmt: skip


def test_a_copied_session_keeps_the_answers_that_the_target_has(
    database: sqlite3.Connection, tmp_path: Path
) -> None:
    with closing(connect(tmp_path / "other")) as other:
        for each in (database, other):
            new_session(each, "abc")
        wellbeing.save(other, "P01", "before", "pain", "2", session="abc")
        wellbeing.save(database, "P01", "after", "pain", "3", session="abc")
        for _ in range(2):
            copy_session(other, database, "abc")
    assert [row["answer"] for row in wellbeing.of_session(database, "abc")] == ["2", "3"]


def test_what_a_new_participant_says_before_a_session_that_does_not_begin_is_whole(
    database: sqlite3.Connection,
) -> None:
    wellbeing.save(database, "P09", "before", "pain", "9")
    assert list(flaws(database)) == []
    assert participants.codes(database) == ["P09"]

"""The day in words: the sentence above the list, its sections, and what is said of each person."""

from datetime import UTC, date, datetime, timedelta
from typing import Any

import pytest

from sar_tui.app.home.day import Day, Entry, day_of
from sar_tui.model.language import Language
from sar_tui.rules.attention import (
    STUCK_SESSIONS,
    AtHome,
    Course,
    Event,
    PastSession,
    Rated,
)
from sar_tui.rules.wellbeing import SessionRatings
from sar_tui.store.courses import DayTotal, Person

TODAY = date(2026, 11, 25)


def person(code: str, trained: int | None = 1, **course: Any) -> Person:
    """Return a person who trained so many days ago; None: never."""
    sessions = [] if trained is None else [PastSession(ago(trained), "keyboard")]
    total = DayTotal(datetime(2026, 11, 25, 9, 40, tzinfo=UTC), 10, 21, 8, 10)
    return Person(code, Course(**{"sessions": sessions} | course), total if trained == 0 else None)


def ago(days: int) -> date:
    return TODAY - timedelta(days=days)


def in_pain(days: int, pain: int) -> list[Rated]:
    return [Rated(ago(days), SessionRatings(pain_after=pain))]


def day(*people: Person, last: str | None = None) -> Day:
    return day_of(people, last, TODAY, Language())


def only(one: Person) -> Entry:
    (entry,) = day(one).entries
    return entry


def test_who_needs_a_look_comes_first_then_who_is_due_and_who_has_trained() -> None:
    found = day(
        person("NEW", None),
        person("TODAY", 0),
        person("RECENT", 3),
        person("DUE", 4, due=ago(1)),
        person("AWAY", 8),
        person("EVENT", 2, events=[Event(ago(2), "mild", has_outcome=True)]),
        person("PAIN", 3, rated=in_pain(3, 6)),
        person("MORE", 3, rated=in_pain(3, 8)),
        person("NOW", 4, due=TODAY),
        person("GONE", 40),
    )
    assert [(each.part, each.code) for each in found.entries] == [
        ("look", "MORE"), ("look", "PAIN"), ("look", "EVENT"), ("due", "NOW"), ("due", "DUE"),
        ("today", "TODAY"), ("new", "NEW"), ("away", "AWAY"), ("others", "RECENT"),
        ("others", "GONE"),
    ]  # fmt: skip
    assert found.sentence == (
        "3 people need a look. 2 more visits are due. 1 person has trained today."
    )


def test_who_trained_last_has_a_section_below_those_who_need_a_look() -> None:
    people = (person("P03", 2), person("P02", 1, rated=in_pain(1, 9)), person("P01", 1))
    found = [(each.part, each.code) for each in day(*people, last="P01").entries]
    assert found == [("look", "P02"), ("last", "P01"), ("others", "P03")]
    hurt = person("P01", 1, rated=in_pain(1, 6))
    found = [(each.part, each.code) for each in day(*people[:2], hurt, last="P01").entries]
    assert found == [("look", "P02"), ("look", "P01"), ("others", "P03")]


def test_the_sentence_counts_the_visits_of_the_section_due() -> None:
    hurt = person("P01", 1, rated=in_pain(1, 6), due=TODAY)
    found = day(hurt, person("P02", 9, due=TODAY), last="P02")
    assert [(each.part, each.code) for each in found.entries] == [("look", "P01"), ("due", "P02")]
    assert found.sentence == "1 person needs a look. 1 more visit is due."
    assert found.entries[0].look[-1] == "Due today."


@pytest.mark.parametrize(
    ("people", "sentence"),
    [
        ((), "Welcome"),
        ((person("P01", None),), "Nobody has trained here yet."),
        ((person("P01", None, rated=in_pain(0, 7)),), "1 person needs a look."),
        ((person("P01", 1),), "Nobody needs a look today."),
        ((person("P01", 9, due=TODAY),), "Nobody needs a look today. 1 visit is due."),
        (
            (person("P01", 0), person("P02", 0)),
            "Nobody needs a look today. 2 people have trained today.",
        ),
    ],
)
def test_the_day_is_a_sentence(people: tuple[Person, ...], sentence: str) -> None:
    assert day(*people).sentence == sentence


def test_a_reason_is_said_in_few_words_and_in_a_sentence_with_its_day() -> None:
    assert STUCK_SESSIONS == 3, "as the sentence says"
    stuck = [PastSession(ago(days), "keyboard", levels=(6,)) for days in (0, 2, 4)]
    found = only(
        person(
            "P01",
            sessions=stuck,
            rated=in_pain(4, 6),
            events=[Event(ago(1), "mild", has_outcome=False)],
        )
    )
    assert found.why == "Pain 6 · open adverse event · no change for 3 sessions"
    assert found.look == [
        "Pain 6 Sat 21 Nov, limit 5.",
        "Adverse event yesterday, mild: no outcome yet.",
        "No change for 3 sessions: level 6.",
    ]
    assert "PAIN" in found.words.upper()


def test_several_events_are_one_sentence_and_a_severity_may_be_missing() -> None:
    events = [Event(ago(days), "mild", days < 3) for days in (1, 2, 5, 6)]
    found = only(person("P01", None, events=events))
    assert found.look == [
        "2 adverse events without an outcome.",
        "2 adverse events this week.",
    ]
    assert found.why == "2 open adverse events · 2 adverse events"
    unknown = person("P01", None, events=[Event(ago(1), "", has_outcome=True)])
    assert only(unknown).look == ["Adverse event yesterday, severity not recorded."]
    assert day(person("P01", None, events=events)).sentence == "1 person needs a look."


@pytest.mark.parametrize(
    ("one", "why", "trained"),
    [
        (person("P01", None), "", "No session yet"),
        (person("P01", 0), "", "Today 09:40, 8 of 10 goals"),
        (person("P01", 1), "", "Trained yesterday"),
        (person("P01", 9), "", "Trained 9 days ago"),
        (person("P01", 40), "", "Trained last on Fri 16 Oct"),
        (person("P01", 3, due=TODAY), "Due today", "Trained 3 days ago"),
        (person("P01", 3, due=ago(1)), "Due since yesterday", "Trained 3 days ago"),
        (
            person("P01", 0, rated=in_pain(0, 2)),
            "Pain 2/10 this week",
            "Today 09:40, 8 of 10 goals",
        ),
        (person("P01", 0, rated=in_pain(0, 6)), "Pain 6", "Today 09:40, 8 of 10 goals"),
        (person("P01", 3, rated=in_pain(3, 6)), "Pain 6", "Trained 3 days ago"),
    ],
)
def test_it_is_said_why_a_person_is_there_and_when_they_trained(
    one: Person, why: str, trained: str
) -> None:
    assert (only(one).why, only(one).trained) == (why, trained)


def test_an_interrupted_session_is_left_to_the_card() -> None:
    found = only(person("P01", sessions=[PastSession(TODAY, "keyboard", "interrupted")]))
    assert (found.why, found.look) == ("Interrupted", [])


def test_letters_from_home_that_are_missing_or_refused_or_late_need_a_look() -> None:
    late = only(person("P01", at_home=AtHome(heard=ago(7))))
    assert (late.part, late.why) == ("look", "Not heard for 7 days")
    assert list(late.look) == ["Nothing was heard from home for 7 days."]
    many = AtHome(heard=TODAY, missing=2, refused=ago(1))
    worse = only(person("P01", at_home=many))
    assert worse.why == "A letter was refused · 2 letters missing"
    assert worse.look[0].startswith("A letter from home was refused yesterday: ")
    for fine in (AtHome(), AtHome(heard=ago(6), refused=ago(8))):
        assert only(person("P01", at_home=fine)).part != "look"


def test_the_state_of_a_home_is_said_unless_it_is_the_reason() -> None:
    said = {"P01": "At home: heard yesterday"}
    found = day_of([person("P01", at_home=AtHome(heard=ago(1)))], None, TODAY, Language(), said)
    assert found.entries[0].why == "At home: heard yesterday"
    found = day_of([person("P01", at_home=AtHome(missing=1))], None, TODAY, Language(), said)
    assert found.entries[0].why == "1 letter missing"

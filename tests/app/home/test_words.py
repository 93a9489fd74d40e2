"""The texts of a participant's card."""

from datetime import date, timedelta

import pytest

from sar_tui.app.home.words import (
    Past,
    Programme,
    bars,
    day_words,
    last_words,
    level_played,
    offer_words,
    programme_words,
    progress_words,
    short,
    span_words,
    waits_words,
)
from sar_tui.framework.results_for_people import short_goal
from sar_tui.framework.trial_types import Metric

TODAY = date(2026, 11, 22)
TIME = Metric("reaction_time", "ms", "lower")
TAPS = Metric("taps", "taps", "higher")


def past(days_ago: int, level: int | None, **more: object) -> Past:
    played = {"result": "0.95 s", "reached": 12, "attempts": 20} | more
    return Past(TODAY - timedelta(days=days_ago), level, **played)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("day", "said"),
    [
        (date(2026, 11, 22), "today"),
        (date(2026, 11, 21), "yesterday"),
        (date(2026, 11, 17), "Tue 17 Nov"),
        (date(2025, 11, 3), "3 Nov 2025"),
    ],
)
def test_a_date_is_said_as_people_say_it(day: date, said: str) -> None:
    assert day_words(day, TODAY) == said


def test_a_length_of_time_has_one_unit() -> None:
    assert [span_words(days) for days in (1, 9, 14, 45, 90)] == ["1 day", "9 days", "2 weeks", "6 weeks", "3 months"]


@pytest.mark.parametrize(("levels", "level"), [([1], 1), ([1, 2, 3, 4], 3), ([1, 2, 3, 4, 5, 4, 5, 4], 4), ([4, 5], 5)])
def test_a_session_was_played_at_the_middle_level_of_its_second_half(levels: list[int], level: int) -> None:
    assert level_played(levels) == level


def test_people_read_seconds_and_other_units_as_they_are() -> None:
    assert (short(TIME, 953.4), short_goal(TIME, 1000), short_goal(TIME, 850)) == ("0.95 s", "1.0 s", "0.85 s")
    assert (short(TAPS, 12), short_goal(TAPS, 12)) == ("12 taps", "12 taps")


def test_a_programme_is_said_in_a_line_that_fits() -> None:
    programme = Programme(version=3, attempts=10, prompts=20, goal="1.0 s", level=4)
    assert programme_words(programme, is_roomy=False) == "v3: 10 × 20 · goal 1.0 s · start level 4"
    assert programme_words(programme, is_roomy=True) == "version 3: 10 attempts of 20 · goal 1.0 s · start level 4"
    never_saved = Programme(version=0, attempts=1, prompts=1, goal="", level=1)
    assert programme_words(never_saved, is_roomy=True) == "none saved: 1 attempt of 1 · start level 1"


@pytest.mark.parametrize(
    ("levels", "said"),
    [
        ([], ""),
        ([2], "Played at level 2"),
        ([1, 2, 2, 4], "Played at level 4, up 3 in 2 weeks; up to 7 by chance"),
        ([1, 3, 3, 3, 4], "Played at level 4, up 3 in 2 weeks; up to 1 by chance"),
        ([4, 2], "Played at level 2, down 2 in 2 weeks; chance not known yet"),
        ([3, 4, 3], "Played at level 3, as before in 2 weeks"),
    ],
)
def test_progress_is_the_change_of_the_level(levels: list[int], said: str) -> None:
    ago = [14] * (len(levels) - 1) + [0] if len(levels) > 1 else [0]
    assert progress_words([past(days, level) for days, level in zip(ago, levels, strict=False)], 0) == said


def test_sessions_with_other_settings_are_named_and_not_compared() -> None:
    said = progress_words([past(3, 2), past(3, None), past(0, 4)], others=5)
    assert said == "Played at level 4, up 2 in 3 days; chance not known yet (5 earlier with other settings)"


def test_the_last_session_is_a_sentence() -> None:
    assert last_words(past(5, 4, felt="tired 3"), TODAY) == "Tue 17 Nov: 12 of 20 reached, tired 3"
    assert last_words(past(1, None, attempts=0, status="aborted"), TODAY) == (
        "Yesterday: no attempt was finished, ended early"
    )


def test_an_interrupted_session_is_offered_with_its_keys() -> None:
    assert offer_words(TODAY, 3, 20, TODAY) == (
        "Interrupted today after 3 of 20. F6 and Enter go on with it, Del dismisses it."
    )


def test_pain_marks_a_participant_before_all_else() -> None:
    assert waits_words(is_interrupted=True, pain="pain 6") == "pain 6"
    assert waits_words(is_interrupted=True, pain="", is_due=True) == "unfinished"
    assert waits_words(is_interrupted=False, pain="", is_due=True) == "due"
    assert waits_words(is_interrupted=False, pain="") == ""


def test_a_bar_is_as_high_as_its_level() -> None:
    assert bars([1, 2, 8], 3, 10) == "▁▂█"
    assert bars([1, 8, 16], 16, 10) == "▁▄█"
    assert bars([1, 2, 3], 3, 2) == "▂▃", "the newest remain"

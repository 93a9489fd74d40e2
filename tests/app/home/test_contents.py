"""The contents of the home screen: a participant's card, the list of sessions, and their words."""

from collections.abc import Sequence
from contextlib import closing
from datetime import UTC, date, datetime
from pathlib import Path

import pytest

from sar_tui.app.home import contents
from sar_tui.app.home.session_list import Line, Table
from sar_tui.app.home.words import (
    Programme,
    bars,
    day_words,
    last_words,
    programme_words,
    progress_words,
    short,
)
from sar_tui.loop.task import Task
from sar_tui.model.language import Language
from sar_tui.model.results_for_people import short_goal
from sar_tui.model.trial_types import Metric
from sar_tui.plugins import Catalogue
from sar_tui.progress.lines import SessionResults
from sar_tui.progress.task_level import AttemptResult
from sar_tui.reports import progress_words as report_words
from sar_tui.reports.progress import progress
from sar_tui.store.database import connect
from tests.progress.session_results import adapted, at_one_level, session


@pytest.mark.parametrize("last", [300.0, 450.0, 600.0])
def test_the_card_and_the_progress_screen_give_one_verdict_after_many_sessions(
    tmp_path: Path,
    catalogue: Catalogue,
    keyboard: type[Task],
    monkeypatch: pytest.MonkeyPatch,
    last: float,
) -> None:
    played = [
        session(number, adapted(number, base=450.0 + (last - 450.0) * number / 24))
        for number in range(25)
    ]
    other = session(30, adapted(3), {"threshold": 900.0}, on_day=0)
    simulated = session(31, adapted(3), mode="simulated", on_day=0)
    monkeypatch.setattr(
        contents.results, "sessions_of", lambda *_, **__: iter([other, *played, simulated])
    )
    with closing(connect(tmp_path)) as database:
        card = contents.read_card(
            database, tmp_path, catalogue, "P01", keyboard, date(2026, 4, 1), ENGLISH
        )
    (line,) = progress("P01", played, {"keyboard": keyboard}.get).lines
    assert line.verdict == {300.0: "more", 450.0: "noise", 600.0: "less"}[last]
    assert card.progress == progress_words(line, 1, ENGLISH)
    assert len(card.chart.bars) == 25


TODAY = date(2026, 11, 22)
ENGLISH = Language()


def line(
    task: str = "Keyboard reaction",
    note: str = "",
    levels: tuple[int, ...] = (1, 2, 3),
    **felt: str,
) -> Line:
    day = date(2026, 11, 17)
    return Line(day, "14:05", "P01", task, levels, "0.95 s", "2 of 3", 14, note, **felt)


def test_a_session_is_a_line_of_results() -> None:
    table = Table([line()], 72, TODAY, ENGLISH, names_who=False)
    assert table.heading == "Date         Level  Result  Reached   Levels"
    found = table.draw(line(note="with P02")).plain
    assert found == "Tue 17 Nov   1→3    0.95 s  2 of 3    ▁▂▃      with P02"


def test_pain_and_tiredness_have_columns_if_they_were_asked() -> None:
    asked = line(pain="0", tired="3")
    table = Table([asked, line()], 72, TODAY, ENGLISH, names_who=False)
    assert table.heading == "Date         Level  Result  Reached   Pain  Tired  Levels"
    assert table.draw(asked).plain == "Tue 17 Nov   1→3    0.95 s  2 of 3       0      3  ▁▂▃"
    assert table.draw(line()).plain == "Tue 17 Nov   1→3    0.95 s  2 of 3                 ▁▂▃"
    noted = line(pain="6", tired="3", note="interrupted: Enter resumes")
    drawn = Table([noted], 72, TODAY, ENGLISH, names_who=False).draw(noted).plain
    assert drawn.split()[-5:] == ["6", "3", "interrupted:", "Enter", "resumes"]


def test_tasks_are_named_if_they_differ_and_people_if_there_are_several() -> None:
    assert "Task" in Table([line(), line("Pairs")], 72, TODAY, ENGLISH, names_who=False).heading
    found = Table([line()], 72, TODAY, ENGLISH, names_who=True).heading.split()
    assert found == ["Date", "Who", "Task", "Reached", "Levels"]


def test_a_note_that_needs_room_takes_that_of_the_levels() -> None:
    noted = line(note="interrupted: Enter resumes")
    table = Table([noted, line("Pairs")], 72, TODAY, ENGLISH, names_who=True)
    drawn = table.draw(noted).plain
    assert drawn == "Tue 17 Nov  P01      Keyboard re… 2 of 3   interrupted: Enter resumes"


def test_more_room_shows_more() -> None:
    table = Table([line()], 130, TODAY, ENGLISH, names_who=False)
    found = table.heading.split()
    assert found == ["Date", "Time", "Level", "Result", "Reached", "Levels", "Minutes"]
    assert "14 min" in table.draw(line()).plain


@pytest.mark.parametrize("width", [20, 72, 90, 152])
@pytest.mark.parametrize("names_who", [True, False])
def test_no_line_is_longer_than_its_room(width: int, names_who: bool) -> None:
    lines = [
        line(
            note="with P02, interrupted: Enter resumes",
            levels=tuple(range(1, 60)),
            pain="6",
            tired="7",
        ),
        line("Pairs"),
    ]
    table = Table(lines, width, TODAY, ENGLISH, names_who=names_who)
    assert all(len(table.draw(each).plain) <= width for each in lines)


TIME = Metric("reaction_time", "ms", "lower")
TAPS = Metric("taps", "taps", "higher")


@pytest.mark.parametrize(
    ("day", "said"),
    [
        (date(2026, 11, 22), "today"), (date(2026, 11, 21), "yesterday"),
        (date(2026, 11, 17), "Tue 17 Nov"), (date(2025, 11, 3), "3 Nov 2025"),
    ],
)  # fmt: skip
def test_a_date_is_said_as_people_say_it(day: date, said: str) -> None:
    assert day_words(day, TODAY, ENGLISH) == said


def test_people_read_seconds_and_other_units_as_they_are() -> None:
    found = (short(TIME, 953.4, ENGLISH), short_goal(TIME, 1000), short_goal(TIME, 850))
    assert found == ("0.95 s", "1.0 s", "0.85 s")
    assert (short(TAPS, 12, ENGLISH), short_goal(TAPS, 12)) == ("12 taps", "12 taps")


def test_a_programme_is_said_in_a_line_that_fits() -> None:
    programme = Programme(attempts=10, prompts=20, goal="1.0 s", level=4, why="from the last times")
    said = "10 attempts, 20 prompts each · goal 1.0 s · start level 4"
    assert programme_words(programme, ENGLISH, is_roomy=False) == said
    found = programme_words(programme, ENGLISH, is_roomy=True)
    assert found == f"{said} (from the last times)"
    least = Programme(attempts=1, prompts=1, goal="", level=1)
    assert programme_words(least, ENGLISH, is_roomy=True) == "1 attempt, 1 prompt · start level 1"


@pytest.mark.parametrize("base", [50.0, 450.0, 750.0])
def test_the_card_and_the_note_give_one_verdict(keyboard: type[Task], base: float) -> None:
    played = [
        *(session(number, adapted(number)) for number in range(5)),
        session(9, adapted(9, base=base)),
    ]
    (line,) = progress("P01", played, {"keyboard": keyboard}.get).lines
    note = report_words.note("P01", line, Language())
    card, sentence = {
        50.0: (
            "real improvement",
            "is better than that: a change that noise and practice do",
        ),
        450.0: ("no change can be shown", "no change can be shown"),
        750.0: ("real decline", "is worse than that: a change that noise does not"),
    }[base]
    assert sentence in note
    assert line.sessions[-1].at_goal is not None
    assert (
        progress_words(line, 0, ENGLISH) == f"Level {line.sessions[-1].at_goal.level:.1f}: {card}"
    )
    assert progress_words(line, 5, ENGLISH).endswith(f"{card} (5 with other settings)")


def test_the_card_says_which_session_the_verdict_is_on(keyboard: type[Task]) -> None:
    played = [session(number, adapted(number)) for number in range(5)]
    easy = [session(9, at_one_level(9, 400.0))]

    def said(sessions: Sequence[SessionResults]) -> str:
        return progress_words(
            progress("P01", sessions, {"keyboard": keyboard}.get).lines[-1], 0, ENGLISH
        )

    assert said(played[:3]).endswith(": change not yet known")
    assert said([*played, *easy]) == (
        "Last session all too easy. 2026-03-03: Level 3.2, no change can be shown"
    )
    found = said([session(1, [AttemptResult(level, 400.0, 20) for level in (1, 2, 3)])])
    assert found == "Last session all too easy"
    assert said(easy) == "Mean 0.41 s at level 3: change not yet known"


def test_the_last_session_is_a_sentence() -> None:
    last = session(
        0, at_one_level(0, 900.0), began=datetime(2026, 11, 17, 10, tzinfo=UTC), reached=7
    )
    assert last_words(last, "tired 3", TODAY, ENGLISH) == "Tue 17 Nov: 7 of 12 reached, tired 3"
    nothing = session(0, [], began=datetime(2026, 11, 21, 10, tzinfo=UTC), status="aborted")
    assert (
        last_words(nothing, "", TODAY, ENGLISH) == "Yesterday: no attempt was finished, ended early"
    )


def test_a_bar_is_as_high_as_its_level() -> None:
    assert bars([1, 2, 8], 3, 10) == "▁▂█"
    assert bars([1, 8, 16], 16, 10) == "▁▄█"
    assert bars([1, 2, 3], 3, 2) == "▂▃", "the newest remain"

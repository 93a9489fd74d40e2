"""The table of sessions fits its lines into the room that there is."""

from datetime import date

import pytest

from sar_tui.app.home.session_list import Line, Table

TODAY = date(2026, 11, 22)


def line(
    task: str = "Keyboard reaction", note: str = "", levels: tuple[int, ...] = (1, 2, 3)
) -> Line:
    return Line(date(2026, 11, 17), "14:05", "P01", task, levels, "0.95 s", "2 of 3", 14, note)


def test_a_session_is_a_line_of_results() -> None:
    table = Table([line()], 72, TODAY, names_who=False)
    assert table.heading == "Date        Level Result Reached  Levels"
    assert (
        table.draw(line(note="tired 3")).plain
        == "Tue 17 Nov  1→3   0.95 s 2 of 3   ▁▂▃     tired 3"
    )


def test_tasks_are_named_if_they_differ_and_people_if_there_are_several() -> None:
    assert "Task" in Table([line(), line("Pairs")], 72, TODAY, names_who=False).heading
    assert Table([line()], 72, TODAY, names_who=True).heading.split() == [
        "Date",
        "Who",
        "Task",
        "Reached",
        "Levels",
    ]


def test_a_note_that_needs_room_takes_that_of_the_levels() -> None:
    table = Table([line(), line("Pairs")], 72, TODAY, names_who=True)
    drawn = table.draw(line(note="interrupted: Enter resumes")).plain
    assert drawn == "Tue 17 Nov  P01      Keyboard re… 2 of 3   interrupted: Enter resumes"


def test_more_room_shows_more() -> None:
    table = Table([line()], 130, TODAY, names_who=False)
    assert table.heading.split() == [
        "Date",
        "Time",
        "Level",
        "Result",
        "Reached",
        "Levels",
        "Minutes",
    ]
    assert "14 min" in table.draw(line()).plain


@pytest.mark.parametrize("width", [20, 72, 90, 152])
@pytest.mark.parametrize("names_who", [True, False])
def test_no_line_is_longer_than_its_room(width: int, names_who: bool) -> None:
    lines = [
        line(note="interrupted: Enter resumes, pain 6, tired 7", levels=tuple(range(1, 60))),
        line("Pairs"),
    ]
    table = Table(lines, width, TODAY, names_who=names_who)
    assert all(len(table.draw(each).plain) <= width for each in lines)

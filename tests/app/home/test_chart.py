"""The small chart of a participant's sessions."""

from datetime import date, timedelta

from sar_tui.app.home.chart import draw
from sar_tui.app.home.words import Past


def past(*levels: int | None) -> list[Past]:
    began = date(2026, 11, 3)
    return [
        Past(began + timedelta(days=2 * number), level, result="0.95 s", reached=1, attempts=1)
        for number, level in enumerate(levels)
    ]


def test_the_smallest_chart_has_bars_levels_and_results() -> None:
    assert draw(past(1, 2, 4), 39, 3) == [
        ("", "  ▂▂▂    ▄▄▄    ███", True),
        ("Level", "   1      2      4", False),
        ("Result (s)", " 0.95   0.95   0.95", False),
    ]


def test_more_room_adds_dates_and_higher_bars() -> None:
    drawn = draw(past(1, 2, 4), 39, 6)
    assert [text for _, text, is_bar in drawn if is_bar] == [
        "                ███",
        "         ▄▄▄    ███",
        "  ▆▆▆    ███    ███",
    ]
    assert drawn[-1] == ("", " 3 Nov  5 Nov  7 Nov", False)


def test_the_newest_sessions_are_drawn_as_far_as_there_is_room() -> None:
    drawn = {label: text for label, text, _ in draw(past(*range(1, 30)), 39, 3)}
    assert drawn["Level"].split() == ["26", "27", "28", "29"]


def test_sessions_without_an_attempt_are_left_out() -> None:
    assert draw(past(None), 39, 6) == []
    assert {label: text for label, text, _ in draw(past(2, None), 39, 6)}["Level"].split() == ["2"]

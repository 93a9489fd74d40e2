"""Text charts of sessions: of one, of more than there are columns, and of those without a value."""

from sar_tui.reports.charts import (
    ABOVE,
    BELOW,
    POINT,
    UNKNOWN,
    Columns,
    Value,
    limits,
    session_chart,
)

MONTHS = "Jan Feb Mar Apr May Jun Jul Aug Sep Oct Nov Dec".split()


def draw(values: list[Value], width: int = 40, rows: int = 7, **more: object) -> list[str]:
    columns = Columns(len(values), width)
    axis = limits(values)
    ticks = [(axis[0], "low"), (axis[1], "high")]
    return session_chart(values, columns, axis=axis, ticks=ticks, rows=rows, margin=6, **more)  # type: ignore[arg-type]


def test_a_better_session_is_higher_and_later_ones_are_further_right() -> None:
    lines = draw([Value(1.0), Value(2.0), Value(3.0)])
    places = [(line.index(POINT), row) for row, line in enumerate(lines) if POINT in line]
    assert places == [(31, 0), (21, 3), (11, 6)]
    assert lines[0].startswith(" high┤")
    for values in ([Value(0.0)], [Value(5.0), Value(5.0)]):
        assert sum(line.count(POINT) for line in draw(values)) == len(values)


def test_bands_are_drawn_and_a_very_wide_one_does_not_flatten_the_others() -> None:
    steady = [Value(value, value - 1, value + 1) for value in (1.0, 2.0, 3.0)]
    low, high = limits([*steady, Value(2.0, -50.0, 50.0)])
    assert -1 < low < high < 5


def test_sessions_without_a_value_have_a_sign_in_a_row_of_their_own() -> None:
    lines = draw(
        [Value(1.0), Value(2.0), Value(without=ABOVE), Value(without=BELOW), Value(without=UNKNOWN)]
    )
    assert len(lines) == 8
    assert lines[0].split() == ["│", ABOVE]
    assert lines[-2].split() == ["│", BELOW, UNKNOWN]


def test_a_thousand_sessions_share_columns_and_all_fit() -> None:
    columns = Columns(1000, 70)
    assert columns.most == 15
    assert [session for _, group in columns.groups() for session in group] == list(range(1000))
    assert max(map(len, draw([Value(float(number)) for number in range(1000)], 70))) <= 76
    assert len(columns.figures([number % 11 for number in range(1000)])) == 70


def test_figures_say_ten_and_show_where_nothing_is_known() -> None:
    assert Columns(3, 40).figures([0, None, 10]).split() == ["0", "·", "10"]
    assert Columns(4, 4).figures([0, None, 10, 3]) == "0·X3"


def test_dates_are_shortened_and_the_last_one_is_there() -> None:
    def dates(count: int, *days: str) -> str:
        return Columns(count, 60).dates(list(days), MONTHS)

    shown = dates(30, *(f"2026-03-{day:02}" for day in range(1, 31)))
    assert shown.strip().startswith("1 Mar")
    assert shown.endswith("30 Mar")
    assert dates(3, "2026-03-01", "2026-03-01", "2026-03-02").split() == ["1", "Mar", "2", "Mar"]
    assert dates(2, "2026-03-01", "2027-03-01").split() == ["2026-03", "2027-03"]


def test_each_row_has_the_label_next_to_its_middle() -> None:
    ticks = [(float(place), str(place)) for place in range(11)]
    values, columns, axis = [Value(0.0), Value(10.0)], Columns(2, 40), (0.0, 10.0)
    lines = session_chart(values, columns, axis=axis, ticks=ticks, rows=3, margin=6)
    assert [line.split("┤")[0].strip() for line in lines[:3]] == ["10", "5", "0"]

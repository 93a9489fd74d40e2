"""Text charts of sessions: of one, of more than there are columns, and of those without a value."""

from hypothesis import given
from hypothesis import strategies as st

from sar_tui.reports.charts import (
    ABOVE,
    BASELINE,
    BELOW,
    EDGE,
    HALVES,
    LIMIT,
    UNKNOWN,
    Columns,
    SessionChart,
    Value,
    limits,
    session_chart,
)

MONTHS = "Jan Feb Mar Apr May Jun Jul Aug Sep Oct Nov Dec".split()


def chart(values: list[Value], width: int = 40, rows: int = 7, **more: object) -> SessionChart:
    columns = Columns(len(values), width)
    axis = limits(values)
    ticks = [(axis[0], "low"), (axis[1], "high")]
    return session_chart(values, columns, axis=axis, ticks=ticks, rows=rows, margin=6, **more)  # type: ignore[arg-type]


def draw(values: list[Value], width: int = 40, rows: int = 7, **more: object) -> list[str]:
    return chart(values, width, rows, **more).rows


def points(lines: list[str]) -> list[tuple[int, int]]:
    """Return the column and the half row, counted from below, of each value in order."""
    rows = [line for line in reversed(lines) if "└" not in line]
    return sorted(
        (column, 2 * row + HALVES.index(character))
        for row, line in enumerate(rows)
        for column, character in enumerate(line)
        if character in HALVES
    )


def test_a_better_session_is_higher_and_later_ones_are_further_right() -> None:
    lines = draw([Value(1.0), Value(2.0), Value(3.0)])
    assert points(lines) == [(11, 0), (21, 6), (31, 13)]
    assert lines[0].startswith(" high┤")
    for values in ([Value(0.0)], [Value(5.0), Value(5.0)]):
        assert len(points(draw(values))) == len(values)


def test_bands_are_drawn_and_a_very_wide_one_does_not_flatten_the_others() -> None:
    steady = [Value(value, value - 1, value + 1) for value in (1.0, 2.0, 3.0)]
    low, high = limits([*steady, Value(2.0, -50.0, 50.0)])
    assert -1 < low < high < 5


@given(
    st.lists(st.floats(0, 20), min_size=1, max_size=12),
    st.floats(0, 20),
    st.floats(0, 20),
    st.integers(3, 20),
)
def test_no_value_is_on_the_other_side_of_a_limit(
    values: list[float], one: float, other: float, rows: int
) -> None:
    low, high = sorted((one, other))
    columns = Columns(len(values), 40)
    axis = limits([Value(value) for value in values], (low, high))
    drawn = session_chart(
        [Value(value) for value in values],
        columns, axis=axis, ticks=[], rows=rows, margin=6, area=(low, high),
    ).rows  # fmt: skip
    lines = [2 * row + 1 for row, line in enumerate(reversed(drawn[:-1])) if LIMIT in line]
    if len(lines) < 2:
        return  # both limits are in one row
    for value, (_, half) in zip(values, points(drawn), strict=True):
        if abs(value - low) > 1e-6 and abs(value - high) > 1e-6:
            assert (value > low) == (half >= lines[0])
            assert (value > high) == (half >= lines[1])


def halves(drawn: SessionChart, column: int, rows: int) -> list[str]:
    """Return what the half rows of a column of a shaded chart show, from below."""
    found: list[str] = []
    for row in reversed(range(rows)):
        runs = [run for run in drawn.runs[row] if run.first <= column < run.last]
        shown, behind = (runs[0].shown, runs[0].behind) if runs else ("", "")
        text = drawn.rows[row]
        half = HALVES.find(text[column]) if column < len(text) and text[column] != " " else -1
        lower_and_upper = [behind, behind]
        if half >= 0:
            lower_and_upper[half] = shown
        found += lower_and_upper
    return found


def test_a_band_is_one_stroke_of_its_length_through_its_point_whatever_is_behind() -> None:
    values = [Value(2.0, 1.0, 4.0), Value(6.0, 4.0, 8.0)]
    drawn = session_chart(
        values, Columns(2, 40), axis=(0.0, 9.0), ticks=[], rows=5, margin=6, area=(0.5, 5.5),
        baseline=2.0, is_shaded=True,
    )  # fmt: skip
    area = ["", *["area"] * 5, *[""] * 4]
    first = halves(drawn, 11, 5)
    assert first == ["", "band", "point", "band", "band", "area", "", "", "", ""]
    assert halves(drawn, 21, 5) == [*area[:4], *["band"] * 2, "point", "band", "band", "ground"]
    assert LIMIT in drawn.rows[3], "the baseline"
    assert LIMIT not in "".join(drawn.rows[row] for row in (0, 1, 2, 4))


def test_lines_have_their_names_where_there_is_room_and_else_a_legend() -> None:
    names = {LIMIT: "noise", BASELINE: "baseline 2"}
    given: dict[str, object] = {"area": (1.0, 4.0), "baseline": 2.0, "names": names}
    for is_shaded in (False, True):
        rising = chart([Value(2.0), Value(5.0), Value(9.0)], is_shaded=is_shaded, **given)
        assert rising.unnamed == []
        for name in names.values():
            assert sum(row.rstrip().endswith(f" {name}") for row in rising.rows) == 1
        full = [Value(2.0, 0.5, 6.0)] * 20
        assert chart(full, is_shaded=is_shaded, **given).unnamed == [BASELINE, LIMIT]


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
    lines = session_chart(values, columns, axis=axis, ticks=ticks, rows=3, margin=6).rows
    assert [line.split("┤")[0].strip() for line in lines[:3]] == ["9", "5", "1"]


@given(st.floats(1, 10), st.floats(1, 10), st.integers(5, 30), st.booleans())
def test_marks_and_lines_are_at_their_height(
    value: float, base: float, rows: int, is_shaded: bool
) -> None:
    lower, quarter = 0.5, 0.25
    axis = (1 - quarter, 1 - quarter + lower * (2 * rows - 1))
    drawn = session_chart(
        [Value(value)], Columns(1, 40), axis=axis, ticks=[(float(n), str(n)) for n in range(1, 31)],
        rows=rows, margin=6, baseline=base, is_shaded=is_shaded,
    )  # fmt: skip
    if max(value, base) > axis[1]:
        return
    by_row = {row: line.split("┤")[0].strip() for row, line in enumerate(reversed(drawn.rows[:-1]))}
    assert by_row[0] == "1"
    ((_, half),) = points(drawn.rows)
    assert abs(1 + (half - 0.5) / 2 - value) <= quarter + 1e-9
    if not is_shaded:
        return
    heights = {LIMIT: 0.0, EDGE: -lower}
    (line,) = (
        1 + row + heights[sign]
        for row, text in enumerate(reversed(drawn.rows[:-1]))
        for sign in (LIMIT, EDGE)
        if sign in text
    )
    assert abs(line - base) <= quarter + 1e-9

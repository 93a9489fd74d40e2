"""The chosen box of a scale is filled, and boxes grow with the room."""

import re

import pytest

from sar_tui.model.step import Entry, Step
from sar_tui.widgets.answer_options import options_text, with_chosen

PAIN = Step(name="pain", text="How much?", kind="number", labels=("none", "worst"))


def filled(columns: int, chosen: int) -> list[str]:
    """Return what stands in the filled part of each row."""
    content = with_chosen(options_text(PAIN, Entry(chosen=(chosen,)), columns))
    spans = [span for span in content.spans if "on $accent" in str(span.style)]
    return [content.plain[span.start : span.end] for span in spans]


def test_only_the_rows_of_the_chosen_box_are_filled() -> None:
    gap = "\N{NO-BREAK SPACE}" * 2
    assert filled(78, 7) == ["┏━━━━━┓", f"┃{gap}7{gap}┃", "┗━━━━━┛"]


@pytest.mark.parametrize("scale", [(-3, 3, 1), (-10, 0, 1), (0, 100, 10), (-50, 50, 10), (0, 1, 1)])
def test_all_numbers_of_a_scale_fit_into_their_boxes(scale: tuple[int, int, int]) -> None:
    step = Step(name="a", text="A", kind="number", scale=scale)
    for columns in range(30, 160):
        text = options_text(step, Entry(chosen=(0,)), columns)
        assert with_chosen(text).plain == text
        rows = text.split("\n")
        assert len({len(row) for row in rows}) == 1, text
        assert len(rows[0]) <= columns, text


@pytest.mark.parametrize("columns", [30, 44, 78])
def test_options_are_broken_where_a_row_is_too_short(columns: int) -> None:
    labels = ("yes", "no, as it was too far away for me to see what there was to be done")
    step = Step(name="a", text="A", kind="choice", labels=labels)
    first, *others = options_text(step, Entry(chosen=(1,)), columns).split("\n")
    assert len(first) <= columns
    words = " ".join(" ".join(others).split())
    assert words == f"▶ 2 {labels[1]}"


def test_a_digit_is_in_the_middle_of_its_box() -> None:
    for columns in range(55, 160):
        edge, digit, *_ = filled(columns, 7)
        left, right = re.split(r"[^\s┃]+", digit)
        assert len(edge) % 2 == 1
        if len(edge) < 13:  # letters of a font have a gap on the right
            assert len(left) == len(right)


def test_large_digits_are_filled_whole_in_each_box() -> None:
    for number in range(11):
        rows = filled(100, number)
        assert [len(row) for row in rows] == [9] * 5, number
        assert [row[0] for row in rows] == ["┏", "┃", "┃", "┃", "┗"], number


def test_in_a_large_window_a_number_is_in_block_letters() -> None:
    rows = filled(148, 10)
    assert [len(row) for row in rows] == [13] * 6
    assert all("█" in row or "▀" in row for row in rows[1:-1])


def test_without_a_choice_nothing_is_filled() -> None:
    assert with_chosen(options_text(PAIN, Entry(), 100)).spans == []
    assert with_chosen("Some words.").spans == []

"""Texts on lines of about the same length."""

from sar_tui.model.line_breaks import balanced


def test_no_word_is_alone_on_the_last_line() -> None:
    text = "That was a very strong attempt. 0.45 seconds, and that reaches the goal."
    assert balanced(text, 70).split("\n") == [
        "That was a very strong attempt.", "0.45 seconds, and that reaches the goal."
    ]  # fmt: skip


def test_lines_stay_apart_and_short_ones_as_they_are() -> None:
    assert balanced("One.\n\nTwo.", 20) == "One.\n\nTwo."
    assert balanced("", 0) == ""

"""Wordings are chosen that do not repeat what was just said."""

from sar_tui.rules.repetition import least_repeating, repeated


def test_a_word_is_repeated_whatever_its_ending_but_not_a_word_that_is_everywhere() -> None:
    assert repeated("You reached the goal.", "0.40 seconds, and that reaches the goal.") == 2
    assert repeated("You had this.", "You had that.") == 0
    assert repeated("Ha alcanzado la meta.", "Meta alcanzada.") == 2


def test_what_is_said_in_the_same_breath_counts_more_than_what_was_said_before() -> None:
    wordings = {"a": "You reached the goal.", "b": "Well done.", "c": "Very good."}
    assert least_repeating(wordings, "Inside the goal.", "") == ["b", "c"]
    assert least_repeating(wordings, "Inside the goal.", "Well done. Inside the goal.") == ["c"]
    assert least_repeating({"a": "Well done."}, "Well done.", "") == ["a"]

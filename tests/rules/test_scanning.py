"""A mark moves through choices, and one switch takes the marked one."""

import pytest

from sar_tui.model.units import MS
from sar_tui.rules.keys import UNREAD
from sar_tui.rules.scanning import ANTICIPATED, Choice, Scan, interval_ms

ABC = tuple(Choice(name, (name.lower(),)) for name in "ABC")
READ = UNREAD + 200 * MS


@pytest.mark.parametrize(
    ("press_times", "fixed", "interval"),
    [
        ((), 0, 1500),
        ((650, 650), 0, 1500),  # too few
        ((650, 650, 650), 0, 1000),
        ((500, 650, 800), 0, 1000),
        ((9000,) * 5 + (650,) * 10, 0, 1000),  # only the last ten
        ((100, 100, 100), 0, 500),  # bounded
        ((60_000,) * 3, 0, 10_000),
        ((650, 650, 650), 2000, 2000),  # set
    ],
)
def test_the_interval_is_the_mean_press_time_by_065(
    press_times: tuple[float, ...], fixed: int, interval: int
) -> None:
    assert interval_ms(press_times, fixed) == interval


def shown(switches: int = 1, choices: tuple[Choice, ...] = ABC, **settings: int) -> Scan:
    scan = Scan(2 if switches == 2 else 1, **settings)
    scan.show(choices, 0)
    return scan


def moved(scan: Scan, times: int) -> int:
    """Let the mark move; returns the time of its last move."""
    at = 0
    for _ in range(times):
        assert scan.due is not None
        at = scan.due
        scan.move(at)
    return at


def test_the_mark_goes_round_for_ever_and_the_first_choice_has_time_to_be_read() -> None:
    scan = shown(fixed_ms=1000)
    assert scan.due == 2000 * MS
    assert moved(scan, 7) == 8000 * MS
    assert scan.labels[scan.at] == "B"


def test_a_press_takes_the_marked_choice() -> None:
    scan = shown(fixed_ms=1000)
    at = moved(scan, 2) + 400 * MS
    assert scan.press("space", at)[:4] == ("taken", "C", ("c",), 400.0)


def test_a_press_right_after_a_move_is_meant_for_the_choice_before() -> None:
    scan = shown(fixed_ms=1000)
    at = moved(scan, 2) + ANTICIPATED - 1
    outcome, choice, _, press_ms, _ = scan.press("space", at)
    assert (outcome, choice) == ("taken", "B")
    assert press_ms == pytest.approx(1150, abs=1)


def test_a_press_before_the_choices_were_read_does_nothing() -> None:
    assert shown().press("space", UNREAD - 1).outcome == "early"


def test_time_to_read_is_no_press_time() -> None:
    assert shown().press("space", READ).press_ms is None


def test_a_press_of_a_choice_that_stays_longer_tells_nothing_of_the_person() -> None:
    scan = shown(choices=(ABC[0], ABC[1]._replace(rounds=6)), fixed_ms=1000)
    at = moved(scan, 1) + 5000 * MS
    assert scan.press("space", at)[:4] == ("taken", "B", ("b",), None)


def test_the_interval_follows_the_presses() -> None:
    scan, at = shown(), 0
    for _ in range(3):
        at = moved(scan, 1) + 390 * MS
        assert scan.press("enter", at).outcome == "taken"
        scan.show((), at)
        scan.show(ABC, at)
    assert scan.interval_ms == 600


def test_a_serious_choice_is_taken_after_yes() -> None:
    serious = (Choice("4", ("4", "enter"), question="You chose: 4."), *ABC)
    scan = shown(choices=serious, fixed_ms=1000)
    assert scan.press("space", READ)[:4] == ("asked", "4", (), None)
    assert scan.labels == ("Yes", "No")
    assert scan.press("space", 2 * READ)[:4] == ("taken", "Yes", ("4", "enter"), None)


def test_no_takes_nothing_and_goes_back_to_the_choices() -> None:
    scan = shown(choices=(Choice("4", ("4",), question="You chose: 4."), *ABC), fixed_ms=1000)
    scan.press("space", READ)
    at = moved(scan, 1) + 300 * MS
    assert scan.press("space", at)[:4] == ("taken", "No", (), 300.0)
    assert scan.labels == ("4", "A", "B", "C")


@pytest.mark.parametrize("after_ms", [40, 300, 650])
def test_a_press_that_bounces_or_is_held_takes_nothing_more(after_ms: int) -> None:
    scan = shown(choices=(Choice("4", ("4",), question="You chose: 4."),))
    scan.press("space", READ)
    assert scan.press("space", READ + after_ms * MS).outcome == "held"
    assert scan.asked


def test_a_bounce_time_may_be_longer_than_a_keyboard_needs_to_repeat() -> None:
    scan = shown(bounce=1000 * MS)
    scan.press("space", READ)
    assert scan.press("space", READ + 900 * MS).outcome == "held"


def test_both_keys_of_one_switch_are_the_same() -> None:
    scan = shown()
    scan.press("space", READ)
    assert scan.press("enter", READ + 40 * MS).outcome == "held"


def test_with_two_switches_one_moves_and_the_other_takes() -> None:
    scan = shown(switches=2)
    assert scan.due is None
    assert scan.press("space", READ).outcome == "moved"
    assert scan.press("enter", READ + 300 * MS)[:4] == ("taken", "B", ("b",), None)


def test_with_two_switches_either_takes_the_only_choice() -> None:
    assert shown(switches=2, choices=ABC[:1]).press("space", READ).keys == ("a",)


def test_the_same_words_again_keep_the_mark() -> None:
    scan = shown(fixed_ms=1000)
    at = moved(scan, 1)
    scan.show(tuple(choice._replace(keys=("x",)) for choice in ABC), at)
    assert scan.press("space", at + 300 * MS).keys == ("x",)

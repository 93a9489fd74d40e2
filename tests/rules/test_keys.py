"""The rule for keys on a new screen: what was down when it appeared, and what was pressed too
early, does nothing.
"""

from itertools import accumulate

from hypothesis import given
from hypothesis import strategies as st

from sar_tui.model.units import MS
from sar_tui.rules.keys import QUIET, UNREAD, KeyGuard, repeats


def judged(*keys: tuple[str, int], appeared: int = 0) -> list[tuple[bool, bool]]:
    """Return of each key, pressed at a time in ms, if it is new and if it counts on a screen that
    appeared at one.
    """
    guard = KeyGuard()
    found = []
    is_there = False
    for key, at in keys:
        if at >= appeared and not is_there:
            guard.appeared(appeared * MS)
            is_there = True
        press = guard.press(key, at * MS)
        found.append((press.is_new, press.counts))
    return found


def test_a_press_counts_when_the_screen_has_been_there_for_a_while() -> None:
    assert judged(("enter", 599)) == [(True, False)]
    assert judged(("enter", 600)) == [(True, True)]


def test_a_key_that_is_held_since_before_the_screen_does_nothing_until_it_is_pressed_anew() -> None:
    held = [("enter", -50), *(("enter", at) for at in range(450, 5000, 33))]
    last = held[-1][1]
    found = judged(*held, ("enter", last + 701))
    assert not any(counts for _, counts in found[1:-1])
    assert found[-1] == (True, True)


def test_the_repeats_of_a_press_that_came_too_early_do_nothing() -> None:
    assert not any(
        counts for _, counts in judged(*(("enter", at) for at in (300, 800, *range(833, 3000, 33))))
    )


def test_a_key_that_is_held_on_a_screen_counts_there_but_is_new_once() -> None:
    expected = [(True, True), (False, True), (False, True)]
    assert judged(("down", 700), ("down", 1200), ("down", 1233)) == expected


def test_another_key_is_new_at_once() -> None:
    expected = [(True, True), (False, False), (True, True)]
    assert judged(("enter", -50), ("enter", 450), ("space", 620)) == expected


@given(
    before=st.integers(1, 2000),
    delay=st.integers(200, 660),
    period=st.integers(25, 50),
    jitter=st.lists(st.integers(0, 20), min_size=60, max_size=60),
)
def test_no_repeat_of_a_key_held_before_counts(
    before: int, delay: int, period: int, jitter: list[int]
) -> None:
    first = -before
    stamps = [
        first,
        *(first + delay + number * period + late for number, late in enumerate(jitter)),
    ]
    found = judged(*(("enter", at) for at in stamps))
    assert not any(counts for (_, counts), at in zip(found, stamps, strict=True) if at >= 0)


def test_an_attempt_needs_quiet_keys_of_any_kind() -> None:
    guard = KeyGuard()
    guard.press("x", 0)
    assert not guard.press("enter", QUIET - 1).after_quiet
    assert guard.press("enter", 2 * QUIET - 1).after_quiet
    assert QUIET > UNREAD


# --- a key that is held

TAPS = st.lists(st.integers(85, 260), max_size=80)
"""Times between the taps of people (ms): about 7 a second at the fastest, never the same."""


def stamps(gaps_ms: list[int]) -> list[int]:
    return [at * MS for at in accumulate(gaps_ms, initial=0)]


@given(TAPS)
def test_every_tap_of_a_finger_counts(gaps_ms: list[int]) -> None:
    assert repeats(stamps(gaps_ms)) == set()


@given(
    before=TAPS,
    delay=st.integers(250, 660),
    rate_hz=st.integers(20, 40),
    jitter=st.lists(st.integers(0, 12), min_size=8, max_size=200),
    after=TAPS.filter(bool),
)
def test_a_held_key_is_one_press_and_the_taps_around_it_count(
    before: list[int], delay: int, rate_hz: int, jitter: list[int], after: list[int]
) -> None:
    taps = stamps(before)
    first = taps[-1] + delay * MS
    held = [
        first + round(number / rate_hz * 1000 * MS) + late * MS
        for number, late in enumerate(jitter)
    ]
    later = [held[-1] + at for at in stamps(after)[1:]]
    assert repeats([*taps, *held, *later]) == set(held)


def test_repeats_that_are_read_together_are_repeats() -> None:
    held = [500 + 100 * batch for batch in range(12) for _ in range(3)]
    assert repeats([0, *(at * MS for at in held)]) == {at * MS for at in held}

"""The rule for keys on a new screen: what was down when it appeared, and what was pressed too
early, does nothing.
"""

from hypothesis import given
from hypothesis import strategies as st

from sar_tui.model.units import MS
from sar_tui.rules.key_guard import QUIET, UNREAD, KeyGuard


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
    assert judged(("down", 700), ("down", 1200), ("down", 1233)) == [
        (True, True),
        (False, True),
        (False, True),
    ]


def test_another_key_is_new_at_once() -> None:
    assert judged(("enter", -50), ("enter", 450), ("space", 620)) == [
        (True, True),
        (False, False),
        (True, True),
    ]


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

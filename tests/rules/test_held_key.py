"""A held key is told from a finger that taps as fast as it can, by the time stamps of both."""

from itertools import accumulate

from hypothesis import given
from hypothesis import strategies as st

from sar_tui.model.units import MS
from sar_tui.rules.held_key import repeats

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

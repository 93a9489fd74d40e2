"""Given a stream of keys, when they are perceived, then presses are told from repeats, by their stamps alone."""

from hypothesis import given
from hypothesis import strategies as st

from sar_tui.framework.bus import Bus
from sar_tui.framework.clock import MS, VirtualClock
from sar_tui.framework.messages import KeyPerceived, KeyPressed, SessionStarted
from sar_tui.framework.nodes.perception import Perception
from sar_tui.framework.parameters import TaskParameters, build
from sar_tui.framework.topics import KEY, PERCEIVED, SESSION


def perceived(*keys: tuple[str, int], interval: int = 100, delay: int = 0, new_run: bool = False) -> list[KeyPerceived]:
    """What is perceived of keys stamped at so many ms, each handled ``delay`` ms later."""
    clock = VirtualClock()
    bus = Bus(clock)
    Perception(build(TaskParameters, {"repeat_interval_ms": interval})).attach(bus)
    found: list[KeyPerceived] = []
    bus.subscribe(PERCEIVED, found.append)
    for key, at in keys:
        clock.set((at + delay) * MS)
        if new_run:
            bus.publish(SESSION, SessionStarted(run=2, task="t", theme="t", seed=1))
        bus.publish(KEY, KeyPressed(key=key, at=at * MS, loop_lag=7))
    return found


def test_the_first_key_has_no_gap_and_a_later_one_the_time_since_the_one_before() -> None:
    assert [percept.gap for percept in perceived(("f", 10), ("j", 260))] == [None, 250 * MS]


def test_the_same_key_within_the_interval_is_a_repeat_and_another_is_not() -> None:
    keys = perceived(("f", 0), ("f", 99), ("f", 199), ("j", 210), ("f", 220))
    assert [percept.repeat for percept in keys] == [False, True, False, False, False]


def test_a_held_key_stays_a_repeat_however_long_it_is_held() -> None:
    assert [p.repeat for p in perceived(*[("f", at) for at in range(0, 3000, 30)])] == [False] + [True] * 99


def test_the_delay_is_from_stamp_to_handling_and_the_lag_is_passed_on() -> None:
    (percept,) = perceived(("f", 10), delay=3)
    assert (percept.at, percept.delay, percept.loop_lag) == (10 * MS, 3 * MS, 7)


def test_stamps_of_an_earlier_run_are_not_compared_with() -> None:
    assert [(p.gap, p.repeat) for p in perceived(("f", 10), ("f", 20), new_run=True)] == [(None, False)] * 2


@given(st.lists(st.tuples(st.sampled_from("fj"), st.integers(0, 300)), max_size=20), st.integers(0, 200))
def test_only_the_same_key_within_the_interval_is_ever_a_repeat(gaps: list[tuple[str, int]], interval: int) -> None:
    at = 0
    keys = []
    for key, gap in gaps:
        at += gap
        keys.append((key, at))
    expected = [
        bool(i) and keys[i - 1][0] == key and stamp - keys[i - 1][1] < interval for i, (key, stamp) in enumerate(keys)
    ]
    assert [percept.repeat for percept in perceived(*keys, interval=interval)] == expected

"""Perception distinguishes presses from repeats by their time stamps."""

from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop.bus import Bus
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.nodes.perception import Perception
from sar_tui.loop.topics import KEY, PERCEIVED, SESSION
from sar_tui.model.messages import KeyPerceived, KeyPressed, SessionStarted
from sar_tui.model.units import MS
from sar_tui.rules.parameters import TaskParameters, build


def perceived(
    *keys: tuple[str, int],
    interval: int = 100,
    delay: int = 0,
    new_run: bool = False,
    bounce: int = 0,
) -> list[KeyPerceived]:
    """Return the percepts of keys stamped at given times (ms), each handled ``delay`` ms later."""
    clock = VirtualClock()
    bus = Bus(clock)
    Perception(build(TaskParameters, {"repeat_interval_ms": interval, "bounce_ms": bounce})).attach(
        bus
    )
    found: list[KeyPerceived] = []
    bus.subscribe(PERCEIVED, found.append)
    for key, at in keys:
        clock.set((at + delay) * MS)
        if new_run:
            bus.publish(SESSION, SessionStarted(run=2, task="t", theme="t", seed=1))
        bus.publish(KEY, KeyPressed(key=key, at=at * MS, loop_lag=7))
    return found


def test_the_gap_is_the_time_since_the_previous_key() -> None:
    assert [percept.gap for percept in perceived(("f", 10), ("j", 260))] == [None, 250 * MS]


def test_delay_from_stamp_to_handling_and_loop_lag_are_passed_on() -> None:
    (percept,) = perceived(("f", 10), delay=3)
    assert (percept.at, percept.delay, percept.loop_lag) == (10 * MS, 3 * MS, 7)


def test_keys_of_an_earlier_run_are_forgotten() -> None:
    assert [(p.gap, p.repeat) for p in perceived(("f", 10), ("f", 20), new_run=True)] == [
        (None, False)
    ] * 2


@given(
    st.lists(st.tuples(st.sampled_from("fj"), st.integers(0, 300)), max_size=20),
    st.integers(0, 200),
)
def test_repeats_are_always_the_same_key_within_the_interval(
    gaps: list[tuple[str, int]], interval: int
) -> None:
    at = 0
    keys = []
    for key, gap in gaps:
        at += gap
        keys.append((key, at))
    expected = [
        bool(i) and keys[i - 1][0] == key and stamp - keys[i - 1][1] < interval
        for i, (key, stamp) in enumerate(keys)
    ]
    assert [percept.repeat for percept in perceived(*keys, interval=interval)] == expected


def test_a_key_that_bounces_is_a_repeat() -> None:
    pressed = perceived(("space", 0), ("space", 299), ("space", 700), bounce=300)
    assert [percept.repeat for percept in pressed] == [False, True, False]

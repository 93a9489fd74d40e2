"""Clocks run callbacks in order; the virtual clock does so identically each time."""

import asyncio
import threading

from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop.clock import LiveClock, PacedClock, VirtualClock, host_now
from sar_tui.model.units import SECOND


@given(st.lists(st.integers(0, 50)))
def test_callbacks_run_by_time_then_in_the_order_of_request(times: list[int]) -> None:
    clock = VirtualClock()
    ran: list[tuple[int, int, int]] = []
    for number, when in enumerate(times):
        clock.call_at(
            when, lambda number=number, when=when: ran.append((when, number, clock.now()))
        )
    while clock.step():
        pass
    assert ran == [
        (when, number, when) for when, number in sorted((when, n) for n, when in enumerate(times))
    ]


def test_a_callback_in_the_past_runs_now() -> None:
    clock = VirtualClock(100)
    at: list[int] = []
    clock.call_at(20, lambda: at.append(clock.now()))
    assert clock.step()
    assert at == [100]


def test_advance_runs_what_falls_due_and_leaves_the_rest() -> None:
    clock = VirtualClock()
    ran: list[int] = []
    for when in (10, 20, 30):
        clock.call_at(when, lambda when=when: ran.append(when))
    clock.advance(20)
    assert (ran, clock.now()) == ([10, 20], 20)
    clock.advance(20)
    assert (ran, clock.now()) == ([10, 20, 30], 40)


def test_a_cancelled_callback_does_not_run_or_move_the_clock() -> None:
    clock = VirtualClock()
    ran: list[str] = []
    clock.call_at(10, lambda: ran.append("called off")).cancel()
    assert not clock.step()
    assert (ran, clock.now()) == ([], 0)


async def test_a_live_clock_runs_callbacks_where_its_run_is_awaited_and_not_before_they_are_due() -> (
    None
):
    clock = LiveClock(asyncio.get_running_loop())
    ran: list[tuple[str, bool]] = []
    done = asyncio.Event()
    due = host_now() + 3_000_000
    clock.call_at(due, lambda: (ran.append(("timer", clock.now() >= due)), done.set()))
    clock.call_at(due, lambda: ran.append(("called off", False))).cancel()
    thread = threading.Thread(target=clock.call_soon, args=(lambda: ran.append(("post", True)),))
    thread.start()
    thread.join()
    assert ran == []
    running = asyncio.create_task(clock.run())
    await done.wait()
    running.cancel()
    assert ran == [("post", True), ("timer", True)]


# --- a clock for devices


def test_it_jumps_while_nothing_is_at_work() -> None:
    clock = PacedClock()
    clock.begin_work("arm")
    clock.end_work("arm")
    clock.call_at(3600 * SECOND, lambda: None)
    assert clock.step()
    assert clock.now() == 3600 * SECOND


def test_it_waits_for_a_device_and_takes_its_callback_before_later_ones() -> None:
    clock = PacedClock()
    ran: list[tuple[str, bool]] = []
    clock.call_at(3600 * SECOND, lambda: ran.append(("timer", clock.now() == 3600 * SECOND)))
    clock.begin_work("arm")

    def arrived() -> None:
        clock.end_work("arm")
        ran.append(("arm", 0 <= clock.now() < 3600 * SECOND))

    device = threading.Thread(target=clock.call_soon, args=(arrived,))
    device.start()
    while clock.step():
        pass
    device.join()
    assert ran == [("arm", True), ("timer", True)]


def test_it_waits_no_longer_than_until_the_next_callback() -> None:
    clock = PacedClock()
    ran: list[str] = []
    clock.call_at(2_000_000, lambda: ran.append("cancelled")).cancel()
    clock.call_at(3_000_000, lambda: (ran.append("due"), clock.end_work("arm")))
    clock.call_at(3600 * SECOND, lambda: ran.append("later"))
    clock.begin_work("arm")
    while clock.step():
        pass
    assert ran == ["due", "later"]


def test_it_counts_callbacks_requested_for_later() -> None:
    clock = PacedClock()
    clock.call_soon(lambda: None)
    assert clock.timers == 0
    clock.call_at(1, lambda: None)
    assert clock.timers == 1

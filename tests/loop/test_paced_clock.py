"""The clock of simulations jumps, except while a device is at work."""

import threading

from sar_tui.loop.paced_clock import PacedClock
from sar_tui.model.units import SECOND


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

"""Estimate of the session's clock in another program."""

from sar_tui.link.protocol import Pong
from sar_tui.link.remote_clock import RemoteClock
from sar_tui.model.units import MS, SECOND

AHEAD = 1000 * SECOND


class Watch:
    """Clock set by hand."""

    now = 5 * SECOND

    def __call__(self) -> int:
        return self.now


def ping(
    clock: RemoteClock, watch: Watch, outward: int, back: int, clock_id: str = "there"
) -> None:
    """Exchange a ping with these travel times (ns)."""
    sent = watch.now
    watch.now += outward + back
    clock.update(Pong(sent, sent + outward + AHEAD, clock_id, 0, "1"))


def test_on_the_same_host_it_is_the_same_clock_whatever_pings_say() -> None:
    watch = Watch()
    clock = RemoteClock(watch, "here")
    ping(clock, watch, 100 * MS, 1 * MS, clock_id="here")
    assert clock.now() == watch.now


def test_elsewhere_it_is_off_by_no_more_than_half_of_the_shortest_round_trip() -> None:
    watch = Watch()
    clock = RemoteClock(watch, "here")
    for there, back in ((40, 2), (3, 1), (90, 5)):
        ping(clock, watch, there * MS, back * MS)
    assert abs(clock.now() - (watch.now + AHEAD)) <= 2 * MS


def test_pings_from_before_a_restart_of_the_sessions_machine_do_not_count() -> None:
    watch = Watch()
    clock = RemoteClock(watch, "here")
    ping(clock, watch, 1, 1)
    sent = watch.now
    watch.now += 10 * MS
    clock.update(Pong(sent, 7, "there, restarted", 0, "1"))
    assert abs(clock.now() - 7) <= 10 * MS

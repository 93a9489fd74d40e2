"""A session of reaches at a real pseudo-terminal, measured by a phone that is lost and comes back."""

import math
import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import numpy as np
import pytest

from sar_tui.model.units import MS, SECOND
from sar_tui.store import imu
from sar_tui.store.database import connect
from sar_tui.timing.pty import Terminal
from tests.end_to_end.participant_terminal import (
    command,
    only_session,
    replays_identically,
    rows,
    see_the_summary,
)
from tests.end_to_end.test_reaching import press, rest, start_reach
from tests.inputs.fake_phone import LYING, Phone, Vector

STEP_S = 0.005
WAY_S, HOLD_S, TURN_RAD = 0.6, 0.3, 0.9
"""Duration of each way of a reach, of the touch between them, and how far the hand turns."""
LOST = 4 * SECOND


class Hand:
    """A hand with a phone on it, in real time: it rests until it is told to reach."""

    def __init__(self, phone: Phone) -> None:
        self._phone = phone
        self._ended = threading.Event()
        self.reached: list[float] = []
        """Times at which each reach began, in s since the phone was there."""
        self.started_s = 0.0
        """The same of the beginning of the measurement, from which the phone counts its time."""

    def reach(self) -> None:
        """Reach out and back, from now on."""
        self.reached.append(self._phone.now_s)
        self.started_s = self._phone.now_s - self._phone.t

    def rate(self, at: float) -> Vector:
        """Return the angular rate at a time of the phone: minimum jerk on each way."""
        since = at - self.reached[-1] if self.reached else -1.0
        for start, sign in ((0.0, 1.0), (WAY_S + HOLD_S, -1.0)):
            u = (since - start) / WAY_S
            if 0 < u < 1:
                return (0.0, 0.0, sign * TURN_RAD * 30 * u**2 * (1 - u) ** 2 / WAY_S)
        noise = 0.002 * math.sin(97 * at)
        return (noise, -noise, noise)

    def run(self) -> None:
        """Measure as time passes."""
        began = self._phone.began_ns
        while not self._ended.wait(STEP_S):
            due = int((time.monotonic_ns() - began) / SECOND / STEP_S)
            done = round(self._phone.now_s / STEP_S)
            if due > done:
                self._phone.measure(due - done, STEP_S, self.rate, lambda _: LYING)

    def stop(self) -> None:
        """Stop measuring."""
        self._ended.set()


@contextmanager
def hand() -> Iterator[tuple[Phone, Hand]]:
    """Provide a phone that answers, on a hand that moves."""
    phone = Phone()
    phone.began_ns = time.monotonic_ns()
    moved = Hand(phone)
    phone.arrive()
    moving = threading.Thread(target=moved.run, daemon=True)
    moving.start()
    try:
        yield phone, moved
    finally:
        moved.stop()
        moving.join()
        phone.leave()


@pytest.mark.slow
def test_a_phone_that_is_lost_between_two_reaches_invents_none(data: Path) -> None:
    with hand() as (phone, moved):
        source = f"phyphox://127.0.0.1:{phone.port}"
        words = ("run", "reaching", "-p", "P01", "--new", "--data", str(data), "--imu", source)
        with Terminal(command(*words, "--set=attempts=2", "--seed=7")) as terminal:
            terminal.wait_for("Check the sensor")
            terminal.wait_for("Test 5")
            terminal.wait_for("Press Enter to go on.", since=press(terminal, "enter"))
            terminal.wait_for("Press Enter to begin", since=press(terminal, "enter"))
            start_reach(terminal, press(terminal, "enter"))
            _reach(terminal, moved)
            terminal.wait_for("Press Enter for attempt 2 of 2.")

            phone.leave()
            rest(terminal, LOST)
            phone.arrive()
            rest(terminal, 2 * SECOND)
            start_reach(terminal, press(terminal, "enter"))
            _reach(terminal, moved)
            see_the_summary(terminal)
            terminal.confirm()
            assert terminal.wait() == 0

    trials = rows(data, "SELECT correct, onset_ns, response_ns FROM trials ORDER BY onset_ns")
    assert [correct for correct, _, _ in trials] == [1, 1]
    for began_s, (_, onset, end) in zip(moved.reached, trials, strict=True):
        truth = phone.began_ns + round(began_s * SECOND)
        assert 0 < onset - truth < 150 * MS
        assert abs(end - truth - (2 * WAY_S + HOLD_S) * SECOND) < 150 * MS
    with closing(connect(data)) as database:
        measured = imu.samples(database, only_session(data))
    true_ms = phone.began_ns / MS + 1000 * moved.started_s + measured["device_ms"]
    error_ms = measured["at"] / MS - true_ms
    assert abs(np.median(error_ms)) < 5
    assert replays_identically(data)


def _reach(terminal: Terminal, moved: Hand) -> None:
    rest(terminal, 500 * MS)
    moved.reach()
    rest(terminal, round((2 * WAY_S + HOLD_S + 0.4) * SECOND))
    terminal.press("space")

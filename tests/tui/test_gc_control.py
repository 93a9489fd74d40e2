"""Timing in the terminal apps: garbage collection in trials, punctual timers, and the stamps of flushes."""

import asyncio
import selectors
from collections.abc import AsyncIterator
from typing import Any

import pytest

from sar_tui.model.units import MS
from sar_tui.tui import gc_control, timestamps
from sar_tui.tui.base_app import BaseApp
from sar_tui.tui.gc_control import GcControl
from sar_tui.tui.timestamps import OnsetWatch


class Host:
    """The host's clock, moved by hand."""

    def __init__(self) -> None:
        self.now = 1000 * MS

    def wait(self, ms: int) -> None:
        self.now += ms * MS


@pytest.fixture
def host(monkeypatch: pytest.MonkeyPatch) -> Host:
    host = Host()
    monkeypatch.setattr(gc_control, "host_now", lambda: host.now)
    return host


@pytest.fixture
async def control(host: Host) -> AsyncIterator[GcControl]:
    control = GcControl()
    control.begin_trial()
    yield control
    control.end_trial()


async def test_a_key_that_waited_during_a_suspension_is_known(
    host: Host, control: GcControl
) -> None:
    host.wait(2800)
    read = host.now
    host.wait(3)
    assert control.is_stalled(read)
    assert control.lag > 2700 * MS


async def test_a_key_long_after_a_suspension_is_timed(host: Host, control: GcControl) -> None:
    host.wait(2800)
    control._tick()
    host.wait(15)
    assert control.is_stalled(host.now - MS)
    host.wait(200)
    assert not control.is_stalled(host.now)


async def test_a_short_delay_is_no_suspension(host: Host, control: GcControl) -> None:
    host.wait(200)
    assert not control.is_stalled(host.now)


async def test_a_suspension_before_the_trial_does_not_count(host: Host, control: GcControl) -> None:
    host.wait(2800)
    control._tick()
    control.end_trial()
    control.begin_trial()
    assert not control.is_stalled(host.now)


IN_WHOLE_MS = tuple(
    getattr(selectors, name)
    for name in ("EpollSelector", "PollSelector", "DevpollSelector")
    if hasattr(selectors, name)
)
"""Selectors that round the time until the next timer up to milliseconds."""


def test_an_app_runs_on_a_loop_that_does_not_wait_in_whole_milliseconds() -> None:
    loops: list[Any] = []

    class Noting(BaseApp):
        async def run_async(self, **how: Any) -> None:
            loops.append(asyncio.get_running_loop())

    assert Noting().run_here() == 0
    assert not isinstance(getattr(loops[0], "_selector", None), IN_WHOLE_MS)


@pytest.mark.parametrize(
    ("text", "written", "is_onset"),
    [
        ("Press: f", "\x1b[5;10HPress: f\x1b[0m", True),
        ("Press: f", "\x1b[5;10HPress: g\x1b[0m", False), ("5", "\x1b[5;10H \x1b[0m", False),
        ("5", "\x1b[5;10H5\x1b[0m", True), ("", "\x1b[?2026h", False),
        ("", "\x1b[5;10H   \x1b[0m", True),
    ],
)  # fmt: skip
def test_a_text_is_stamped_when_it_is_flushed(text: str, written: str, is_onset: bool) -> None:
    watch, stamps = OnsetWatch(), list[int]()
    watch.arm(text, stamps.append)
    watch.wrote(written)
    watch.wrote("\x1b[?2026l")
    watch.flushed()
    watch.flushed()
    assert len(stamps) == is_onset


def test_a_frame_drawn_early_is_flushed_when_due(monkeypatch: pytest.MonkeyPatch) -> None:
    slept: list[float] = []
    monkeypatch.setattr(timestamps, "host_now", lambda: 1000 * MS)
    monkeypatch.setattr("sar_tui.tui.timestamps.time.sleep", slept.append)
    watch = OnsetWatch()
    watch.arm("target", [].append, due=1005 * MS)
    watch.await_time()
    assert slept == [], "something else is flushed before"
    watch.wrote("target")
    watch.await_time()
    assert slept == [0.005]
    watch.arm("target", [].append, due=5000 * MS)
    watch.wrote("target")
    watch.await_time()
    assert slept[1:] == [0.02], "a wrong time does not block the terminal"
    watch.arm("target", [].append, due=990 * MS)
    watch.wrote("target")
    watch.await_time()
    assert len(slept) == 2

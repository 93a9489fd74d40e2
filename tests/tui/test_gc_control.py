"""The lag of the event loop, and what was stamped after the program had been suspended."""

from collections.abc import AsyncIterator

import pytest

from sar_tui.model.units import MS
from sar_tui.tui import gc_control
from sar_tui.tui.gc_control import GcControl


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


async def test_a_key_that_waited_while_the_program_was_suspended_is_known(
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

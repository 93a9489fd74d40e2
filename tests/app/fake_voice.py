"""A voice that says what is asked of it when, and as, a test wants it: an output like a plug-in's."""

from collections.abc import Callable

import pytest

from sar_tui.outputs.output import Output
from tests.app.app_driver import AppDriver


class Voice(Output):
    """Keeps what it is asked to say; the test tells what becomes of it."""

    name = "voice"
    can = frozenset({"say"})

    def __init__(self) -> None:
        self.asked: list[tuple[str, str]] = []
        self.stops: list[str] = []
        self.is_closed = False
        self._over = 0

    def say(self, action: str, text: str) -> None:
        self.asked.append((action, text))

    def stop(self, action: str = "") -> None:
        self.stops.append(action)
        for asked, _ in self.asked[self._over :]:
            self.report(asked, "say", "aborted")
        self._over = len(self.asked)

    def close(self) -> None:
        self.is_closed = True

    async def begin(self, driver: AppDriver) -> None:
        """Begin to speak the last request."""
        self.report(self.asked[-1][0], "say", "started")
        await driver.settle()

    async def end(self, driver: AppDriver) -> None:
        """It has been said to its end."""
        self._over = len(self.asked)
        self.report(self.asked[-1][0], "say", "done")
        await driver.settle()

    async def fail(self, driver: AppDriver) -> None:
        """It could not be said."""
        self._over = len(self.asked)
        self.report(self.asked[-1][0], "say", "failed", "The loudspeaker is gone.")
        await driver.settle()


class _Entry:
    """An entry point."""

    name = "voice"
    value = "tests.app.fake_voice:Voice"

    def __init__(self, voice: Voice) -> None:
        self._voice = voice

    def load(self) -> Callable[[str], Output]:
        return lambda _: self._voice


@pytest.fixture
def voice(monkeypatch: pytest.MonkeyPatch) -> Voice:
    """A voice that is installed; a session has it with ``outputs=["screen", "voice"]``."""
    installed = Voice()
    monkeypatch.setattr("sar_tui.outputs.outputs.entry_points", lambda group: [_Entry(installed)])
    return installed

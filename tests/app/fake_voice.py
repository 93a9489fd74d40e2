"""A voice output under the control of a test, installed like that of a plug-in."""

from collections.abc import Callable

import pytest

from sar_tui.outputs.output import Output
from tests.app.app_driver import AppDriver
from tests.plugged_in import offer


class Voice(Output):
    """Voice that records requests and reports only when the test says so."""

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
        """Report that the last request has started."""
        self.report(self.asked[-1][0], "say", "started")
        await driver.settle()

    async def end(self, driver: AppDriver) -> None:
        """Report the end of the utterance."""
        self._over = len(self.asked)
        self.report(self.asked[-1][0], "say", "done")
        await driver.settle()

    async def fail(self, driver: AppDriver) -> None:
        """Report that the utterance failed."""
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
    """Install a voice; a session uses it with ``outputs=["screen", "voice"]``."""
    installed = Voice()
    offer(monkeypatch, "sar_tui.outputs", [_Entry(installed)])
    return installed

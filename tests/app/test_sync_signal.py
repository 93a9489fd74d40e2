"""The flash and the tone before a session, for cameras."""

from collections.abc import Callable
from typing import Any

import pytest

from sar_tui.loop.clock import Clock
from sar_tui.model.units import MS
from sar_tui.outputs.output import Report
from tests.app.app_driver import AppDriver, OpenSession
from tests.outputs.markers.receivers import udp_receiver


class FakeSound:
    """Sound whose tone a test reports."""

    made: list["FakeSound"]

    def __init__(self, where: str) -> None:
        self.played: list[str] = []
        self.has_left = False
        type(self).made.append(self)

    def join(self, kind: str, clock: Clock, report: Callable[[Report], object]) -> None:
        self._report, self._clock = report, clock

    def get_ready(self, kind: str, tones: object) -> None: ...

    def tone(self, action: str, notes: object) -> None:
        self.played.append(action)

    def leave(self, kind: str) -> None:
        self.has_left = True

    async def report(self, driver: AppDriver, state: Any, detail: str = "") -> None:
        self._report(Report("sync", "tone", state, self._clock.now(), detail))
        await driver.settle()


@pytest.fixture
def sound(monkeypatch: pytest.MonkeyPatch) -> type[FakeSound]:
    class Sound(FakeSound):
        made: list[FakeSound] = []

    monkeypatch.setattr("sar_tui.app.screens.sync_signal.Sound", Sound)
    return Sound


async def test_flash_and_tone_are_sent_with_stamps(
    open_session: OpenSession, sound: type[FakeSound]
) -> None:
    with udp_receiver() as receiver:
        async with open_session(markers=[receiver.address], sync_flash=True) as driver:
            driver.see("A short flash and a tone", "Press Enter when the camera")
            await driver.press("enter")
            flashed = driver.clock.now()
            (player,) = sound.made
            assert player.played == ["sync"]
            assert driver.app.screen.has_class("flash")
            await driver.wait(50)
            await player.report(driver, "started")
            await driver.wait(150)
            assert not driver.app.screen.has_class("flash"), "it flashes once"
            assert driver.screen_name == "SyncScreen", "the tone is not over"
            await player.report(driver, "done")
            assert driver.screen_name == "SessionScreen"
            assert player.has_left
            await driver.do_session()
            signals = driver.messages("output/sync")
            stored = [(each["what"], each["at"], each["source"]) for each in signals]
        markers = [
            (m["event"], m["ns"])
            for m in receiver.until("session_end")
            if m["event"].startswith("sync_")
        ]
    assert stored == [("flash", flashed, "refresh"), ("tone", flashed + 50 * MS, "sound")]
    assert markers == [("sync_flash", flashed), ("sync_tone", flashed + 50 * MS)]


async def test_a_tone_that_fails_is_told(open_session: OpenSession, sound: type[FakeSound]) -> None:
    async with open_session(sync_flash=True) as driver:
        await driver.press("enter")
        await sound.made[0].report(driver, "failed", "There is no sound card.")
        await driver.wait(200)
        driver.see("There was no tone: There is no sound card.")
        await driver.press("enter")
        await driver.to_first_prompt()
        assert [signal["what"] for signal in driver.messages("output/sync")] == ["flash"]


async def test_esc_leaves_flash_and_tone_out(
    open_session: OpenSession, sound: type[FakeSound]
) -> None:
    async with open_session(language="es", sync_flash=True) as driver:
        driver.see("Un destello breve y un tono")
        await driver.press("escape")
        assert driver.screen_name == "SessionScreen"
        await driver.to_first_prompt()
        assert driver.messages("output/sync") == []
    assert sound.made[0].played == []

"""A flash and a tone at the start of a session, by which recordings of cameras are aligned."""

import asyncio
from typing import Any, ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.widgets import Static

from sar_tui.app.live import LiveSession
from sar_tui.model.theme import Note
from sar_tui.model.units import MS, SECOND
from sar_tui.outputs.output import Report
from sar_tui.outputs.sound.mixer import Sound
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.widgets.language import language_of

FLASH = 200 * MS
"""Duration of the only flash: several frames of a video, and no flicker that could harm anybody."""
TONE = (Note(1000, 200),)
_PATIENCE = 5 * SECOND
"""Longest wait for the tone to end."""


class SyncScreen(DismissedOnce[None]):
    """Covers a session that waits for its first Enter, until the screen has flashed once and a tone
    was played.

    Both are reported to the session with the time at which they happened: the flush of the white
    frame, and the feeding of the first samples to the sound card. Esc leaves them out.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("enter", "go_on", show=False),
        Binding("escape", "leave_out", show=False),
    ]
    AUTO_FOCUS = ""

    def __init__(self, live: LiveSession) -> None:
        super().__init__()
        self._live = live
        self._sound = Sound(live.session.task.parameters.speech)
        self._state = "ready"
        self._is_flash_over = self._is_tone_over = False
        self._problem = ""

    def compose(self) -> ComposeResult:
        yield Static(id="sync-signal", markup=False)

    def on_mount(self) -> None:
        loop = asyncio.get_running_loop()
        self._sound.join(
            "tone",
            self._live.clock,
            lambda report: loop.call_soon_threadsafe(self._reported, report),
        )
        self._sound.get_ready("tone", tones=[TONE])
        tr = language_of(self.app)
        self._show(
            tr("A short flash and a tone: for the camera."),
            tr("Press Enter when the camera is recording."),
            tr("Esc: without flash and tone"),
        )

    def on_unmount(self) -> None:
        self._sound.leave("tone")

    def action_go_on(self) -> None:
        """Enter: flash and play; after a tone that could not be played, go on."""
        if self._state == "ready":
            self._state = "signals"
            self._flash()
            self._sound.tone("sync", TONE)
            clock = self._live.clock
            clock.call_at(clock.now() + FLASH, self._end_flash)
            clock.call_at(
                clock.now() + _PATIENCE, lambda: self._end_tone("It was not heard of again.")
            )
        elif self._state == "problem":
            self.dismiss()

    def action_leave_out(self) -> None:
        """Esc, before the signals: go on without them."""
        if self._state == "ready":
            self.dismiss()

    def _flash(self) -> None:
        tr = language_of(self.app)
        text = tr("Flash")
        app: Any = self.app
        if getattr(app._driver, "can_stamp_onset", False):
            app.onset_watch.arm(text, lambda at: self._live.signal("flash", at, "flush"))
        else:
            self.call_after_refresh(
                lambda: self._live.signal("flash", self._live.clock.now(), "refresh")
            )
        self.add_class("flash")
        self._show(text)

    def _end_flash(self) -> None:
        if self.is_mounted:
            self.remove_class("flash")
            self._show("")
            self._is_flash_over = True
            self._end()

    def _reported(self, report: Report) -> None:
        if report.state == "started":
            self._live.signal("tone", report.at, "sound")
        elif report.state in ("done", "aborted"):
            self._end_tone()
        elif report.state == "failed":
            self._end_tone(report.detail)

    def _end_tone(self, problem: str = "") -> None:
        if not self._is_tone_over:
            self._is_tone_over, self._problem = True, problem
            self._end()

    def _end(self) -> None:
        """Go on once both are over; say first if the tone was not played."""
        if not (self._is_flash_over and self._is_tone_over and self.is_mounted):
            return
        if not self._problem:
            self.dismiss()
            return
        self._state = "problem"
        tr = language_of(self.app)
        self._show(tr("There was no tone: {why}", why=self._problem), tr("Press Enter to go on."))

    def _show(self, *parts: str) -> None:
        self.query_one("#sync-signal", Static).update("\n\n".join(parts))

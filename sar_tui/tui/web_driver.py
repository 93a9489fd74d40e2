"""The app in a browser: a web driver that ends the app with its browser, and can speak there."""

import contextlib
import os
from typing import Any, Protocol, runtime_checkable

from textual.drivers import web_driver
from textual.drivers.web_driver import WebDriver

from sar_tui.tui.terminal_input import tolerate

tolerate(web_driver)

ALIVE_INTERVAL_S = 0.5
"""Time between two signs of life of the app, which its page waits for."""
_ENDS_S = 3.0
"""Longest time for an app to end after its browser, or the server, has gone."""


class BrowserVoice(Protocol):
    """The voice of the browser that shows the app."""

    def say(self, text: str, language: str) -> None:
        """Say this after what is being said."""

    def hush(self) -> None:
        """Stop at once, and drop the queue."""


@runtime_checkable
class Voiced(Protocol):
    """An app that speaks, if it is given a voice."""

    voice: BrowserVoice | None


class ServedDriver(WebDriver):
    """Driver whose other end is `sar_tui.serve.browser_view.BrowserView`. Gives a `Voiced` app the
    browser's voice.
    """

    def __init__(self, app: Any, **how: Any) -> None:
        super().__init__(app, **how)
        self._is_exiting = False
        if isinstance(app, Voiced):
            app.voice = self

    def start_application_mode(self) -> None:
        super().start_application_mode()
        self._app.call_later(self._app.set_interval, ALIVE_INTERVAL_S, self._show_life)

    def _show_life(self) -> None:
        """Tell the page that the app's loop runs, so that what it shows is up to date."""
        self.write_meta({"type": "alive"})

    def say(self, text: str, language: str) -> None:
        self.write_meta({"type": "say", "text": text, "language": language})

    def hush(self) -> None:
        self.write_meta({"type": "hush"})

    def write(self, data: str) -> None:
        # the browser is gone; the end of the input will end the app
        with contextlib.suppress(OSError):
            super().write(data)

    def write_meta(self, data: dict[str, object]) -> None:
        with contextlib.suppress(OSError):
            super().write_meta(data)

    def on_meta(self, packet_type: str, payload: dict[str, object]) -> None:
        """Exit the app: as by its own key if the browser's tab was closed, else because the browser
        is lost.
        """
        if packet_type == "quit":
            self._exit(is_lost=bool(payload.get("lost")))
        else:
            super().on_meta(packet_type, payload)

    def run_input_thread(self) -> None:
        """Exit the app when its server has ended."""
        super().run_input_thread()
        if not self.exit_event.is_set():
            self._exit(is_lost=True)
            if not self.exit_event.wait(_ENDS_S):
                os._exit(1)

    def _exit(self, *, is_lost: bool) -> None:
        """Exit the app, for the first reason that is given."""
        if not self._is_exiting:
            self._is_exiting = True
            app: Any = self._app
            app.has_lost_terminal = is_lost
            app.call_later(app.exit)

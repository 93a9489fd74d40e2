"""Small app to serve: counts a key, speaks, and writes a file when it starts and ends."""

import os
import sys
from pathlib import Path

from textual import events
from textual.app import App, ComposeResult
from textual.widgets import Static

from sar_tui.tui.web_driver import BrowserVoice


class Tiny(App[None]):
    voice: BrowserVoice | None = None
    presses = 0
    has_lost_terminal = False

    def compose(self) -> ComposeResult:
        yield Static("Tiny is here", id="words")

    def on_mount(self) -> None:
        write_down(f"came {os.getpid()}")

    def on_unmount(self) -> None:
        write_down(f"went {'lost' if self.has_lost_terminal else 'left'}")

    def on_key(self, event: events.Key) -> None:
        if event.key == "s" and self.voice:
            self.voice.say("Muy bien.", "es")
        elif event.key == "f" and self.voice:
            self.voice.say("Très bien.", "fr")
        elif event.key == "h" and self.voice:
            self.voice.hush()
        elif event.key == "a":
            self.presses += 1
            self.query_one(Static).update(f"Pressed {self.presses} times")
        elif event.key == "x":
            self.exit()


def write_down(line: str) -> None:
    with Path(sys.argv[1]).open("a") as diary:
        diary.write(line + "\n")


if __name__ == "__main__":
    Tiny().run()

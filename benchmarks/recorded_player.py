"""The voice, as the program starts it, with a witness of its player: when it was given its last sample, and stopped.

Used as ``python -m benchmarks.recorded_player FILE`` in place of ``sar_tui.outputs.sound.voice``: each time the player
stops, a line with both (ns) is added to the file.
"""

import sys
from collections.abc import Generator
from pathlib import Path
from typing import Any

import miniaudio

from sar_tui.framework.clock import host_now
from sar_tui.outputs.sound import voice


class Witnessed(miniaudio.PlaybackDevice):  # type: ignore[misc]  # miniaudio has no types
    """A playback device that keeps the time of the last samples it was given."""

    file: Path
    last = 0

    def start(self, callback_generator: Any) -> None:
        watched = self._watched(callback_generator)
        next(watched)
        super().start(watched)

    def _watched(self, feed: Generator[Any, int, None]) -> Generator[Any, int, None]:
        frames = yield b""
        while True:
            samples = feed.send(frames)
            if len(samples):
                self.last = host_now()
            frames = yield samples

    def stop(self) -> None:
        super().stop()
        if self.last:
            with self.file.open("a") as file:
                file.write(f"{self.last} {host_now()}\n")


def main() -> None:
    """Speak and sound, watched."""
    Witnessed.file = Path(sys.argv[1])
    miniaudio.PlaybackDevice = Witnessed
    voice.main()


if __name__ == "__main__":
    main()

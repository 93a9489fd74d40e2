"""The program's voice with a player that records when it got its last sample, and when it stopped.

Run ``python -m benchmarks.recorded_player FILE`` in place of ``sar_tui.outputs.sound.voice_main``.
Each time the player stops, a line with both times (ns) is added to the file.
"""

import sys
from collections.abc import Generator
from pathlib import Path
from typing import Any

import miniaudio

from sar_tui.loop.clock import host_now
from sar_tui.outputs.sound import voice_main


class RecordedDevice(miniaudio.PlaybackDevice):  # type: ignore[misc]  # miniaudio has no types
    """A playback device that records the time of its last samples."""

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
    """Run the voice with the recorded player."""
    RecordedDevice.file = Path(sys.argv[1])
    miniaudio.PlaybackDevice = RecordedDevice
    voice_main.main()


if __name__ == "__main__":
    main()

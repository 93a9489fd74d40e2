"""Tone output: short cues made of notes."""

from collections.abc import Callable

from sar_tui.loop.clock import Clock
from sar_tui.model.theme import TONES, Theme
from sar_tui.outputs.output import Output, Report
from sar_tui.outputs.sound.mixer import Sound


class Tones(Output):
    """Plays the theme's tones. ``sound`` is shared with speech; requests are played in order.

    ``started`` is when the first samples are fed to the sound card (they are heard up to 40 ms
    later), ``done`` when the last have left its buffer. Tones are prepared in advance. A tone fails
    without a sound card.
    """

    name = "tones"
    can = frozenset({"tone"})

    def __init__(self, sound: Sound) -> None:
        self._sound = sound

    def open(self, theme: Theme, clock: Clock, report: Callable[[Report], None]) -> None:
        self._sound.join("tone", clock, report)
        super().open(theme, clock, report)

    def apply_theme(self, theme: Theme) -> None:
        super().apply_theme(theme)
        self._sound.get_ready("tone", tones=[theme.notes(name) for name in TONES])

    def tone(self, action: str, name: str) -> None:
        notes = self.theme.notes(name)
        self._sound.tone(action, notes, "" if notes else f"The theme has no tone {name!r}.")

    def stop(self, action: str = "") -> None:
        self._sound.stop("tone", action)

    def close(self) -> None:
        self._sound.leave("tone")

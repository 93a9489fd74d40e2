"""Speech and tone outputs, which share one `Sound`."""

import re
from collections.abc import Callable

from sar_tui.loop.clock import Clock
from sar_tui.model.theme import TONES, Theme
from sar_tui.outputs.output import Output, Report
from sar_tui.outputs.sound.mixer import Sound
from sar_tui.outputs.sound.protocol import Voicing

LONGEST = 4000
"""Characters of the longest utterance; about five minutes."""
_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f]")


class Speech(Output):
    """Speaks with the theme's voice, in its language. ``sound`` is shared with the tones.

    ``started`` is when the first samples of the utterance are fed to the sound card (they are heard
    up to 40 ms later), ``done`` when the last have left its buffer; synthesis comes before
    ``started``. An utterance fails without a speech engine, a voice for the language or a sound
    card, if the voice cannot read the text, and if the engine hangs or crashes. The next utterance
    gets a new engine. After three failures in a row that are not due to the text, speech stays off.
    """

    name = "speech"
    can = frozenset({"say"})

    def __init__(self, sound: Sound) -> None:
        self._sound = sound

    def open(self, theme: Theme, clock: Clock, report: Callable[[Report], None]) -> None:
        self._sound.join("say", clock, report)
        super().open(theme, clock, report)

    def apply_theme(self, theme: Theme) -> None:
        super().apply_theme(theme)
        self._sound.get_ready("say", voicing(theme))

    def say(self, action: str, text: str) -> None:
        text, problem = speakable(text), ""
        if not text:
            problem = "There is nothing to say: the text is empty."
        elif len(text) > LONGEST:
            text, problem = (
                "",
                f"The text is too long to be spoken: {len(text)} characters, of at most {LONGEST}.",
            )
        self._sound.say(action, text, voicing(self.theme), problem)

    def stop(self, action: str = "") -> None:
        self._sound.stop("say", action)

    def close(self) -> None:
        self._sound.leave("say")


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


def voicing(theme: Theme) -> Voicing:
    """Return the voice of a theme in its language."""
    voice, language = theme.voice, theme.language
    return Voicing(
        language.lower().replace("_", "-"),
        voice.names.get(language, ""),
        voice.rate_in(language),
        voice.volume,
    )


def speakable(text: str) -> str:
    """Return a text without control characters and lone surrogates."""
    return " ".join(_CONTROL.sub(" ", text.encode("utf-8", "replace").decode()).split())

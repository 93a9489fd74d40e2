"""Speech and sound: an engine, voices for the languages that ship, a sound card."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from sar_tui.cli.doctor.finding import Finding

if TYPE_CHECKING:
    from sar_tui.outputs.sound.protocol import Examined

_PATIENCE_S = 2.0
"""Time to wait for the child process, which answers within half a second."""
_LANGUAGES = {"en": "English", "es": "Spanish"}
_NO_WORDS = "Without it, the agent's words are on the screen only."
_NO_SOUND = (
    "Without it nothing is heard; `--speech file:FOLDER` writes what the agent says to WAV files."
)


def examine_voice(program: Sequence[str] = (), backends: Sequence[str] = ()) -> "Examined":
    """Ask the child process that would speak and play what it can do. Raises SoundError if it does
    not answer.
    """
    from sar_tui.outputs.sound.child import VOICE
    from sar_tui.outputs.sound.mixer import examine

    return examine(program or VOICE, backends, _PATIENCE_S)


def speech_engine(examined: "Callable[[], Examined]") -> Finding:
    """Check that there is a speech engine with a voice for each language that ships."""
    found = _answer("Speech", examined)
    if isinstance(found, Finding):
        return found
    if found.no_voices:
        return _care("Speech", found.no_voices, _NO_WORDS)
    missing = [
        name
        for code, name in _LANGUAGES.items()
        if not any(voice.speaks(code) for voice in found.voices)
    ]
    count = f"{len(found.voices)} voice{'' if len(found.voices) == 1 else 's'}"
    if missing:
        advice = "Add such a voice in the system's speech settings, or install espeak-ng."
        return Finding("Speech", "care", f"{count}, but none for {' or '.join(missing)}", advice)
    return Finding("Speech", "ok", f"{count}, including {' and '.join(_LANGUAGES.values())}")


def sound_card(examined: "Callable[[], Examined]") -> Finding:
    """Check that there is a working sound card."""
    found = _answer("Sound card", examined)
    if isinstance(found, Finding):
        return found
    if found.no_card:
        return _care("Sound card", found.no_card, _NO_SOUND)
    return Finding("Sound card", "ok", f"there is one, by {found.card}")


def _answer(name: str, examined: "Callable[[], Examined]") -> "Examined | Finding":
    """Return what the child process answered, or the finding that it did not."""
    from sar_tui.outputs.sound.protocol import SoundError

    try:
        return examined()
    except SoundError as error:
        return Finding(
            name, "care", str(error), f"Restart the computer, and try again. {_NO_WORDS}"
        )


def _care(name: str, problem: str, without: str) -> Finding:
    """Make a finding of a problem whose text gives advice after a colon."""
    found, _, advice = problem.rpartition(": ")
    return Finding(name, "care", found, f"{advice[:1].upper()}{advice[1:]} {without}")

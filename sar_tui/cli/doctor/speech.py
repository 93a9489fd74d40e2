"""What `sar-tui doctor` finds of speech and sound: an engine, voices for the languages that ship, a sound card."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from sar_tui.cli.doctor.check import Finding

if TYPE_CHECKING:
    from sar_tui.outputs.sound.protocol import Examined

_PATIENCE_S = 2.0
"""How long the child process is waited for; it answers within half a second."""
_LANGUAGES = {"en": "English", "es": "Spanish"}
_NO_WORDS = "Without it, the agent's words are on the screen only."
_NO_SOUND = "Without it nothing is heard; `--speech file:FOLDER` writes what the agent says to WAV files."


def speech_engine(program: Sequence[str] = ()) -> Finding:
    """Whether there is a speech engine, and a voice in it for each language that ships."""
    found = _examined("Speech", program)
    if isinstance(found, Finding):
        return found
    if found.no_voices:
        return _care("Speech", found.no_voices, _NO_WORDS)
    missing = [name for code, name in _LANGUAGES.items() if not any(voice.speaks(code) for voice in found.voices)]
    count = f"{len(found.voices)} voice{'' if len(found.voices) == 1 else 's'}"
    if missing:
        mend = "Add such a voice in the system's speech settings, or install espeak-ng."
        return Finding("Speech", "care", f"{count}, but none for {' or '.join(missing)}", mend)
    return Finding("Speech", "ok", f"{count}, for {' and '.join(_LANGUAGES.values())} too")


def sound_card(program: Sequence[str] = (), backends: Sequence[str] = ()) -> Finding:
    """Whether there is a sound card that takes sound."""
    found = _examined("Sound card", program, backends)
    if isinstance(found, Finding):
        return found
    if found.no_card:
        return _care("Sound card", found.no_card, _NO_SOUND)
    return Finding("Sound card", "ok", f"there is one, by {found.card}")


def _examined(name: str, program: Sequence[str], backends: Sequence[str] = ()) -> "Examined | Finding":
    """What the child process that would use them finds."""
    from sar_tui.outputs.sound.child import PROGRAM
    from sar_tui.outputs.sound.mixer import examine
    from sar_tui.outputs.sound.protocol import SoundError

    try:
        return examine(program or PROGRAM, backends, _PATIENCE_S)
    except SoundError as error:
        return Finding(name, "care", str(error), f"Restart the computer, and try again. {_NO_WORDS}")


def _care(name: str, problem: str, without: str) -> Finding:
    """A problem that tells its own cure, after a colon."""
    found, _, mend = problem.rpartition(": ")
    return Finding(name, "care", found, f"{mend[:1].upper()}{mend[1:]} {without}")

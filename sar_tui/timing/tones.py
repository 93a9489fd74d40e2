"""The delays of tones of prompts on this computer, as far as software can tell."""

import queue
import time
from collections.abc import Callable, Sequence

import msgspec

from sar_tui.loop.clock import host_now
from sar_tui.model.tone import Tone
from sar_tui.model.units import MS
from sar_tui.outputs.prompt_tones import cue, warm
from sar_tui.outputs.sound.child import TONES, SoundProgram
from sar_tui.outputs.sound.protocol import (
    Ended,
    Examine,
    Examined,
    Reckon,
    Reply,
    Setup,
    SoundError,
    Started,
)
from sar_tui.timing.verdict import ErrorStatistics, error_statistics

AHEAD_MS = 150
"""Time from the request of a planned tone to its onset: like that of a frame that follows
another.
"""
TONE = Tone(880, 30)
_PAUSE_S = 0.25
_PATIENCE_S = 10.0
_SILENT = "The program that plays the tones of prompts gave no answer."


class ToneDelays(msgspec.Struct, frozen=True):
    """Delays of tones, in ms.

    Args:
        card: name of the sound system.
        buffer_ms: time that a sample waits in the card's buffer, which is part of all delays.
        at_once: from the request of a tone to its onset.
        planned: the onset of a tone that was requested in advance, as reckoned after it, minus the
            time it was due.
    """

    card: str
    buffer_ms: float
    at_once: ErrorStatistics
    planned: ErrorStatistics


def measure_tones(
    count: int, backends: Sequence[str] = (), on_tone: Callable[[], object] = lambda: None
) -> ToneDelays:
    """Play tones, and return their delays.

    Args:
        count: number of tones of each kind.
        backends: the sound systems to try, by miniaudio's names; all real ones if empty.
        on_tone: called after each tone.

    Raises:
        SoundError: tones cannot be played; it says why, and what to do.
    """
    replies: queue.SimpleQueue[Reply | None] = queue.SimpleQueue()
    program = SoundProgram(TONES, Setup(backends=tuple(backends)), replies.put)
    try:
        program.prepare("tones", warm([TONE]))
        program.send(Examine())
        card = replies.get(timeout=_PATIENCE_S)
        if not isinstance(card, Examined):
            raise SoundError(_SILENT)
        if card.no_card:
            raise SoundError(card.no_card)
        at_once, planned = [], []
        for number in range(2 * count):
            due = host_now() + (AHEAD_MS * MS if number % 2 else 0)
            program.send(cue(number + 1, TONE, due))
            onset = _next(replies)
            time.sleep(_PAUSE_S)
            if number % 2:
                program.send(Reckon(number + 1))
                planned.append((_next(replies) - due) / MS)
            else:
                at_once.append((onset - due) / MS)
            on_tone()
    except queue.Empty:
        raise SoundError(_SILENT) from None
    finally:
        program.end()
    return ToneDelays(
        card.card, card.buffer_ms, error_statistics(at_once), error_statistics(planned)
    )


def _next(replies: "queue.SimpleQueue[Reply | None]") -> int:
    """Return the next onset (ns). Raises SoundError if the tone is not heard."""
    match replies.get(timeout=_PATIENCE_S):
        case Started(_, at):
            return at
        case Ended(detail=detail):
            raise SoundError(detail)
        case _:
            raise SoundError(_SILENT)

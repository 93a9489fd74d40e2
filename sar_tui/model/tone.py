"""Tones that belong to a prompt."""

import math

import msgspec

LOWEST_HZ, HIGHEST_HZ = 20, 10_000
LONGEST_MS = 10_000
_MOST = 1000


class Tone(msgspec.Struct, frozen=True, omit_defaults=True):
    """A tone of a prompt, or of a frame of it: a sine that swells and fades within 8 ms.

    Args:
        hz: its pitch.
        ms: its duration.
        times: how often it sounds.
        every_ms: from the onset of one to that of the next, if it sounds more than once.
    """

    hz: float
    ms: float
    times: int = 1
    every_ms: float = 0.0

    @property
    def offsets_ms(self) -> tuple[float, ...]:
        """Time of each onset after the first, beginning with 0."""
        return tuple(number * self.every_ms for number in range(self.times))


def problem(tone: Tone) -> str:
    """Return a sentence that says why a tone cannot be played; empty if it can."""
    if not isinstance(tone, Tone):
        return f"A tone is a Tone, not {tone!r:.80}."
    return _type_problem(tone) or _range_problem(tone)


def _type_problem(tone: Tone) -> str:
    for name in ("hz", "ms", "every_ms"):
        if not isinstance(value := getattr(tone, name), int | float):
            return f"The {name} of a tone is a number, not {value!r:.80}."
    if not isinstance(tone.times, int):
        return f"The times of a tone are a whole number, not {tone.times!r:.80}."
    return ""


def _range_problem(tone: Tone) -> str:
    if not LOWEST_HZ <= tone.hz <= HIGHEST_HZ:
        return f"A tone has {tone.hz} Hz; it can have {LOWEST_HZ} to {HIGHEST_HZ}."
    if not 1 <= tone.ms <= LONGEST_MS:
        return f"A tone lasts {tone.ms} ms; it can last 1 to {LONGEST_MS}."
    if not 1 <= tone.times <= _MOST:
        return f"A tone sounds {tone.times} times; it can sound 1 to {_MOST} times."
    if tone.times > 1 and not tone.ms <= tone.every_ms < math.inf:
        return (
            f"A tone of {tone.ms} ms is repeated every {tone.every_ms} ms: its every_ms must "
            "be at least its ms."
        )
    return ""

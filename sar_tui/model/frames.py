"""Frames of a prompt: what stands for how long, and the times at which they are due."""

import math
from collections.abc import Sequence
from itertools import pairwise

import msgspec
from msgspec.structs import replace

from sar_tui.model import tone
from sar_tui.model.tone import Tone
from sar_tui.model.units import MS

SHORTEST_MS = 10
"""No terminal draws a frame that stands for less."""
LEAD = 12 * MS
"""A frame is requested this long before its time: drawing takes 2 to 5 ms, longer on a busy
machine. It then waits.
"""
LATE = 10 * MS
"""A trial with a frame that is seen later than this after its time is flagged."""
_MOST = 1000


class Frame(msgspec.Struct, frozen=True, omit_defaults=True):
    """A part of a prompt that stands for a time, until the next one replaces it.

    Args:
        glyph: shown very large; empty for an empty screen.
        ms: how long it stands, from onset to onset; None: until the trial ends, for the last frame
            only.
        text: the plain line below, as in `trial_types.Stimulus`; defaults to ``glyph``.
        hint: shown under it.
        halves: the contents of the left and right half of the screen, instead of ``glyph``.
        colour: as in `trial_types.Stimulus`.
        picture: as in `trial_types.Stimulus`, instead of ``glyph``; it needs a ``text``.
        timed: True if reaction time and time-out count from its onset; by default they count from
            the first frame.
        awaited: True if responses are awaited from its onset on; by default they are from the first
            frame on.
        tone: sounds from its onset on.
    """

    glyph: str = ""
    ms: float | None = None
    text: str = ""
    hint: str = ""
    halves: tuple[str, ...] = ()
    colour: str = ""
    picture: str = ""
    timed: bool = False
    awaited: bool = False
    tone: Tone | None = None

    @property
    def line(self) -> str:
        """The plain line."""
        return self.text or self.glyph or " ".join(self.halves)


def complete(frames: tuple[Frame, ...]) -> tuple[Frame, ...]:
    """Return frames of which the last stands until the trial ends: an empty one follows one that
    ends before.
    """
    if not frames or frames[-1].ms is None:
        return frames
    return (*frames, Frame()) if frames[-1].line else (*frames[:-1], replace(frames[-1], ms=None))


def timed(frames: Sequence[Frame]) -> int:
    """Return the place of the frame from which the reaction time counts."""
    return next((place for place, frame in enumerate(frames) if frame.timed), 0)


def awaited(frames: Sequence[Frame]) -> int:
    """Return the place of the frame from which responses are awaited."""
    return next((place for place, frame in enumerate(frames) if frame.awaited), 0)


def planned(frames: Sequence[Frame], place: int) -> int:
    """Return the time from the onset of the first frame to that of another, in ns, as declared."""
    return round(sum(frame.ms or 0.0 for frame in frames[:place]) * MS)


def never_shown(frames: Sequence[Frame], timeout_ms: float) -> int | None:
    """Return the place of the first frame that comes after the time for the response is over; None
    if none does.
    """
    over = planned(frames, timed(frames)) + round(timeout_ms * MS)
    return next((place for place in range(1, len(frames)) if planned(frames, place) >= over), None)


def problem(frames: Sequence[Frame]) -> str:
    """Return a sentence that says why frames cannot be shown; empty if they can."""
    if not isinstance(frames, tuple) or not all(isinstance(frame, Frame) for frame in frames):
        return f"The frames of a prompt are a tuple of Frame, not {frames!r:.80}."
    if len(frames) > _MOST:
        return f"A prompt has {len(frames)} frames; it can have {_MOST}."
    for name in ("timed", "awaited"):
        if sum(getattr(frame, name) for frame in frames) > 1:
            return f"More than one frame is {name}."
    if any(frame.picture and not frame.text for frame in frames):
        return "A frame with a picture has no text."
    if any(not before.line and not frame.line for before, frame in pairwise(frames)):
        return "Two empty frames follow each other: make them one, or give them a glyph such as ·."
    problems = [
        _duration_problem(frame.ms, place, len(frames)) for place, frame in enumerate(frames)
    ]
    problems += [tone.problem(frame.tone) for frame in frames if frame.tone is not None]
    return next(filter(None, problems), "")


def _duration_problem(ms: float | None, place: int, count: int) -> str:
    if ms is None:
        missing = (
            f"Frame {place + 1} of {count} has no ms: only the last one may stand until the "
            "trial ends."
        )
        return missing if place + 1 < count else ""
    if not isinstance(ms, int | float):
        return f"The ms of frame {place + 1} is a number, not {ms!r:.80}."
    return (
        ""
        if SHORTEST_MS <= ms < math.inf
        else f"Frame {place + 1} has {ms} ms; it needs at least {SHORTEST_MS}."
    )

"""A marker, the names that markers have, and the text that is sent."""

from typing import NamedTuple, Protocol

import msgspec

CODES: dict[str, int] = {
    "session_start": 1,
    "session_end": 2,
    "attempt_start": 3,
    "attempt_end": 4,
    "cue": 5,
    "sync_flash": 8,
    "sync_tone": 9,
    "prompt_onset": 10,
    "prompt_cancelled": 11,
    "frame_onset": 12,
    "prompt_tone": 13,
    "response": 20,
    "miss": 21,
    "movement_start": 22,
    "movement_end": 23,
    "trial_feedback": 24,
    "utterance_start": 30,
    "utterance_end": 31,
    "text_start": 32,
    "text_end": 33,
    "gesture_start": 34,
    "gesture_end": 35,
    "tone_start": 36,
    "tone_end": 37,
    "gaze_start": 38,
    "gaze_end": 39,
    "decision": 40,
    "remark": 41,
    "command": 42,
    "mark": 43,
    "note": 44,
    "level": 45,
    "test": 255,
}
"""Every event that has a marker, with its byte on a trigger line. A name or byte, once released,
never changes.
"""

Fields = dict[str, str | int | bool]


class Marker(NamedTuple):
    """An event at a time ``ns`` of the session's clock. ``fields``: what else is sent (see
    docs).
    """

    event: str
    ns: int
    fields: Fields = {}

    @property
    def text(self) -> str:
        """One line of JSON: ``event``, ``ns``, and the fields."""
        return msgspec.json.encode({"event": self.event, "ns": self.ns, **self.fields}).decode()


class MarkerError(Exception):
    """Markers cannot be sent as asked; the message is one or two clear sentences."""


class Destination(Protocol):
    """A place to which markers are sent. All methods but ``check`` are called on one thread of its
    own.
    """

    address: str
    """As it was given; it names the destination in the log."""

    def check(self) -> None:
        """Raise MarkerError if nothing can be sent there now, before a session starts."""
        ...

    def open(self, session: str, task: str) -> str:
        """Open it for a session. Return a fact for the log, or an empty text. Raises
        MarkerError.
        """
        ...

    def send(self, marker: Marker) -> bool:
        """Send a marker. Return False if it is known that nobody received it. Raises
        MarkerError.
        """
        ...

    def close(self) -> str:
        """Release it. Return a fact for the log, or an empty text. May be called twice."""
        ...

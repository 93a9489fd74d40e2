"""What every message is, and the words that several of them choose among."""

from typing import Literal

import msgspec

Valence = Literal["positive", "neutral", "negative"]
Degree = Literal["slight", "clear", "strong"]
Schedule = Literal["every", "faded", "bandwidth", "summary", "request", "none"]
Form = Literal["qualitative", "quantitative", "both"]
Reference = Literal["last attempt", "best attempt", "session's mean", "goal"]
Kind = Literal["greeting", "instruction", "encouragement", "feedback", "rest", "goodbye"]
Policy = Literal["queue", "interrupt", "drop"]
Deed = Literal["say", "show", "gesture", "gaze", "tone"]
DeedState = Literal["queued", "started", "done", "aborted", "failed"]
Outcome = Literal["success", "failure"]
Json = dict[str, str | int | float | bool | None]
"""What a task may add to a trial's row."""
SensorState = Literal["attached", "detached", "error", "gap", "saturated", "stalled", "flowing", "ended"]


class Message(msgspec.Struct, frozen=True, kw_only=True):
    """The base of all messages. ``seat`` is who caused it, or whom it concerns."""

    seat: str = "A"

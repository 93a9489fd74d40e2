"""What every message is, and the words that several of them choose among."""

from typing import Literal

import msgspec

__all__ = [
    "ActionPart",
    "ControlledKind",
    "Degree",
    "Form",
    "Ground",
    "Json",
    "Kind",
    "Message",
    "Mode",
    "Outcome",
    "PartState",
    "Policy",
    "Reference",
    "Role",
    "SensorState",
    "Valence",
]

Valence = Literal["positive", "neutral", "negative"]
Degree = Literal["slight", "clear", "strong"]
Form = Literal["qualitative", "quantitative", "both"]
Reference = Literal["last attempt", "best attempt", "session's mean", "goal"]
Kind = Literal[
    "greeting",
    "instruction",
    "encouragement",
    "feedback",
    "rest",
    "goodbye",
    "filler",
    "gesture",
    "difficulty",
    "remark",
]
"""``filler``: covers a wait; ``gesture``: one that is ruled on apart from its words; ``remark``: an operator's own."""
ControlledKind = Literal["feedback", "encouragement", "instruction", "gesture", "difficulty"]
"""What an operator may rule over, each in a mode of its own. Greeting and goodbye go with instructions, rest with
encouragement."""
Mode = Literal["autonomous", "veto", "approve", "manual"]
"""``autonomous``: acts; ``veto``: acts after a while unless stopped; ``approve``: acts only on a key; ``manual``: only
the operator acts."""
Role = Literal["operator", "observer"]
Ground = Literal["mode", "operator", "deadline", "no operator"]
"""On what ground a proposal was decided: its kind is the agent's own; an operator did; nobody did in time; nobody was
there."""
Policy = Literal["queue", "interrupt", "drop"]
ActionPart = Literal["say", "show", "gesture", "gaze", "tone"]
PartState = Literal["queued", "started", "done", "aborted", "failed"]
Outcome = Literal["success", "failure"]
Json = dict[str, str | int | float | bool | None]
"""What a task may add to a trial's row."""
SensorState = Literal["attached", "detached", "error", "gap", "saturated", "stalled", "flowing", "ended"]


class Message(msgspec.Struct, frozen=True, kw_only=True):
    """The base of all messages. ``seat`` is who caused it, or whom it concerns."""

    seat: str = "A"

"""Base class of the messages, and the sets of values that several messages share."""

from typing import Literal

import msgspec

from sar_tui.model.trial_types import Json

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
"""``filler`` covers a wait; ``gesture`` is decided on apart from its words; ``remark`` is an
operator's own.
"""
ControlledKind = Literal["feedback", "encouragement", "instruction", "gesture", "difficulty"]
"""Kinds of action that an operator controls, each with its own mode. Greeting and goodbye count as
instruction, rest as encouragement.
"""
Mode = Literal["autonomous", "veto", "approve", "manual"]
"""``autonomous``: the agent acts; ``veto``: it acts after a while unless stopped; ``approve``: it
acts if the operator approves; ``manual``: only the operator acts.
"""
Role = Literal["operator", "observer"]
Ground = Literal["mode", "operator", "deadline", "no operator"]
"""Why a proposal was decided as it was: its kind is autonomous; an operator decided; the deadline
passed; there was no operator.
"""
Policy = Literal["queue", "interrupt", "drop"]
ActionPart = Literal["say", "show", "gesture", "gaze", "tone"]
PartState = Literal["queued", "started", "done", "aborted", "failed"]
Outcome = Literal["success", "failure", "none"]
"""``none``: of an attempt without goal, or with unsure trials only."""
SensorState = Literal[
    "attached", "detached", "error", "gap", "saturated", "stalled", "flowing", "ended"
]


class Message(msgspec.Struct, frozen=True, kw_only=True):
    """Base of all messages. ``seat``: the participant who caused it, or whom it concerns."""

    seat: str = "A"

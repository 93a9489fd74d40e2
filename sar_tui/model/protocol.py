"""The protocol of a Wizard-of-Oz study: what the operator does, and when."""

from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from sar_tui.model.visible_text import obeyed

Moment = Literal["start", "attempt", "after attempt", "pause", "end"]
Measure = Literal[
    "accuracy", "metric", "success", "timeouts", "level", "pain", "tiredness", "effort"
]
Comparison = Literal["<", "<=", "=", ">=", ">"]
ANSWERS: frozenset[Measure] = frozenset(("pain", "tiredness", "effort"))
"""Measures that are answers to the questions of these names between attempts."""


class ProtocolStep(msgspec.Struct, frozen=True):
    """Something to do at a moment. ``attempt``: its number, counted with practice."""

    at: Moment
    do: str
    attempt: int = 0


class Condition(msgspec.Struct, frozen=True):
    """A comparison of a measure, as ``accuracy < 60 % 2 times in a row``.

    Attributes:
        value: in percent for ``accuracy``; 1 and 0 for a ``success`` of yes and no.
        unit: of a value of the metric; empty if none was written.
        times: how often it must hold.
        in_a_row: these times must follow each other.
    """

    measure: Measure
    comparison: Comparison
    value: float
    unit: str = ""
    times: Annotated[int, Meta(ge=1)] = 1
    in_a_row: bool = False


class ProtocolRule(msgspec.Struct, frozen=True):
    """Something to do whenever a condition holds. ``text``: the condition as it was written."""

    when: Condition
    text: str
    do: str


class Reason(msgspec.Struct, frozen=True):
    """A reason for a veto or an edit, and the digit that gives it."""

    code: Annotated[int, Meta(ge=0, le=9)]
    text: str


BY_PROTOCOL = "protocol says so"
"""The reason by which a veto or an edit belongs to the protocol."""
REASONS = (
    Reason(1, "wrong moment"),
    Reason(2, "wrong content"),
    Reason(3, "participant upset"),
    Reason(4, "technical"),
    Reason(5, BY_PROTOCOL),
    Reason(9, "other"),
)
"""Reasons, unless a protocol names others."""


class WizardProtocol(msgspec.Struct, frozen=True):
    """A protocol as it was read from a file.

    Attributes:
        hash: of the file (SHA-256, hexadecimal).
        late_after_s: time from when something is due until it counts as done late.
        steps, rules: in the order of the file.
        phrases: what ``say phrase 1``, … say.
    """

    name: str
    version: int
    hash: str
    late_after_s: float = 15.0
    steps: tuple[ProtocolStep, ...] = ()
    rules: tuple[ProtocolRule, ...] = ()
    phrases: tuple[str, ...] = ()
    reasons: tuple[Reason, ...] = REASONS

    @property
    def is_showable(self) -> bool:
        """True if no text has a character that a terminal would obey."""
        texts = (
            self.name,
            self.hash,
            *self.phrases,
            *(step.do for step in self.steps),
            *(rule.do for rule in self.rules),
            *(rule.text for rule in self.rules),
            *(reason.text for reason in self.reasons),
        )
        return not any(map(obeyed, texts))

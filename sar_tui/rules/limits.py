"""Limits of a session and of a day, and rests that must be taken. Pure."""

from collections.abc import Mapping

import msgspec

from sar_tui.rules.parameters import TaskParameters

OF_A_DAY = ("minutes_a_day", "attempts_a_day", "repetitions_a_day")
"""The settings that limit a day."""


class Dose(msgspec.Struct, frozen=True):
    """Amount of practice: minutes in attempts, attempts without practice, and repetitions with
    practice.
    """

    minutes: float = 0.0
    attempts: int = 0
    repetitions: int = 0

    @classmethod
    def of(cls, stored: Mapping[str, float]) -> "Dose":
        """Return the dose that a message holds as ``as_dict`` wrote it."""
        return cls(
            minutes=stored.get("minutes", 0.0),
            attempts=int(stored.get("attempts", 0)),
            repetitions=int(stored.get("repetitions", 0)),
        )

    def as_dict(self) -> dict[str, float]:
        """Return the dose as a mapping."""
        return {"minutes": self.minutes, "attempts": self.attempts, "repetitions": self.repetitions}

    def plus(self, *, minutes: float, repetitions: int, is_practice: bool) -> "Dose":
        """Return the dose after one more attempt."""
        return Dose(
            self.minutes + minutes,
            self.attempts + (not is_practice),
            self.repetitions + repetitions,
        )


def limits_day(settings: TaskParameters) -> bool:
    """Return True if the settings limit a day."""
    return any(getattr(settings, name) for name in OF_A_DAY)


def reached_of_day(settings: TaskParameters, done: Dose) -> str:
    """Return the name of the first setting whose limit of a day is reached; empty for none."""
    for name, amount in zip(OF_A_DAY, (done.minutes, done.attempts, done.repetitions), strict=True):
        if 0 < getattr(settings, name) <= amount:
            return name
    return ""


def is_session_over(settings: TaskParameters, minutes: float) -> bool:
    """Return True if a session has lasted as long as it may."""
    return 0 < settings.session_minutes <= minutes


def is_rest_due(settings: TaskParameters, attempts: int, minutes: float) -> bool:
    """Return True if the participant must rest, after so many attempts and minutes since the last
    such rest.
    """
    return (
        0 < settings.rest_after_attempts <= attempts or 0 < settings.rest_after_minutes <= minutes
    )

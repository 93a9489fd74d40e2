"""Settings that plan and limit how much is done in a session and in a day."""

from typing import Annotated

from sar_tui.rules.declaration import Settings, meta


class LimitSettings(Settings, frozen=True, kw_only=True):
    """Plan of a day, limits of a session and of a day, and forced rests. An attempt begun is always
    finished.
    """

    session_minutes: Annotated[
        int,
        meta(
            "Session length",
            "min",
            "After this time, rests and pauses included, the session ends with the attempt. 0: no "
            "limit.",
            ge=0,
            le=480,
            group="Limits",
            personal=True,
        ),
    ] = 0
    minutes_a_day: Annotated[
        int,
        meta(
            "Minutes a day",
            "min",
            "Time in attempts of this task on a day, without the rests between them. 0: no limit.",
            ge=0,
            le=480,
            group="Limits",
            personal=True,
        ),
    ] = 0
    attempts_a_day: Annotated[
        int,
        meta(
            "Attempts a day",
            help="Attempts of this task on a day, without practice. 0: no limit.",
            ge=0,
            le=1000,
            group="Limits",
            personal=True,
        ),
    ] = 0
    repetitions_a_day: Annotated[
        int,
        meta(
            "Repetitions a day",
            help="Prompts or reaches of this task on a day, with practice. 0: no limit.",
            ge=0,
            le=10_000,
            group="Limits",
            personal=True,
        ),
    ] = 0
    planned_attempts_a_day: Annotated[
        int,
        meta(
            "Planned a day",
            help="Attempts of this task planned for a day, in one session or several: progress "
            "compares what was done "
            "with it. 0: the attempts of the sessions begun.",
            ge=0,
            le=1000,
            group="Limits",
            personal=True,
        ),
    ] = 0
    days_between_visits: Annotated[
        int,
        meta(
            "Days between visits",
            help="So many days after the last session of this task the participant is marked on "
            "the first screen: a "
            "visit is due. 0: never.",
            ge=0,
            le=365,
            group="Limits",
            personal=True,
        ),
    ] = 0
    rest_after_attempts: Annotated[
        int,
        meta(
            "Must rest (attempts)",
            "attempts",
            "A rest that Enter cannot skip follows after so many attempts, practice included. 0: "
            "none.",
            ge=0,
            le=200,
            group="Limits",
            personal=True,
        ),
    ] = 0
    rest_after_minutes: Annotated[
        int,
        meta(
            "Must rest (minutes)",
            "min",
            "The same rest follows the attempt in which so much time has passed since the last "
            "one. 0: none.",
            ge=0,
            le=480,
            group="Limits",
            personal=True,
        ),
    ] = 0
    rest_seconds: Annotated[
        int,
        meta(
            "Length of that rest",
            "s",
            "The participant may rest longer; a therapist can end it from the pause menu.",
            ge=5,
            le=3600,
            group="Limits",
            personal=True,
        ),
    ] = 60

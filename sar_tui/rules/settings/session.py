"""Settings of the session as a whole."""

from typing import Annotated

from sar_tui.rules.declaration import Settings, meta


class SessionSettings(Settings, frozen=True, kw_only=True):
    """Number of attempts, rest and language."""

    attempts: Annotated[
        int,
        meta("Attempts", help="Number of attempts in a session.", ge=1, le=200, group="Session"),
    ] = 20
    practice_attempts: Annotated[
        int,
        meta(
            "Practice attempts",
            help="Attempts before the first that counts. They do not change the level.",
            ge=0,
            le=20,
            group="Session",
        ),
    ] = 0
    rest_every: Annotated[
        int,
        meta(
            "Rest reminder every",
            "attempts",
            "The agent suggests a rest; 0: never.",
            ge=0,
            le=200,
            group="Session",
        ),
    ] = 10
    language: Annotated[
        str,
        meta(
            "Language",
            help="Language of all that the participant sees and hears: en, es, or another of the "
            "theme.",
            takes="a code in lower case, such as en, es or es-mx",
            pattern="^[a-z]{2,3}(-[a-z]{2,4})?$",
            group="Session",
            personal=True,
        ),
    ] = "en"

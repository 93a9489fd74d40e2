"""Settings of the questions about pain and tiredness."""

from typing import Annotated

from sar_tui.rules.declaration import Settings, meta
from sar_tui.rules.wellbeing import HIGHEST, PainLimits

_DEFAULT = PainLimits()


class WellbeingSettings(Settings, frozen=True, kw_only=True):
    """Questions about pain and tiredness, and the limits of pain."""

    ask_wellbeing: Annotated[
        bool,
        meta(
            "Ask about pain",
            help="Before and after a session, ask how much pain there is, where, and how tired "
            "the participant is.",
            group="Session",
            personal=True,
        ),
    ] = False
    pain_limit: Annotated[
        int,
        meta(
            "Pain limit",
            ge=0,
            le=HIGHEST,
            help="With more pain than this, of 10, the participant is advised not to train, and "
            "you are told.",
            group="Session",
            personal=True,
        ),
    ] = _DEFAULT.highest
    pain_rise: Annotated[
        int,
        meta(
            "Pain rise",
            ge=1,
            le=HIGHEST,
            help="So much more pain than before the session counts as too much, too.",
            group="Session",
            personal=True,
        ),
    ] = _DEFAULT.rise


def pain_limits(settings: WellbeingSettings) -> PainLimits:
    """Return the limits of pain that are set."""
    return PainLimits(settings.pain_limit, settings.pain_rise)

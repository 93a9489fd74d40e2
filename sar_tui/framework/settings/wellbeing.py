"""Settings of the questions about pain and tiredness."""

from typing import Annotated

from sar_tui.framework.declaration import Settings, meta


class WellbeingSettings(Settings, frozen=True, kw_only=True):
    """Questions about pain and tiredness."""

    ask_wellbeing: Annotated[
        bool,
        meta(
            "Ask about pain",
            help="Before and after a session, ask how much pain there is, where, and how tired the participant is.",
            group="Session",
        ),
    ] = False

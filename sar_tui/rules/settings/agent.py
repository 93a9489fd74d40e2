"""Settings of the agent and its outputs."""

from typing import Annotated

from sar_tui.rules.declaration import Settings, meta


class AgentSettings(Settings, frozen=True, kw_only=True):
    """Encouragement, outputs and speech."""

    encouragement: Annotated[
        bool,
        meta(
            "Encouragement",
            help="A kind word before an attempt that is harder than the earlier ones.",
            group="Agent",
        ),
    ] = True
    outputs: Annotated[
        tuple[str, ...],
        meta(
            "Outputs",
            help="Where the agent appears, speaks and moves: screen, speech, tones, servo, ros://HOST.",
            max_length=8,
            group="Agent",
            personal=True,
        ),
    ] = ("screen",)
    speech: Annotated[
        str,
        meta(
            "Speech goes to",
            help="sound: the loudspeaker. file:FOLDER: a WAV file for each utterance.",
            max_length=500,
            group="Agent",
            personal=True,
        ),
    ] = "sound"

"""How the agent reaches the participant: the options that ``run`` and ``simulate`` share, as settings."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.setting import parameters

if TYPE_CHECKING:
    from sar_tui.framework.parameters import TaskParameters
    from sar_tui.framework.task import Task

Outputs = Annotated[
    str | None,
    typer.Option(
        "--outputs",
        metavar="NAME,NAME",
        show_default=False,
        help="What the agent speaks and moves with: screen, speech, tones, servo, ros://HOST; as --set outputs=….",
    ),
]
Speech = Annotated[
    str | None,
    typer.Option(
        "--speech",
        metavar="WHERE",
        show_default=False,
        help="The agent speaks: sound, from the loudspeaker; file:DIR, a WAV for each utterance.",
    ),
]
Language = Annotated[
    str | None,
    typer.Option(
        "--language", metavar="CODE", show_default=False, help="Of all the participant sees and hears: en, es."
    ),
]


def agent_parameters(
    kind: "type[Task]",
    values: Mapping[str, object],
    outputs: str | None,
    speech: str | None,
    language: str | None,
) -> "TaskParameters":
    """A task's checked parameters, with what the options say of the agent put over them.

    Who says where speech goes wants it to be heard: it is among the outputs then.

    Raises:
        Refused: something cannot be set so.
    """
    options = {"outputs": outputs, "speech": speech, "language": language}
    given = {**values, **{name: value for name, value in options.items() if value is not None}}
    built = parameters(kind, given)
    if speech is not None and "speech" not in built.outputs:
        built = parameters(kind, {**given, "outputs": [*built.outputs, "speech"]})
    return built

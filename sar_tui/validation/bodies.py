"""Bodies of the agent for validations: outputs that do nothing, and report each part as done at
once.
"""

from typing import get_args

from sar_tui.model.messages import ActionPart
from sar_tui.outputs.output import Output, Report

PARTS: tuple[ActionPart, ...] = get_args(ActionPart)


class Body(Output):
    """A body that performs some parts of actions.

    Attributes:
        performed: its parts, each with the id of the action.
    """

    def __init__(self, name: str, can: tuple[ActionPart, ...]) -> None:
        self.name = name
        self.can = frozenset(can)
        self.performed: list[tuple[str, ActionPart]] = []

    def say(self, action: str, text: str) -> None:
        self._perform(action, "say")

    def show(self, action: str, text: str, face: str) -> None:
        self._perform(action, "show")

    def gesture(self, action: str, name: str) -> None:
        self._perform(action, "gesture")

    def gaze(self, action: str, where: str) -> None:
        self._perform(action, "gaze")

    def tone(self, action: str, name: str) -> None:
        self._perform(action, "tone")

    def _perform(self, action: str, part: ActionPart) -> None:
        self.performed.append((action, part))
        self._send_report(Report(action, part, "done", self.clock.now()))


def every_body() -> tuple[Body, ...]:
    """Return a loudspeaker, a tablet and a robot that moves: together they perform every part."""
    return Body("loudspeaker", ("say", "tone")), *tablet_alone(), Body("robot", ("gesture", "gaze"))


def tablet_alone() -> tuple[Body, ...]:
    """Return a tablet that shows, and does nothing else."""
    return (Body("tablet", ("show",)),)

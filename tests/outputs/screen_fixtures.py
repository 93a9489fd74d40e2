"""The agent on a screen that only records drawings, for the contract: `screen_rig`."""

from collections.abc import Iterator
from contextlib import contextmanager

from sar_tui.app.agent.output import DrawnAgent
from sar_tui.loop.clock import VirtualClock
from sar_tui.model.gesture import Gesture
from sar_tui.model.messages import Action
from sar_tui.model.theme import Theme
from tests.outputs.contract import Rig


class RecordingStage:
    """Stage that records what is drawn on it."""

    def __init__(self) -> None:
        self.drawn: list[object] = []

    def say(self, text: str, *how: object, joins: bool = False) -> None:
        self.drawn.append(text)

    def gesture(self, gesture: Gesture) -> None:
        self.drawn.append(gesture)

    def gaze(self, where: str) -> None:
        self.drawn.append(where)

    def be_still(self) -> None:
        self.drawn.append("still")

    def speaking(self, sounds: bool) -> None:
        self.drawn.append(sounds)

    def apply_theme(self, theme: Theme) -> None:
        self.drawn.append(theme.name)


class _Announced(DrawnAgent):
    """Announces each action itself, as the screen's node does."""

    def show(self, action: str, text: str, face: str) -> None:
        self.action = Action(
            id=action, kind="feedback", text=text, face=face, decision="accepted", actor="agent"
        )
        super().show(action, text, face)


@contextmanager
def screen_rig() -> Iterator[Rig]:
    """The drawn agent, in virtual time."""
    rig = Rig(_Announced(RecordingStage()), VirtualClock(), ("gesture",))
    try:
        yield rig
    finally:
        rig.output.close()

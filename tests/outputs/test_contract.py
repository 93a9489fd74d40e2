"""The contract of outputs: every output behaves alike when requested, stopped, themed or closed.

``RIGS`` names the outputs: each a context manager that yields a `Rig` of an output that is open.
"""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager

import pytest

from sar_tui.app.agent.output import DrawnAgent
from sar_tui.model.gesture import Gesture
from sar_tui.model.messages import Action
from sar_tui.model.theme import Theme
from sar_tui.outputs.sound.mixer import Sound
from sar_tui.outputs.speech import Speech, Tones
from tests.needs_speech import needs_speech
from tests.outputs.contract import CHECKS, Rig, rig_of
from tests.outputs.robot_fixtures import furhat_bench, only_rig, reachy_bench, ros4hri_bench
from tests.outputs.ros_fixtures import ros_rig
from tests.outputs.servo_fixtures import servo_rig
from tests.outputs.voice_fixtures import BEEPS, NOBODY, program_with


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


RIGS: dict[str, Callable[[], AbstractContextManager[Rig]]] = {
    "ros": ros_rig,
    "ros4hri": lambda: only_rig(ros4hri_bench()),
    "furhat": lambda: only_rig(furhat_bench()),
    "reachy": lambda: only_rig(reachy_bench()),
    "screen": lambda: rig_of(_Announced(RecordingStage()), "gesture"),
    "servo": servo_rig,
    "speech": lambda: rig_of(Speech(Sound()), "say"),
    "speech in real time": lambda: rig_of(
        Speech(Sound(backends=NOBODY, program=program_with(BEEPS))), "say", live=True
    ),
    "tones": lambda: rig_of(Tones(Sound()), "tone"),
    "tones in real time": lambda: rig_of(Tones(Sound(backends=NOBODY)), "tone", live=True),
    "servo on its thread": lambda: servo_rig(live=True),
}


IN_REAL_TIME = ("speech in real time", "tones in real time", "servo on its thread")
"""Outputs on the host's clock. They pass every check on a virtual clock, too, so `make test` tries
only three here.
"""
QUICK = (
    "parts_of_one_kind_follow_each_other_in_order",
    "stop_aborts_what_is_under_way_and_what_waits_and_then_it_works_again",
    "stop_of_one_that_is_under_way_leaves_the_one_that_waits",
)


def cases() -> Iterator[object]:
    for name in RIGS:
        for check in CHECKS:
            marks = [needs_speech] if name.startswith(("speech", "reachy")) else []
            if name in IN_REAL_TIME and check.__name__ not in QUICK:
                marks.append(pytest.mark.slow)
            yield pytest.param(name, check, marks=marks, id=f"{name}-{check.__name__}")


@pytest.mark.parametrize(("name", "check"), list(cases()))
def test_the_contract_holds(name: str, check: Callable[[Rig], None]) -> None:
    with RIGS[name]() as rig:
        check(rig)

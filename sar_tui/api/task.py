"""For a task (``task.py``) and its effect (``effect.py``).

The contract of a task and its values are loaded at once, in little more time than msgspec takes.
The rest is loaded when it is first used; numpy only with the names for reaches.
"""

from typing import TYPE_CHECKING

from sar_tui.api._names import names_on_demand
from sar_tui.loop.task import Task
from sar_tui.model.measure import Measure
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.trial_types import (
    UNSURE,
    Act,
    Again,
    Axis,
    Cue,
    Details,
    Frame,
    Json,
    Mark,
    Metric,
    PastAttempt,
    Performance,
    Quality,
    Result,
    Results,
    Score,
    Show,
    Situation,
    Stimulus,
    Target,
    Tone,
    Trial,
)
from sar_tui.model.units import MS, SECOND

if TYPE_CHECKING:
    from sar_tui.loop.node import Node
    from sar_tui.model.language import Language, Sentence
    from sar_tui.model.messages import KeyPerceived, ReachPerceived, TextPerceived, TrialEnded
    from sar_tui.model.results_for_people import goal_text, result_text
    from sar_tui.model.step import Step
    from sar_tui.motion.analysis import AnalysisParameters
    from sar_tui.motion.detector_names import DetectorName
    from sar_tui.motion.fixed_threshold import FixedThresholdParameters
    from sar_tui.motion.orientation import OrientationParameters
    from sar_tui.motion.single_axis import SingleAxisParameters
    from sar_tui.motion.synthesis import ReachShape
    from sar_tui.perception.reach import ReachPerception
    from sar_tui.rules.declaration import meta
    from sar_tui.rules.parameters import TaskParameters
    from sar_tui.rules.quest import Quest
    from sar_tui.rules.staircase import Staircase, weighted
    from sar_tui.rules.typed_text import typing
    from sar_tui.simulation.participant_model import Effect, mean_time

# fmt: off
__all__ = [  # noqa: RUF022  in groups
    # what a task declares
    "Task", "Metric", "Measure", "Quality", "Axis", "Target", "Mark", "Details", "Step",
    # its settings
    "TaskParameters", "meta",
    # what it shows
    "Stimulus", "Frame", "Cue", "Tone", "Show",
    # what it is given, and the percepts that it judges
    "Situation", "PastAttempt", "RandomStreams", "Trial",
    "KeyPerceived", "TextPerceived", "ReachPerceived",
    # what it answers
    "Result", "Results", "Again", "Score", "Json", "UNSURE",
    # difficulty within an attempt
    "Staircase", "weighted", "Quest",
    # texts for people
    "Language", "Sentence", "goal_text", "result_text",
    # simulated people
    "Performance", "Act", "typing",
    # the effect that a task is known for
    "Effect", "mean_time", "TrialEnded",
    # reaches: the node that makes percepts of them, its settings, and a simulated one
    "Node", "ReachPerception", "AnalysisParameters", "OrientationParameters",
    "SingleAxisParameters", "FixedThresholdParameters", "DetectorName", "ReachShape",
    # units of time
    "MS", "SECOND",
]
# fmt: on

_LOADED_LATER = {
    "sar_tui.loop.node": "Node",
    "sar_tui.model.language": "Language Sentence",
    "sar_tui.model.messages": "KeyPerceived ReachPerceived TextPerceived TrialEnded",
    "sar_tui.model.results_for_people": "goal_text result_text",
    "sar_tui.model.step": "Step",
    "sar_tui.motion.analysis": "AnalysisParameters",
    "sar_tui.motion.detector_names": "DetectorName",
    "sar_tui.motion.fixed_threshold": "FixedThresholdParameters",
    "sar_tui.motion.orientation": "OrientationParameters",
    "sar_tui.motion.synthesis": "ReachShape",
    "sar_tui.motion.single_axis": "SingleAxisParameters",
    "sar_tui.perception.reach": "ReachPerception",
    "sar_tui.rules.declaration": "meta",
    "sar_tui.rules.parameters": "TaskParameters",
    "sar_tui.rules.quest": "Quest",
    "sar_tui.rules.staircase": "Staircase weighted",
    "sar_tui.rules.typed_text": "typing",
    "sar_tui.simulation.participant_model": "Effect mean_time",
}
RETIRED: dict[str, str] = {}

if not TYPE_CHECKING:
    __getattr__ = names_on_demand(__name__, _LOADED_LATER, RETIRED)

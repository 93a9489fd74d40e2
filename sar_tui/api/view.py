"""For a task's view (``view.py``): its contract, lines of a prompt, and what it may listen to.

All other topics and messages are in `sar_tui.api.node`.
"""

from typing import TYPE_CHECKING

from rich.text import Text

from sar_tui.api._names import names_on_demand
from sar_tui.loop.node import on
from sar_tui.loop.task import Task
from sar_tui.loop.topics import (
    ATTEMPT_ENDED,
    ATTEMPT_STARTED,
    FRAME,
    IMU,
    KEY,
    LEVEL,
    MARKED,
    PERCEIVED,
    PROMPT,
    REACH,
    SESSION,
    TRIAL,
    TYPED,
    VOIDED,
    WAITING,
)
from sar_tui.model.language import Language
from sar_tui.model.messages import (
    AttemptEnded,
    AttemptStarted,
    FrameDue,
    ImuBlock,
    KeyPerceived,
    KeyPressed,
    LevelChanged,
    Prompt,
    PromptVoided,
    ReachPerceived,
    SessionStarted,
    TextPerceived,
    TrialEnded,
    TrialMarked,
    Typed,
    Waiting,
)
from sar_tui.model.results_for_people import result_text
from sar_tui.model.trial_types import Metric
from sar_tui.widgets.prompt_lines import Line, centred, halves, plain_lines, with_text
from sar_tui.widgets.task_view import Colors, Drawing, TaskView

if TYPE_CHECKING:
    from sar_tui.motion.trace import Trace
    from sar_tui.widgets.speed_trace import draw_traces

# fmt: off
__all__ = [  # noqa: RUF022  in groups
    # the contract
    "TaskView", "Task", "Metric", "Language",
    # a prompt: its lines
    "Line", "plain_lines", "centred", "halves", "with_text",
    # a drawing between attempts
    "Drawing", "Colors", "Text", "Trace", "draw_traces", "result_text",
    # topics
    "on", "SESSION", "KEY", "IMU", "PERCEIVED", "REACH", "WAITING", "LEVEL", "ATTEMPT_STARTED",
    "PROMPT", "FRAME", "TYPED", "VOIDED", "TRIAL", "MARKED", "ATTEMPT_ENDED",
    # their messages
    "SessionStarted", "KeyPressed", "ImuBlock", "KeyPerceived", "TextPerceived", "ReachPerceived",
    "Waiting", "LevelChanged", "AttemptStarted", "Prompt", "FrameDue", "Typed", "PromptVoided",
    "TrialEnded", "TrialMarked", "AttemptEnded",
]
# fmt: on

_LOADED_LATER = {
    "sar_tui.motion.trace": "Trace",
    "sar_tui.widgets.speed_trace": "draw_traces",
}
RETIRED: dict[str, str] = {}

if not TYPE_CHECKING:
    __getattr__ = names_on_demand(__name__, _LOADED_LATER, RETIRED)

"""For a difficulty or feedback policy: rules of its own for the next level, goal or feedback."""

from typing import TYPE_CHECKING

from sar_tui.api._names import names_on_demand
from sar_tui.model.messages import Outcome
from sar_tui.model.trial_types import Score, Target
from sar_tui.rules.declaration import Settings, meta
from sar_tui.rules.difficulty import (
    Bounds,
    Difficulty,
    DifficultyPolicy,
    Goal,
    ScoredAttempt,
    start_at,
    stay,
)
from sar_tui.rules.feedback import Decision, FeedbackPolicy, History, decide_every
from sar_tui.rules.judgement import JudgedAttempt

# fmt: off
__all__ = [  # noqa: RUF022  in groups
    # the settings that a policy reads
    "Settings", "meta",
    # difficulty
    "DifficultyPolicy", "Difficulty", "Goal", "Bounds", "ScoredAttempt", "Outcome", "start_at",
    "stay",
    # feedback
    "FeedbackPolicy", "Decision", "History", "JudgedAttempt", "Score", "Target", "decide_every",
]
# fmt: on

RETIRED: dict[str, str] = {}

if not TYPE_CHECKING:
    __getattr__ = names_on_demand(__name__, {}, RETIRED)

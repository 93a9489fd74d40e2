"""A policy is one file: it is found by its name, adds its own parameters, and can be used in a
session.
"""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from sar_tui.rules import difficulty, feedback
from sar_tui.rules.parameters import TaskParameters, fields

STRIDE = '''
"""Each attempt raises the level by a stride."""

from typing import Annotated

from sar_tui.rules.declaration import Settings, meta
from sar_tui.rules.difficulty.policy import Difficulty, DifficultyPolicy


class StrideSettings(Settings, frozen=True, kw_only=True):
    stride: Annotated[int, meta("Stride", "levels", ge=1, le=5, group="Difficulty")] = 1


def step(state, attempt, settings, bounds):
    return Difficulty(min(state.level + settings.stride, bounds.highest))


POLICY = DifficultyPolicy("Each attempt is harder.", StrideSettings, step)
'''
ALTERNATE = '''
"""Feedback on every other attempt."""

from sar_tui.rules.feedback.policy import Decision, FeedbackPolicy


def decide(history, attempt, settings):
    return Decision(history.since == 2, "Every other attempt gets feedback.")


POLICY = FeedbackPolicy(decide)
'''
ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize(
    ("policies", "name"),
    [(difficulty.POLICIES, "difficulty_policy"), (feedback.POLICIES, "feedback_schedule")],
    ids=["difficulty", "feedback"],
)
def test_the_names_of_the_policies_are_the_choices_of_the_parameter(
    policies: Mapping[str, object], name: str
) -> None:
    (field,) = [field for field in fields(TaskParameters) if field.name == name]
    assert set(field.choices) == set(policies)
    assert field.default in policies


def test_a_file_adds_a_policy_that_runs_a_session(tmp_path: Path) -> None:
    for part in ("sar_tui", "tasks", "themes"):
        shutil.copytree(ROOT / part, tmp_path / part, ignore=shutil.ignore_patterns("__pycache__"))
    policies = tmp_path / "sar_tui" / "rules"
    (policies / "difficulty" / "stride.py").write_text(STRIDE, encoding="utf-8")
    (policies / "feedback" / "alternate.py").write_text(ALTERNATE, encoding="utf-8")
    settings = [
        "difficulty_policy=stride",
        "stride=3",
        "feedback_schedule=alternate",
        "prompts_per_attempt=1",
    ]

    def run(*arguments: str) -> str:
        command = [
            sys.executable,
            "-m",
            "sar_tui",
            *arguments,
            "--json",
            "--data",
            str(tmp_path / "data"),
        ]
        environment = os.environ | {"PYTHONPATH": str(tmp_path)}
        return subprocess.run(
            command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=True
        ).stdout

    chosen = [word for setting in settings for word in ("--set", setting)]
    run("simulate", "keyboard", "--user", "competent", "--attempts", "4", "--seed", "1", *chosen)
    attempts = json.loads(run("show", "last"))["attempts"]
    assert [row["level"] for row in attempts] == [1, 4, 7, 10]
    assert [row["feedback"] != "none" for row in attempts] == [False, True, False, True]

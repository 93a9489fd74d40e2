"""A policy is one file: it is found by its name, adds its own settings, and can be used in a
session.
"""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from sar_tui.rules.declaration import ParameterError
from sar_tui.rules.parameters import TaskParameters, build, fields
from sar_tui.rules.policies import BY_CHOICE, without_effect
from tests.api.pages import DOCS, python_blocks

CHOSEN = {"difficulty_policy": "target", "feedback_schedule": "every"}
POLICIES = {
    "stride.py": '''
"""Each attempt raises the level by a stride."""

from typing import Annotated

from sar_tui.api.policy import Difficulty, DifficultyPolicy, Settings, meta


class StrideSettings(Settings, frozen=True, kw_only=True):
    stride: Annotated[int, meta("Stride", "levels", ge=1, le=5)] = 1


def step(state, attempt, settings, bounds):
    return Difficulty(min(state.level + settings.stride, bounds.highest))


POLICY = DifficultyPolicy("Each attempt is harder.", StrideSettings, step)
''',
    "astray.py": """
from sar_tui.api.policy import Difficulty, DifficultyPolicy


def step(state, attempt, settings, bounds):
    return Difficulty(1000) if attempt.number < 3 else 3


POLICY = DifficultyPolicy("", step=step)
""",
    "broken.py": "1 / 0\n",
    "fixed.py": "from sar_tui.api.policy import DifficultyPolicy\nPOLICY = DifficultyPolicy('')\n",
    "newer.py": "api = 2\nPOLICY = None\n",
    "nothing.py": "POLICY = 3\n",
    "taken.py": """
from sar_tui.api.policy import DifficultyPolicy, Settings


class Taken(Settings, frozen=True, kw_only=True):
    target_share: float = 1.0
    threshold: float = 1.0


POLICY = DifficultyPolicy("", Taken)
""",
}
PAGE = python_blocks((DOCS / "write-a-policy.md").read_text(encoding="utf-8"))
Program = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def program(tmp_path: Path) -> Program:
    """Run a command as a user who has policies of their own."""
    folder = tmp_path / "config" / "sar-tui" / "policies"
    folder.mkdir(parents=True)
    page = dict(zip(("two_thresholds.py", "after_failure.py"), PAGE, strict=True))
    for name, source in {**POLICIES, **page}.items():
        (folder / name).write_text(source, encoding="utf-8")

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, "-m", "sar_tui", *arguments, "--data", str(tmp_path / "data")],
            env=os.environ | {"XDG_CONFIG_HOME": str(tmp_path / "config")},
            capture_output=True,
            text=True,
            check=False,
        )

    return run


def test_the_names_of_the_policies_are_the_choices_of_a_setting() -> None:
    declared = {field.name: field for field in fields(TaskParameters)}
    for choice, policies in BY_CHOICE.items():
        assert set(declared[choice].choices) == set(policies)
        assert declared[choice].default in policies


@pytest.mark.slow
def test_a_users_policies_run_a_session_that_replays(program: Program) -> None:
    settings = (
        "difficulty_policy=stride",
        "stride=3",
        "feedback_schedule=after-failure",
        "threshold=450",
        "prompts_per_attempt=1",
    )
    chosen = [word for setting in settings for word in ("--set", setting)]
    length = ("--user", "competent", "--attempts", "4", "--seed", "1")
    simulated = program("simulate", "keyboard", *length, *chosen, "--json")
    attempts = json.loads(simulated.stdout)["attempts"]
    assert [row["level"] for row in attempts] == [1, 4, 7, 10]
    assert {row["outcome"] for row in attempts} == {"success", "failure"}
    for row in attempts:
        assert (row["feedback"] == "none") == (row["outcome"] == "success")
    assert json.loads(program("replay", "last", "--json").stdout)["identical"]


def test_a_policy_that_cannot_be_used_is_named_with_the_reason(program: Program) -> None:
    found = json.loads(program("doctor", "--json").stdout)["checks"]
    (policies,) = [row for row in found if row["name"] == "Policies"]
    assert policies["state"] == "bad"
    for sentence in (
        "The policy broken cannot be loaded: ZeroDivisionError: division by zero.",
        "The policy fixed has the name of an included one: rename it.",
        "The policy newer was written for API 2; this program has API 1. Update sar-tui.",
        "The policy nothing is neither a DifficultyPolicy nor a FeedbackPolicy.",
        "The policy taken declares target_share, threshold, which is a setting of every task: rename it.",
    ):
        assert sentence in policies["found"]
    done = program(
        "simulate", "keyboard", "--user", "competent", "--set", "difficulty_policy=broken"
    )
    assert done.returncode == 2
    assert "The policy broken cannot be loaded: ZeroDivisionError" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.slow
def test_a_result_that_cannot_be_one_is_told_and_levels_stay_within_bounds(
    program: Program,
) -> None:
    done = program(
        *("simulate", "keyboard", "--user", "competent", "--attempts", "4"),
        *("--set", "difficulty_policy=astray", "--set", "max_level=4"),
    )
    assert "the policy astray returned 3, not a Difficulty" in done.stderr
    attempts = json.loads(program("show", "last", "--json").stdout)["attempts"]
    assert [row["level"] for row in attempts] == [1, 4]


def test_a_policy_that_is_not_there_is_one_problem_with_its_settings() -> None:
    with pytest.raises(ParameterError) as refused:
        build(TaskParameters, {"difficulty_policy": "stride", "stride": 3})
    assert str(refused.value) == (
        "There is no difficulty policy stride here: install the package that has it, or choose "
        "one of fixed, one-up-one-down, percentile, sequence, target."
    )


@pytest.mark.parametrize(
    ("policy", "ignored"),
    [
        ("one-up-one-down", set()),
        ("target", set()),
        ("fixed", {"start_from", "min_level", "max_level"}),
        ("percentile", {"start_from", "min_level", "max_level"}),
        ("sequence", {"start_level", "start_from"}),
    ],
)
def test_settings_of_levels_that_a_policy_does_not_read_have_no_effect(
    policy: str, ignored: set[str]
) -> None:
    of_levels = {"start_level", "start_from", "min_level", "max_level"}
    assert without_effect({"difficulty_policy": policy}).keys() & of_levels == ignored


def test_settings_of_policies_that_are_not_chosen_have_no_effect() -> None:
    found = without_effect(CHOSEN)
    assert found["percentile_rank"] == "percentile"
    assert found["consecutive_successes"] == "one-up-one-down"
    assert found["feedback_tolerance"] == "bandwidth"
    assert not {"target_share", "target_of", "feedback_every", "threshold"} & found.keys()
    assert without_effect({"feedback_schedule": "none"})["feedback_every"] == "every or summary"
    assert not without_effect({"difficulty_policy": "mine", "feedback_schedule": "mine"})

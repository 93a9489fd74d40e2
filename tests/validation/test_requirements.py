"""The four requirements: the program meets them, and each system broken on purpose fails its own,
alone.
"""

import shutil
import tempfile
from pathlib import Path

import pytest
from msgspec.structs import replace

from sar_tui import loop
from sar_tui.loop.session import Parts
from sar_tui.plugins import Catalogue
from sar_tui.validation import requirements
from sar_tui.validation.adaptation import follows_results, ranks_users
from sar_tui.validation.modularity import Code, Loaded, code
from sar_tui.validation.report import Conditions
from sar_tui.validation.requirements import Body, System
from sar_tui.validation.simulated_sessions import session_runner
from tests.validation import broken_parts


def with_own_framework(loaded: Loaded) -> Code:
    """Count the code of a task whose folder holds a copy of the framework."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "task"
        shutil.copytree(loaded.folder, folder)
        shutil.copytree(Path(loop.__file__).parent, folder / "own_framework")
        return code(replace(loaded, folder=str(folder)))


TRAINING, FEEDBACK = "task-oriented training", "augmented feedback"
EMBODIMENT, MODULARITY = "embodiment", "modular flexibility"
ONE_BODY = (Body("tablet", ("show",)),)
UP_AND_DOWN = (1, 2, 3, 4, 5, 6, 5, 4, 3, 2)
CONTROLS = {
    "a rule that never adapts": (TRAINING, System({"difficulty_policy": "fixed", "start_level": 5})),
    "a rule that ignores the result": (
        TRAINING, System({"difficulty_policy": "sequence", "level_sequence": UP_AND_DOWN})),
    "keys that are perceived late": (
        TRAINING, System(parts=Parts(perception=broken_parts.LatePerception))),
    "praise whatever the result": (
        FEEDBACK, System(parts=Parts(event_handler=broken_parts.PraisingEventHandler))),
    "a neutral word whatever the result": (FEEDBACK, System({"neutral_band": 5000.0})),
    "figures that are off": (
        FEEDBACK, System(parts=Parts(event_handler=broken_parts.MisinformedEventHandler))),
    "feedback after each attempt, although it is to be rare": (
        FEEDBACK, System(rare={"feedback_schedule": "every", "feedback_every": 1})),
    "feedback with figures, although none are wanted": (
        FEEDBACK, System(worded={"feedback_form": "quantitative"})),
    "an agent without a voice and without a body": (EMBODIMENT, System(bodies=lambda: ONE_BODY)),
    "a level that falls when a robot moves": (
        EMBODIMENT, System(parts=Parts(event_handler=broken_parts.DistractedEventHandler))),
    "a task with a framework of its own": (MODULARITY, System(reaching=with_own_framework)),
    "a task that needs a memory of its own": (
        MODULARITY, System(parts_of_reaching=Parts(memory=broken_parts.OwnMemory))),
}  # fmt: skip
"""Systems with one thing broken, each with the requirement that it must fail, alone."""


def unmet(system: System, known: dict[object, object] | None = None) -> list[str]:
    """Return the requirements that a system does not meet."""
    conditions = Conditions(Catalogue(), is_quick=True, seeds=range(1, 3), known=known)
    rows = requirements.run(conditions, system).rows
    assert len(rows) == len(requirements.REQUIREMENTS) == 4
    return [row["requirement"] for row in rows if not row["met"]]


@pytest.mark.slow
def test_the_program_meets_each_requirement() -> None:
    assert unmet(System()) == []


@pytest.mark.slow
@pytest.mark.parametrize("control", CONTROLS)
def test_a_system_broken_on_purpose_fails_its_own_requirement_alone(control: str) -> None:
    fails, system = CONTROLS[control]
    assert unmet(system) == [fails]


@pytest.mark.parametrize(
    ("parts", "off"), [(Parts(), 0.0), (Parts(perception=broken_parts.LatePerception), 150.0)]
)
def test_the_measured_times_are_judged_by_when_prompts_were_shown_and_keys_pressed(
    catalogue: Catalogue, parts: Parts, off: float
) -> None:
    with session_runner(catalogue) as runner:
        done = runner.run("average", 1, parts=parts, attempts=2)
    found = [each["metric"] - done.timed[each["attempt"]] for each in done.attempts]
    assert found == pytest.approx([off, off], abs=0.01)


def test_an_outcome_that_contradicts_the_time_is_told() -> None:
    def rows(user: str, levels: list[int]) -> list[dict[str, object]]:
        same = {
            "user": user,
            "seed": 1,
            "outcome": "success",
            "lowest_level": 1,
            "highest_level": 5,
        }
        return [
            {**same, "attempt": number, "level": level} for number, level in enumerate(levels, 11)
        ]

    assert follows_results(rows("poor", [1, 2, 3, 4, 5, 5])).holds
    assert "level 1 → 1 after a success" in follows_results(rows("poor", [1, 1])).against
    people = [*rows("poor", [2]), *rows("average", [3]), *rows("competent", [4])]
    assert ranks_users(people).holds
    assert not ranks_users([*rows("poor", [3]), *people[1:]]).holds

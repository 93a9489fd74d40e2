"""The four requirements: the program meets them, and each system broken on purpose fails its own,
alone.
"""

from collections import Counter
from functools import cache

import pytest

from sar_tui.app.loop_graph import loop_graph
from sar_tui.loop.session import Parts
from sar_tui.plugins import Catalogue
from sar_tui.validation import broken_parts, requirements
from sar_tui.validation.changed_parts import node_classes
from sar_tui.validation.changed_parts import report as changed_parts
from sar_tui.validation.report import Conditions, Report
from sar_tui.validation.simulated_sessions import session_runner


@cache
def found() -> Report:
    return requirements.run(Conditions(Catalogue(), is_quick=True, seeds=range(1, 3)))


@pytest.mark.slow
def test_the_program_meets_each_requirement_and_each_control_fails_its_own_alone() -> None:
    report = found()
    assert [claim for claim in report.claims if not claim.holds] == []
    verdicts = Counter((row["system"], row["met"]) for row in report.rows)
    assert verdicts["the program as it is", True] == len(requirements.REQUIREMENTS) == 4
    assert {verdicts[control.name, False] for control in requirements.CONTROLS} == {1}
    assert {control.fails for control in requirements.CONTROLS} == {
        each.name for each in requirements.REQUIREMENTS
    }


@pytest.mark.slow
def test_a_reason_says_what_is_against_a_requirement() -> None:
    (row,) = (
        row
        for row in found().rows
        if row["system"].startswith("an agent without") and not row["met"]
    )
    assert "nothing performs: say, gesture" in row["against"]


def test_a_loop_that_lacks_a_part_is_not_the_same(catalogue: Catalogue) -> None:
    theme = catalogue.theme("calm")
    graphs = {task: loop_graph(catalogue.task(task), theme) for task in ("keyboard", "reaching")}
    nodes = {task: node_classes(catalogue.task(task), theme) for task in graphs}
    assert all(claim.holds for claim in changed_parts(graphs, nodes).claims)
    swapped = {"keyboard": graphs["reaching"], "reaching": graphs["keyboard"]}
    lacking = changed_parts(swapped, nodes).claims[0]
    assert "imu" in lacking.against


def test_a_part_that_a_task_replaces_under_its_name_is_another(catalogue: Catalogue) -> None:
    theme = catalogue.theme("calm")
    graphs = {task: loop_graph(catalogue.task(task), theme) for task in ("keyboard", "reaching")}
    own = Parts(memory=broken_parts.OwnMemory)
    nodes = {task: node_classes(catalogue.task(task), theme) for task in graphs}
    nodes["reaching"] = node_classes(catalogue.task("reaching"), theme, own)
    report = changed_parts(graphs, nodes)
    assert [claim.against for claim in report.claims] == ["", "memory", ""]
    assert [row["part"] for row in report.rows if row["state"] == "changed"] == ["memory"]


@pytest.mark.parametrize(
    ("parts", "off"), [(Parts(), 0.0), (Parts(perception=broken_parts.LatePerception), 150.0)]
)
def test_the_measured_times_are_judged_by_when_prompts_were_shown_and_keys_pressed(
    catalogue: Catalogue, parts: Parts, off: float
) -> None:
    with session_runner(catalogue) as runner:
        done = runner.run("average", 1, parts=parts, attempts=2)
    found = {
        attempt["attempt"]: attempt["metric"] - done.timed[attempt["attempt"]]
        for attempt in done.attempts
    }
    assert found == pytest.approx({1: off, 2: off}, abs=0.01)


def test_an_outcome_that_contradicts_the_time_is_told(catalogue: Catalogue) -> None:
    from sar_tui.validation.adaptation import follows_results, ranks_users

    def rows(user: str, levels: list[int], outcome: str = "success") -> list[dict[str, object]]:
        return [
            {"user": user, "seed": 1, "attempt": number, "level": level, "outcome": outcome, "lowest_level": 1,
             "highest_level": 5}
            for number, level in enumerate(levels, 11)
        ]  # fmt: skip

    assert follows_results(rows("poor", [1, 2, 3, 4, 5, 5])).holds
    assert "level 1 → 1 after a success" in follows_results(rows("poor", [1, 1])).against
    people = [*rows("poor", [2]), *rows("average", [3]), *rows("competent", [4])]
    assert ranks_users(people).holds
    assert not ranks_users(
        [*rows("poor", [3]), *rows("average", [3]), *rows("competent", [4])]
    ).holds

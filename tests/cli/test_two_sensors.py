"""Sensors of two on the command line."""

from sar_tui.runs.plan import Plan
from tests.cli.test_outputs_flags import opened
from tests.program import Call

__all__ = ["opened"]

RUN = "run pairs -p P01 -p P02 --new".split()
REACHES = ("--set", "respond_with=reaches")


def test_each_seats_sensor_is_named(call: Call, opened: list[Plan]) -> None:
    assert call(*RUN, *REACHES, "--imu", "simulated", "--set", "imu_b=simulated:tremor").code == 0
    (plan,) = opened
    assert (plan.parameters.imu, plan.parameters.imu_b) == ("simulated", "simulated:tremor")  # type: ignore[attr-defined]


def test_two_who_reach_are_simulated_at_the_command_line_too(call: Call) -> None:
    few = ("--attempts", 1, "--set", "prompts_per_attempt=2", "--seed", 1, "--json")
    who = "--set policy=cooperative --user average --user poor".split()
    reported = call("simulate pairs", *REACHES, *who, *few)
    assert reported.code == 0
    assert {attempt["seat"] for attempt in reported.json["attempts"]} == {"A", "B"}

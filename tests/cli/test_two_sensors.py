"""Sensors of two on the command line: invalid choices are refused before the screen changes."""

import pytest

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


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (
            ("--imu", "simulated"),
            "The task pairs uses no motion sensor with these settings: leave out --imu",
        ),
        (
            (*REACHES,),
            "Both sensors are named phidget. Say which belongs to whom: --imu phidget:SERIAL for "
            "the left",
        ),
        (
            (*REACHES, "--imu", "simulated", "--set", "imu_b=wiimote"),
            'There is no sensor "wiimote".',
        ),
        ((*REACHES, "--imu", "simulated:unheard-of"), 'There is no simulated hand "unheard-of".'),
    ],
)
def test_invalid_sensor_options_are_refused(
    call: Call, opened: list[Plan], options: tuple[str, ...], says: str
) -> None:
    called = call(*RUN, *options)
    assert (called.code, called.out) == (2, "")
    assert says in called.err
    assert called.err.count("\n") == 1
    assert opened == []


def test_two_who_reach_are_simulated_at_the_command_line_too(call: Call) -> None:
    few = ("--attempts", 1, "--set", "prompts_per_attempt=2", "--seed", 1, "--json")
    reported = call(
        "simulate pairs",
        *REACHES,
        "--set",
        "policy=cooperative",
        "--user",
        "average",
        "--user",
        "poor",
        *few,
    )
    assert reported.code == 0
    assert {attempt["seat"] for attempt in reported.json["attempts"]} == {"A", "B"}

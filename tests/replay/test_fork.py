"""``sar-tui replay --what-if … --fork``: a session goes on by other settings, with a model of its
participant.
"""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from random import Random
from typing import Any

import msgspec
import pytest

from sar_tui.plugins import Catalogue
from sar_tui.replay.fork import fork, play, read_responses, summary
from sar_tui.replay.response_model import Counts, Response, ResponseModel
from sar_tui.rules.parameters import build
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE, Person
from sar_tui.store import sessions
from sar_tui.store.database import connect
from tests.program import Call

FEW = ("--fork", "--runs", "20")
P01 = ("-p", "P01", "--attempts")
TWINS: tuple[tuple[Person, dict[str, object]], ...] = (
    (PEOPLE["poor"], {"threshold": 1250}),
    (PEOPLE["average"], {"threshold": 900}),
    (PEOPLE["competent"], {"threshold": 700}),
    (msgspec.structs.replace(PEOPLE["average"], practice=0.2), {"threshold": 850}),
    (
        msgspec.structs.replace(PEOPLE["average"], fatigue=0.015),
        {"difficulty_policy": "one-up-one-down"},
    ),
    (PEOPLE["average"], {"start_level": 5}),
)
"""People, some with a drift, and the setting that is changed."""


def numbers(result: Any) -> dict[str, dict[str, Any]]:
    return {one["name"]: one for one in result["numbers"]}


@pytest.mark.slow
def test_it_begins_where_the_scores_of_the_record_end(call: Call, simulated: str) -> None:
    changed = ("replay", simulated, "--what-if", "threshold=500")
    result = call(*changed, *FEW, "--json").json
    assert result["record_ends_at_attempt"] == call(*changed, "--json").json["ends_at_attempt"] > 1
    assert (result["runs"], result["what_if"]) == (20, {"threshold": 500})
    assert result["model"]["responses"] > 60
    level = numbers(result)["final_level"]
    assert level["low"] <= level["median"] <= level["high"] < level["recorded"]
    assert result == call(*changed, *FEW, "--json").json, "the runs are seeded"
    told = call(*changed, *FEW).out
    assert told.startswith("Model, not data\n")
    assert f"The record ends before attempt {result['record_ends_at_attempt']}." in told


def test_any_setting_can_be_changed_and_may_leave_nothing_of_the_record(
    call: Call, simulated: str
) -> None:
    result = call("replay", simulated, "--what-if", "prompts_per_attempt=5", *FEW, "--json").json
    assert result["record_ends_at_attempt"] == 1
    longer = call("replay", simulated, "--what-if", "attempts=6", *FEW, "--json").json
    assert (longer["record_ends_at_attempt"], numbers(longer)["attempts"]["median"]) == (5, 6)


def test_nothing_is_modelled_if_all_prompts_are_the_same(call: Call, simulated: str) -> None:
    called = call("replay", simulated, "--what-if", "feedback_schedule=none", *FEW, "--json").json
    assert (called["record_ends_at_attempt"], called["model"], called["runs"]) == (None, None, 1)
    assert numbers(called)["positive_feedbacks"]["high"] == 0
    metric = numbers(called)["mean_metric"]
    assert metric["recorded"] == metric["low"] == metric["high"]
    told = call("replay", simulated, "--what-if", "feedback_schedule=none", *FEW).out
    assert told.startswith("From the record alone\n")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("keyboard", *P01, 2, "--set", "prompts_per_attempt=5"), "too few for a model"),
        (("keyboard", *P01, 3, "--operator", "careful"), "An operator or a therapist acted on"),
        (("pairs", "-p", "P02", *P01, 1), "A session of two cannot be forked"),
        (("reaching", *P01, 1, "--set", "reaches_per_attempt=1"), "not of movements"),
    ],
)
def test_a_session_that_cannot_be_modelled_is_refused(
    call: Call, words: tuple[object, ...], said: str
) -> None:
    call("simulate", *words, "--user", "average", "--seed", 1)
    called = call("replay", "last", "--what-if", "start_level=2", *FEW)
    assert (called.code, called.out) == (1, "")
    assert said in called.err


def test_a_session_that_was_not_completed_is_refused(
    call: Call, data: Path, simulated: str
) -> None:
    with closing(connect(data)) as database:
        database.execute("UPDATE sessions SET status='aborted'")
    called = call("replay", simulated, "--what-if", "threshold=900", *FEW)
    assert (called.code, "was not completed" in called.err) == (1, True)


@pytest.mark.parametrize(
    "words", [("--fork",), ("--runs", "50"), ("--what-if", "threshold=900", "--runs", "50")]
)
def test_its_options_need_each_other(call: Call, simulated: str, words: tuple[str, ...]) -> None:
    called = call("replay", simulated, *words)
    assert (called.code, called.out) == (2, "")


def test_the_model_finds_what_made_the_responses() -> None:
    random = Random(3)
    drawn = [(attempt, random.choice((2, 4, 8, 16))) for attempt in range(1, 21) for _ in range(20)]
    times = [
        (300 + 150 * (choices.bit_length() - 1) + 5 * (a - 10.5)) * random.gauss(1, 0.2)
        for a, choices in drawn
    ]
    responses = [Response(*one, time) for one, time in zip(drawn, times, strict=True)]
    fit = ResponseModel(responses, Counts(420, missed=10, wrong=10)).fit
    assert fit.base_ms == pytest.approx(300, rel=0.1)
    assert fit.per_bit_ms == pytest.approx(150, rel=0.1)
    assert fit.per_attempt_ms == pytest.approx(5, abs=2)
    assert fit.spread == pytest.approx(0.2, rel=0.1)


def twins(folder: Path, catalogue: Catalogue, count: int, runs: int) -> Iterator[dict[str, bool]]:
    """Yield for each twin, by number, if the interval holds the truth: the session played by the
    same person.
    """
    kind = catalogue.task("keyboard")
    for number in range(count):
        person, changed = TWINS[number % len(TWINS)]
        settings = {"attempts": 10, "prompts_per_attempt": 12}
        plan = make_plan(catalogue, kind, ["P01"], settings, seed=number, mode="simulated")
        name = simulate(plan, person, folder, catalogue)
        with closing(connect(folder)) as database:
            row = sessions.find(database, folder, name)
            forked = fork(database, folder, catalogue, row, changed, runs)
            responses = read_responses(database, row)
        if forked.record_ends_at_attempt is None:
            continue
        after = build(kind.Parameters, {**row["parameters"], **changed})
        truth = summary(
            play(kind, after, responses, number, responses, person, 10**6 + number).ended
        )
        yield {
            one.name: one.low - 1e-9 <= getattr(truth, one.name) <= one.high + 1e-9
            for one in forked.numbers
            if one.low is not None and one.high is not None
        }


@pytest.mark.slow
def test_its_interval_holds_the_truth_as_often_as_it_says(data: Path, catalogue: Catalogue) -> None:
    held = list(twins(data, catalogue, 24, 100))
    assert len(held) > 15
    scores = "mean_level mean_metric accuracy final_level successes positive_feedbacks"
    for name in scores.split():
        assert sum(one[name] for one in held) / len(held) >= 0.75, name

"""``sar-tui replay --what-if``: recorded responses scored by other parameters, as far as the
prompts are the same.
"""

from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from sar_tui.store import sessions
from sar_tui.store.database import connect
from tests.program import Call
from tests.replay.test_replay import LAST_TRIAL, change

FIXED = ("--set", "difficulty_policy=fixed", "--set", "start_level=3")
SCORE = ("metric", "accuracy", "goal", "outcome", "feedback")


def simulate(call: Call, task: str, *settings: object, attempts: int = 4) -> str:
    codes = ("-p", "P01", "-p", "P02") if task == "pairs" else ("-p", "P01")
    words = ("simulate", task, "--user", "average", "--seed", 5, "--attempts", attempts, *codes)
    made = call(*words, *settings, "--json")
    assert made.code == 0, made.err
    return str(made.json["session"])


def scores(data: Path, session: str) -> list[dict[str, Any]]:
    with closing(connect(data)) as database:
        rows = sessions.rows(database, "attempts", session)
    return [{name: row[name] for name in SCORE} for row in rows]


@pytest.mark.parametrize(
    ("task", "settings", "changed"),
    [
        ("keyboard", FIXED, ("threshold=1100", "min_accuracy=1", "neutral_band=0.2")),
        ("keyboard", FIXED, ("feedback_every=2",)),
        ("pairs", FIXED[:2], ("threshold=700",)),
        ("reaching", FIXED, ("detector=fixed-threshold",)),
    ],
)
def test_recorded_responses_are_scored_as_in_a_session_that_had_those_settings_from_its_beginning(
    call: Call, data: Path, task: str, settings: tuple[str, ...], changed: tuple[str, ...]
) -> None:
    played = simulate(call, task, *settings, attempts=3)
    set_so = [word for pair in changed for word in ("--set", pair)]
    asked = [word for pair in changed for word in ("--what-if", pair)]
    fresh = simulate(call, task, *settings, *set_so, attempts=3)
    called = call("replay", played, *asked, "--json")
    assert called.code == 0, called.err
    rescored = called.json["attempts"]
    assert called.json["ends_at_attempt"] is None
    assert [one["recorded"] for one in rescored] == scores(data, played)
    assert [one["rescored"] for one in rescored] == scores(data, fresh)
    assert scores(data, played) != scores(data, fresh), "the settings matter"


def test_it_ends_at_the_first_attempt_that_would_have_had_another_level(
    call: Call, data: Path
) -> None:
    played = simulate(call, "keyboard")
    fresh = simulate(call, "keyboard", "--set", "threshold=500")
    with closing(connect(data)) as database:
        levels = [
            [row["level"] for row in sessions.rows(database, "attempts", name)]
            for name in (played, fresh)
        ]
    first = 1 + [was == now for was, now in zip(*levels, strict=True)].index(False)
    assert first > 1
    result = call("replay", played, "--what-if", "threshold=500", "--json").json
    assert (result["ends_at_attempt"], result["what_if"]) == (first, {"threshold": 500})
    assert [one["attempt"] for one in result["attempts"]] == list(range(1, first))
    assert [one["rescored"] for one in result["attempts"]] == scores(data, fresh)[: first - 1]
    told = call("replay", played, "--what-if", "threshold=500")
    assert (told.code, f"It ends before attempt {first}, " in told.out) == (0, True)


def test_an_unchanged_setting_changes_no_score(call: Call, simulated: str) -> None:
    result = call("replay", simulated, "--what-if", "threshold=1000", "--json").json
    assert (result["ends_at_attempt"], result["other_feedback_from"]) == (None, None)
    assert len(result["attempts"]) == 4
    assert all(one["recorded"] == one["rescored"] for one in result["attempts"])


def test_feedback_that_would_not_have_been_given_is_named(call: Call, data: Path) -> None:
    played = simulate(call, "keyboard", *FIXED)
    result = call("replay", played, "--what-if", "feedback_schedule=none", "--json").json
    assert result["other_feedback_from"] == 1
    assert {one["rescored"]["feedback"] for one in result["attempts"]} == {"none"}


def test_it_ends_where_an_operator_would_have_had_something_else_to_decide_on(
    call: Call, data: Path
) -> None:
    played = simulate(call, "keyboard", *FIXED, "--operator", "careful")
    same = call("replay", played, "--what-if", "threshold=1000", "--json").json
    assert (same["ends_at_attempt"], len(same["attempts"])) == (None, 4)
    other = call("replay", played, "--what-if", "feedback_schedule=none", "--json").json
    assert (other["ends_at_attempt"], other["attempts"]) == (1, [])


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("foreperiod_min_ms=900", "foreperiod_min_ms changes more than scores"),
        ("feedback_delay_ms=900", "feedback_delay_ms changes more than scores"),
        ("treshold=900", "Did you mean threshold?"),
        ("threshold=-1", "Goal is a number, 100 to 60000"),
        ("threshold", "--what-if takes NAME=VALUE"),
    ],
)
def test_other_settings_are_refused_with_a_sentence(
    call: Call, simulated: str, given: str, said: str
) -> None:
    called = call("replay", simulated, "--what-if", given)
    assert (called.code, called.out) == (2, "")
    assert said in called.err


def test_a_session_that_is_not_identical_is_refused(call: Call, data: Path, simulated: str) -> None:
    with closing(connect(data)) as database:
        (seq,) = database.execute(LAST_TRIAL).fetchone()
    change(data, f"DELETE FROM messages WHERE seq={seq}")
    called = call("replay", simulated, "--what-if", "threshold=900")
    assert (called.code, "differs from its record without any change" in called.err) == (1, True)

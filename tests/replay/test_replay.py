"""``sar-tui replay``: a recorded session comes out the same, and what was changed is found."""

import json
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import msgspec
import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.topics import SESSION
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.run import resume, start
from sar_tui.store import locks, sessions
from sar_tui.store.database import StoreError, connect
from tests import played
from tests.examples import first_rows
from tests.played import somebody
from tests.program import Call

SIMULATED = [
    (task, user, seed, operated)
    for seed, user in enumerate(("average", "poor", "competent", "average", "poor"), 1)
    for task, operated in zip("keyboard pairs reaching keyboard".split(), (1, 0, 0, 0), strict=True)
]
"""Twenty sessions."""
SHORT = {"attempts": 3, "prompts_per_attempt": 3}
PLAN = make_plan(Catalogue(), "keyboard", ["P01"], SHORT, seed=4)


def simulate(call: Call, task: str, user: str, seed: int, operated: object = False) -> str:
    codes = ("-p", "P01", "-p", "P02") if task == "pairs" else ("-p", "P01")
    operator = ("--operator", "careful") if operated else ()
    words = ("--user", user, "--seed", seed, "--attempts", 2, *codes, *operator)
    made = call("simulate", task, *words, "--json")
    assert made.code == 0, made.err
    return str(made.json["session"])


def play(data: Path, *cuts: int, seed: int = 4) -> str:
    """Play a live session on the virtual clock, cut off and resumed after each number of steps;
    return its id.
    """
    plan = msgspec.structs.replace(PLAN, seed=seed)
    run = start(plan, data, Catalogue(), clock := VirtualClock(), somebody)
    for number, steps in enumerate(cuts, 1):
        played.play(run, clock, steps)
        clock = VirtualClock(number * 1000 * SECOND)
        run = resume(run.id, data, Catalogue(), clock, somebody)
    return played.play(run, clock)


def dump(data: Path) -> list[str]:
    with closing(sqlite3.connect(data / "sar-tui.db")) as database:
        return list(database.iterdump())


def change(data: Path, *statements: str) -> None:
    """Change the stored session behind the program's back."""
    with closing(connect(data)) as database:
        for statement in statements:
            database.execute(statement)


LAST_TRIAL = "SELECT max(seq) FROM events WHERE topic='event_handler/trial'"


@pytest.mark.parametrize(("task", "user", "seed", "operated"), first_rows(3, SIMULATED))
def test_a_simulated_session_is_identical(
    call: Call, task: str, user: str, seed: int, operated: object
) -> None:
    called = call("replay", simulate(call, task, user, seed, operated), "--json")
    assert called.json["identical"], called.json["first_difference"]
    assert (called.code, called.json["first_difference"]) == (0, None)
    (recorded,) = called.json["recorded_with"]
    assert recorded == {**called.json["replayed_with"], "run": recorded["run"]}


def test_a_session_by_other_rules_is_neither_replayed_nor_resumed(
    call: Call, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = play(data)
    monkeypatch.setattr("sar_tui.runs.run.RULES", 2)
    told = f"The session {session} was recorded by another version of sar-tui (rules 1 of the loop"
    for asked in ((), ("--what-if", "threshold=900"), ("--what-if", "threshold=900", "--fork")):
        called = call("replay", session, *asked)
        assert (called.code, called.err.startswith(told)) == (2, True)
    change(data, "UPDATE sessions SET status='interrupted'")
    with pytest.raises(StoreError, match="recorded by another version"):
        resume(session, data, Catalogue(), VirtualClock(), somebody)


def test_what_a_participant_does_later_does_not_change_an_earlier_session(
    call: Call, data: Path
) -> None:
    first, second = play(data, seed=4), play(data, seed=5)
    play(data, seed=6)
    history = sessions.history(connect(data), second)
    (started,) = [record.message for record in history if record.topic is SESSION]
    assert started.best, "the second session knew results of the first"
    for session in (first, second):
        assert call("replay", session).code == 0


def test_a_resumed_and_an_interrupted_session_are_identical(call: Call, data: Path) -> None:
    resumed = play(data, 12, 20)
    result = call("replay", resumed, "--json").json
    assert result["identical"]
    assert [run["run"] for run in result["recorded_with"]] == [1, 2, 3]
    change(data, "UPDATE sessions SET status='interrupted'", "DELETE FROM messages WHERE run > 2")
    assert call("replay", resumed).code == 0


def test_a_replay_writes_nothing(call: Call, data: Path, simulated: str) -> None:
    before = dump(data)
    assert call("replay", "last").code == 0
    assert dump(data) == before


# --- differences


def plant(data: Path, topic: str, field: str, value: object) -> int:
    """Change a field of the second message of a topic; return the number of the message."""
    with closing(connect(data)) as database:
        seq, id, text = database.execute(
            "SELECT seq, topic, message FROM messages JOIN topics ON id=topic WHERE name=? ORDER "
            "BY seq LIMIT 1, 1",
            (topic,),
        ).fetchone()
        values = json.loads(text)
        (layout,) = database.execute("SELECT fields FROM topics WHERE id=?", (id,)).fetchone()
        values[[name for name, *_ in json.loads(layout)].index(field)] = value
        database.execute("UPDATE messages SET message=? WHERE seq=?", (json.dumps(values), seq))
    return int(seq)


@pytest.mark.parametrize(
    ("topic", "field", "value"),
    [
        ("event_handler/trial", "reaction_time_ms", 1.5),
        ("event_handler/prompt", "level", 9),
        ("event_handler/attempt_ended", "correct", 0),
    ],
)
def test_a_planted_difference_is_found_at_its_message(
    call: Call, data: Path, simulated: str, topic: str, field: str, value: object
) -> None:
    seq = plant(data, topic, field, value)
    called = call("replay", simulated, "--json")
    found = called.json["first_difference"]
    assert (called.code, called.json["identical"]) == (1, False)
    assert (found["seq"], found["topic"]) == (seq, topic)
    assert found["recorded"][field] == value != found["derived"][field]
    assert called.json["events"] == seq - 1
    told = call("replay", simulated)
    assert told.code == 1
    assert f"Message {seq} ({topic}):\n  {field}: {value!r} recorded, " in told.out


def test_a_planted_difference_inside_of_a_value_is_told_by_its_name(
    call: Call, data: Path, simulated: str
) -> None:
    seq = plant(data, "event_handler/trial", "details", {"choices": 7, "key_gap_ms": None})
    told = call("replay", simulated).out
    assert f"Message {seq} (event_handler/trial):\n  details.choices: 7 recorded, 2 now\n" in told


def test_a_removed_message_is_found_where_it_was(call: Call, data: Path, simulated: str) -> None:
    with closing(connect(data)) as database:
        (seq,) = database.execute(LAST_TRIAL).fetchone()
    change(data, f"DELETE FROM messages WHERE seq={seq}")
    found = call("replay", simulated, "--json").json["first_difference"]
    assert (found["seq"], found["derived_topic"]) == (seq + 1, "event_handler/trial")
    assert "in its place follows event_handler/trial." in call("replay", simulated).out


def test_a_task_that_was_changed_is_named(call: Call, data: Path, tmp_path: Path) -> None:
    shutil.copytree("tasks/keyboard", tmp_path / "own" / "keyboard")
    session = simulate(call, "keyboard", "average", 1)
    assert "The files of the task keyboard" not in call("replay", session).out
    task = tmp_path / "own" / "keyboard" / "task.py"
    task.write_text(f"{task.read_text()}\n# changed\n")
    called = call("replay", session, "--tasks", tmp_path / "own")
    assert (called.code, "The files of the task keyboard have changed." in called.out) == (0, True)


# --- sessions that are not whole


def test_a_running_session_is_refused(call: Call, data: Path, simulated: str) -> None:
    change(data, "UPDATE sessions SET status='running'")
    with locks.hold(data, "session", simulated):
        called = call("replay", simulated)
    assert (called.code, called.out, "is running" in called.err) == (2, "", True)


def test_a_session_whose_end_is_in_a_rescue_file_is_refused(
    call: Call, data: Path, simulated: str
) -> None:
    (data / f"sar-tui-rescue-{simulated}.db").touch()
    called = call("replay", simulated)
    assert (called.code, "Run `sar-tui rescue` first." in called.err) == (2, True)


def test_a_session_with_damaged_samples_is_refused(call: Call, data: Path) -> None:
    session = simulate(call, "reaching", "average", 1)
    change(data, "UPDATE imu_chunks SET data=zeroblob(length(data)) WHERE seq=3")
    called = call("replay", session)
    assert (called.code, called.out) == (1, "")
    assert f"of session {session} is damaged." in called.err


@pytest.mark.parametrize(
    ("changed", "code", "said"),
    [
        ("UPDATE sessions SET task='gone'", 2, "There is no task gone."),
        ("UPDATE sessions SET theme='gone'", 0, "The theme gone is not installed."),
        ("DELETE FROM messages", 0, "there is nothing to compare."),
    ],
)
def test_a_task_that_is_gone_is_needed_and_a_theme_and_messages_are_not(
    call: Call, data: Path, simulated: str, changed: str, code: int, said: str
) -> None:
    change(data, changed)
    called = call("replay", simulated)
    assert (called.code, said in called.out + called.err) == (code, True)

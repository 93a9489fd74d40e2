"""``sar-tui``, ``run`` and ``resume``: what the app is opened with. The app itself is tested
elsewhere.
"""

import importlib.util
import sqlite3
import tempfile
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from sar_tui.link.broker_process import BrokerProcess
from sar_tui.link.discovery import joinable_sessions, live_sessions
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import Plan
from sar_tui.store import participants, programmes
from sar_tui.store.database import connect
from sar_tui.store.programmes import Programme
from tests.program import Call

Opened = list[dict[str, Any]]


def save(data: Path, task: str, programme: Programme) -> None:
    with closing(connect(data)) as database:
        programmes.save(database, "P01", task, programme, after=0)


@pytest.fixture
def runtime() -> Iterator[str]:
    """A folder for sockets, whose paths must be short."""
    with tempfile.TemporaryDirectory(prefix="sar") as folder:
        yield folder


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch, runtime: str, data: Path) -> Opened:
    """Fake a terminal and an app, with two participants; return the arguments of each opening. The
    app exits with 7.
    """
    with closing(connect(data)) as database:
        for code in ("P01", "P02"):
            participants.add(database, code)
    calls: Opened = []

    def run_app(
        folder: Path,
        catalogue: Catalogue,
        plan: Plan | None = None,
        resume: str | None = None,
        link: BrokerProcess | None = None,
        **_: object,
    ) -> int:
        joinable = joinable_sessions(folder)
        calls.append(
            {"folder": folder, "plan": plan, "resume": resume, "link": link, "joinable": joinable}
        )
        return 7

    monkeypatch.setenv("XDG_RUNTIME_DIR", runtime)
    monkeypatch.setattr("sar_tui.app.app.run_app", run_app)
    stream = SimpleNamespace(isatty=lambda: True)
    streams = SimpleNamespace(stdin=stream, stdout=stream, stderr=stream)
    monkeypatch.setattr("sar_tui.cli.common.sys", streams)
    return calls


@pytest.fixture
def session(call: Call, data: Path) -> str:
    """Id of a live session that was interrupted."""
    session = call("simulate keyboard --user poor --attempts 1 --json").json["session"]
    with sqlite3.connect(data / "sar-tui.db") as connection:
        connection.execute("UPDATE sessions SET mode='live', status='running'")
    return str(session)


def test_without_a_command_the_app_opens(call: Call, opened: Opened, data: Path) -> None:
    assert call().code == 7
    (how,) = opened
    assert (how["folder"], how["plan"], how["resume"]) == (data, None, None)


def test_run_seats_two_left_and_right(call: Call, opened: Opened) -> None:
    assert call("run pairs -p p01 -p p02 --set policy=race").code == 7
    plan = opened[0]["plan"]
    assert (plan.task.name, plan.parameters.policy) == ("pairs", "race")
    assert (plan.participant, plan.partner) == ("P01", "P02")


JOINT = ("run", "pairs", "-p", "p01", "-p", "p02", "--set", "policy=joint attention")


@pytest.mark.parametrize(
    ("outputs", "cue", "does"),
    [
        ("speech", "gaze", "looks"),
        ("speech,tones:go", "both", "looks"),
        ("tones", "gesture", "points"),
        ("servo:123456", "gaze", "looks"),
        ("screen", "gaze", ""),
        ("speech,screen", "both", ""),
        ("servo", "gesture", ""),
    ],
)
def test_a_cue_that_no_output_can_show_is_refused(
    call: Call, opened: Opened, outputs: str, cue: str, does: str
) -> None:
    called = call(*JOINT, "--set", f"cue_by={cue}", "--outputs", outputs)
    assert (called.code, len(opened)) == ((2, 0) if does else (7, 1))
    if does:
        called.refused(f"needs an output that shows where the agent {does}: add screen")


def test_run_plans_a_live_session(call: Call, opened: Opened) -> None:
    run = "run keyboard -p p01 --set attempts=3 --theme high-contrast"
    for seed in ("--seed 5", "", ""):
        assert call(f"{run} {seed}").code == 7
    plan, *others = (how["plan"] for how in opened)
    assert (plan.task.name, plan.participant, plan.theme) == ("keyboard", "P01", "high-contrast")
    assert (plan.mode, plan.parameters.attempts) == ("live", 3)
    assert len({plan.seed, *(other.seed for other in others)}) == 3, "a new one is drawn"
    assert plan.seed == 5
    assert {(how["link"], *how["joinable"]) for how in opened} == {(None,)}, "nobody can join"


def test_run_starts_from_the_participants_settings(call: Call, opened: Opened, data: Path) -> None:
    kept = Programme({"attempts": 6, "prompts_per_attempt": 8}, "high-contrast")
    save(data, "keyboard", kept)
    call("run keyboard -p P01 --set attempts=2")
    plan = opened[0]["plan"]
    assert (plan.parameters.attempts, plan.parameters.prompts_per_attempt) == (2, 8)
    assert plan.theme == "high-contrast"


def test_a_motion_sensor_can_be_named(call: Call, opened: Opened, data: Path) -> None:
    save(data, "reaching", Programme({"imu": "phidget:1", "attempts": 3}))
    for option in ("--imu simulated:tremor", "--set imu=simulated:tremor", ""):
        assert call(f"run reaching -p P01 {option}").code == 7
    parameters = [how["plan"].parameters for how in opened]
    assert [p.imu for p in parameters] == ["simulated:tremor", "simulated:tremor", "phidget:1"]
    assert {p.attempts for p in parameters} == {3}


@pytest.fixture
def answers(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """Answers to the questions that the program will ask."""
    given: list[bool] = []
    monkeypatch.setattr("typer.confirm", lambda *_, **__: given.pop(0))
    return given


@pytest.mark.usefixtures("answers")
def test_resume_goes_on_with_the_session_that_is_named(
    call: Call, opened: Opened, data: Path, session: str
) -> None:
    call("simulate keyboard --user poor --attempts 1")
    with sqlite3.connect(data / "sar-tui.db") as connection:
        connection.execute("UPDATE sessions SET mode='live', status='running'")
    assert call("resume", session[:6]).code == 7
    assert opened[0]["resume"] == session


@pytest.mark.parametrize("arguments", ["", "last"])
def test_resume_without_an_id_says_whose_session_it_is_and_asks(
    call: Call, opened: Opened, session: str, answers: list[bool], arguments: str
) -> None:
    call("simulate keyboard --user poor --attempts 1")
    answers += [False, True]
    called = call("resume", *arguments.split())
    assert (called.code, opened, "Nothing was resumed." in called.out) == (1, [], True)
    called = call("resume", *arguments.split())
    assert (called.code, opened[0]["resume"]) == (7, session)
    assert f"The latest interrupted session is {session} of SIM: keyboard, began " in called.err
    assert "1 of 1 attempts done." in called.err
    assert call("resume --yes").code == 7, "a script is asked nothing"


def test_where_nobody_can_be_asked_the_session_must_be_named(call: Call, session: str) -> None:
    call("resume").refused(f"Name it: sar-tui resume {session}")


def test_a_session_that_was_not_interrupted_is_not_resumed(
    call: Call, opened: Opened, simulated: str
) -> None:
    call("resume").refused("There is no interrupted session to resume.")
    call("resume", simulated).refused("is simulated; only a live one that was interrupted")
    assert opened == []


# --- operators


def test_a_session_that_operators_may_join_is_found_while_it_runs(
    call: Call, opened: Opened
) -> None:
    assert call("run keyboard -p P01 --operator").code == 7
    (how,) = opened
    (live,) = how["joinable"]
    assert (live.session, live.task, live.participants) == (how["plan"].id, "keyboard", ("P01",))
    assert live.description.startswith("P01, keyboard, since ")
    assert how["link"].link == how["plan"].id
    assert how["link"].pid is None  # its process has ended
    assert live_sessions() == []


def test_a_resumed_session_can_be_joined_too(call: Call, opened: Opened, session: str) -> None:
    assert call("resume", session, "--operator").code == 7
    assert [live.session for live in opened[0]["joinable"]] == [session]


def test_a_link_that_cannot_be_is_refused_before_the_screen_changes(
    call: Call, opened: Opened, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = "run keyboard -p P01"
    call(f"{run} --listen tls/lab:none").refused("has no valid port")
    listened = call(f"{run} --listen tls/127.0.0.1:7447")
    listened.refused("Nobody has been invited yet", code=1)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    call(f"{run} --operator").refused("pip install -e '.[link]'", code=1)
    assert opened == []


# --- a participant who is not known


@pytest.mark.parametrize(("answer", "code", "plans"), [(False, 1, []), (True, 7, ["P0L"])])
def test_an_unknown_code_is_asked_about_before_the_screen_changes(
    call: Call,
    opened: Opened,
    monkeypatch: pytest.MonkeyPatch,
    answer: bool,
    code: int,
    plans: list[str],
) -> None:
    asked: list[str] = []
    monkeypatch.setattr("sar_tui.cli.common.is_interactive", lambda: True)
    monkeypatch.setattr("typer.confirm", lambda text, **_: asked.append(text) or answer)
    monkeypatch.setattr("sar_tui.cli.common.print", lambda *_, **__: None, raising=False)
    assert call("run keyboard -p P0l").code == code
    assert asked == ["There is no participant P0L. Is it P01? Is P0L a new participant?"]
    assert [how["plan"].participant for how in opened] == plans


def test_where_nobody_can_be_asked_a_new_participant_needs_to_be_said(
    call: Call, opened: Opened, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sar_tui.cli.common.is_interactive", lambda: False)
    call("run keyboard -p P0l").refused("give P01 if that is meant, or add --new")
    call("run keyboard -p P01 --new").refused()
    assert opened == []
    assert call("run keyboard -p P0l --new").code == 7
    assert call("run pairs -p P01 -p P03 --new").code == 7
    assert [how["plan"].participants for how in opened] == [("P0L",), ("P01", "P03")]

"""``sar-tui``, ``run`` and ``resume``: what the app is opened with. The app itself is tested
elsewhere.
"""

import importlib.util
import sqlite3
import tempfile
from collections.abc import Iterator, Sequence
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


@pytest.fixture
def runtime() -> Iterator[str]:
    """A folder for sockets, whose paths must be short."""
    with tempfile.TemporaryDirectory(prefix="sar") as folder:
        yield folder


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch, runtime: str, tmp_path: Path) -> list[dict[str, Any]]:
    """Fake a terminal and an app, with two participants; return the arguments of each opening. The
    app exits with 7.
    """
    with closing(connect(tmp_path / "data")) as database:
        for code in ("P01", "P02"):
            participants.add(database, code)
    calls: list[dict[str, Any]] = []

    def run_app(
        folder: Path,
        catalogue: Catalogue,
        plan: Plan | None = None,
        resume: str | None = None,
        link: BrokerProcess | None = None,
        patient: str = "",
        markers: Sequence[str] = (),
        sync_flash: bool = False,
    ) -> int:
        calls.append(
            {"folder": folder, "catalogue": catalogue, "plan": plan, "resume": resume, "link": link}
        )
        calls[-1]["patient"] = patient
        calls[-1]["markers"] = markers
        calls[-1]["joinable"] = joinable_sessions(folder)
        return 7

    monkeypatch.setenv("XDG_RUNTIME_DIR", runtime)
    monkeypatch.setattr("sar_tui.app.app.run_app", run_app)
    monkeypatch.setenv("TERM", "xterm-256color")
    stream = SimpleNamespace(isatty=lambda: True)
    monkeypatch.setattr(
        "sar_tui.cli.common.sys", SimpleNamespace(stdin=stream, stdout=stream, stderr=stream)
    )
    return calls


def interrupted(call: Call, folder: Path) -> str:
    """Id of a live session that was interrupted."""
    session = call("simulate keyboard --user poor --attempts 1 --json").json["session"]
    with sqlite3.connect(folder / "data" / "sar-tui.db") as connection:
        connection.execute(
            "UPDATE sessions SET mode='live', status='running' WHERE id=?", (session,)
        )
    return str(session)


def test_without_a_command_the_app_opens(
    call: Call, opened: list[dict[str, Any]], tmp_path: Path
) -> None:
    assert call().code == 7
    (how,) = opened
    assert (how["folder"], how["plan"], how["resume"]) == (tmp_path / "data", None, None)


def test_run_seats_two_left_and_right(call: Call, opened: list[dict[str, Any]]) -> None:
    assert call("run pairs -p p01 -p p02 --set policy=race").code == 7
    plan = opened[0]["plan"]
    assert (plan.task.name, plan.participant, plan.partner, plan.parameters.policy) == (
        "pairs",
        "P01",
        "P02",
        "race",
    )


JOINT = ("run", "pairs", "-p", "p01", "-p", "p02", "--set", "policy=joint attention")


@pytest.mark.parametrize(
    ("outputs", "cue", "does"),
    [
        ("speech", "gaze", "looks"),
        ("speech,tones:go", "both", "looks"),
        ("tones", "gesture", "points"),
        ("servo:123456", "gaze", "looks"),
    ],
)
def test_a_cue_that_no_output_can_show_is_refused(
    call: Call, opened: list[dict[str, Any]], outputs: str, cue: str, does: str
) -> None:
    called = call(*JOINT, "--set", f"cue_by={cue}", "--outputs", outputs)
    assert (called.code, opened) == (2, [])
    needed = (
        f"Joint attention needs an output that shows where the agent {does}: add screen to "
        "the outputs."
    )
    assert needed in called.err


@pytest.mark.parametrize(
    ("outputs", "cue"), [("screen", "gaze"), ("speech,screen", "both"), ("servo", "gesture")]
)
def test_a_cue_that_an_output_can_show_is_given(
    call: Call, opened: list[dict[str, Any]], outputs: str, cue: str
) -> None:
    assert call(*JOINT, "--set", f"cue_by={cue}", "--outputs", outputs).code == 7


def test_run_plans_a_live_session(call: Call, opened: list[dict[str, Any]]) -> None:
    options = ("--set", "attempts=3", "--theme", "high-contrast", "--seed", 5)
    assert call("run keyboard -p p01", *options).code == 7
    plan = opened[0]["plan"]
    assert (plan.task.name, plan.participant, plan.theme, plan.seed, plan.mode) == (
        "keyboard", "P01", "high-contrast", 5, "live",
    )  # fmt: skip
    assert plan.parameters.attempts == 3


def test_run_starts_from_the_participants_settings(
    call: Call, opened: list[dict[str, Any]], tmp_path: Path
) -> None:
    database = connect(tmp_path / "data")
    kept = Programme({"attempts": 6, "prompts_per_attempt": 8}, "high-contrast")
    programmes.save(database, "P01", "keyboard", kept, after=0)
    database.close()
    call("run keyboard -p P01 --set attempts=2")
    plan = opened[0]["plan"]
    assert (plan.parameters.attempts, plan.parameters.prompts_per_attempt, plan.theme) == (
        2,
        8,
        "high-contrast",
    )


def test_a_motion_sensor_can_be_named(
    call: Call, opened: list[dict[str, Any]], tmp_path: Path
) -> None:
    database = connect(tmp_path / "data")
    programmes.save(
        database, "P01", "reaching", Programme({"imu": "phidget:1", "attempts": 3}), after=0
    )
    database.close()
    assert call("run reaching -p P01 --imu simulated:tremor").code == 7
    assert call("run reaching -p P01 --set imu=simulated:tremor").code == 7
    assert call("run reaching -p P01").code == 7
    parameters = [how["plan"].parameters for how in opened]
    assert [p.imu for p in parameters] == ["simulated:tremor", "simulated:tremor", "phidget:1"]
    assert {p.attempts for p in parameters} == {3}


def test_each_session_draws_a_new_seed(call: Call, opened: list[dict[str, Any]]) -> None:
    for _ in range(2):
        call("run keyboard -p P01")
    assert opened[0]["plan"].seed != opened[1]["plan"].seed


@pytest.fixture
def answers(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """Answers to the questions that the program will ask."""
    given: list[bool] = []
    monkeypatch.setattr("typer.confirm", lambda *_, **__: given.pop(0))
    return given


def test_resume_goes_on_with_the_session_that_is_named(
    call: Call, opened: list[dict[str, Any]], tmp_path: Path, answers: list[bool]
) -> None:
    session = interrupted(call, tmp_path)
    interrupted(call, tmp_path)
    assert call("resume", session[:6]).code == 7
    assert opened[0]["resume"] == session


@pytest.mark.parametrize("arguments", [[], ["last"]], ids=["nothing", "last"])
def test_resume_without_an_id_says_whose_session_it_is_and_asks(
    call: Call,
    opened: list[dict[str, Any]],
    tmp_path: Path,
    answers: list[bool],
    arguments: list[str],
) -> None:
    session = interrupted(call, tmp_path)
    call("simulate keyboard --user poor --attempts 1")
    answers.append(True)
    called = call("resume", *arguments)
    assert (called.code, opened[0]["resume"]) == (7, session)
    assert f"The latest interrupted session is {session} of SIM: keyboard, began " in called.err
    assert "1 of 1 attempts done." in called.err


def test_a_session_that_was_not_meant_is_not_resumed(
    call: Call, opened: list[dict[str, Any]], tmp_path: Path, answers: list[bool]
) -> None:
    interrupted(call, tmp_path)
    answers.append(False)
    called = call("resume")
    assert (called.code, opened) == (1, [])
    assert "Nothing was resumed." in called.out


def test_a_script_resumes_the_latest_session_without_a_question(
    call: Call, opened: list[dict[str, Any]], tmp_path: Path, answers: list[bool]
) -> None:
    session = interrupted(call, tmp_path)
    assert call("resume --yes").code == 7
    assert opened[0]["resume"] == session


def test_where_nobody_can_be_asked_the_session_must_be_named(call: Call, tmp_path: Path) -> None:
    session = interrupted(call, tmp_path)
    called = call("resume")
    assert called.code == 2
    assert f"Name it: sar-tui resume {session}\n" in called.err


def test_resume_without_an_interrupted_session_is_bad_input(
    call: Call, opened: list[dict[str, Any]], simulated: str
) -> None:
    assert call("resume").err == "There is no interrupted session to resume.\n"
    assert call("resume").code == 2
    called = call("resume", simulated)
    assert called.code == 2
    assert "is simulated; only a live one that was interrupted" in called.err
    assert call("resume zzz").code == 2
    assert opened == []


# --- operators


def test_a_session_that_is_not_asked_to_opens_no_link(
    call: Call, opened: list[dict[str, Any]], runtime: str
) -> None:
    assert call("run keyboard -p P01").code == 7
    assert (opened[0]["link"], opened[0]["joinable"]) == (None, [])


def test_a_session_that_operators_may_join_is_found_while_it_runs(
    call: Call, opened: list[dict[str, Any]]
) -> None:
    assert call("run keyboard -p P01 --operator").code == 7
    (how,) = opened
    assert [(live.session, live.task, live.participants) for live in how["joinable"]] == [
        (how["plan"].id, "keyboard", ("P01",))
    ]
    assert how["joinable"][0].description.startswith("P01, keyboard, since ")
    assert how["link"].link == how["plan"].id
    assert how["link"].pid is None  # its process has ended
    assert live_sessions() == []


def test_a_resumed_session_can_be_joined_too(
    call: Call, opened: list[dict[str, Any]], tmp_path: Path
) -> None:
    session = interrupted(call, tmp_path)
    assert call("resume", session, "--operator").code == 7
    assert [live.session for live in opened[0]["joinable"]] == [session]


def test_an_invalid_listen_address_is_bad_usage(call: Call, opened: list[dict[str, Any]]) -> None:
    called = call("run keyboard -p P01 --listen tls/lab:none")
    assert (called.code, opened) == (2, [])
    assert "has no valid port" in called.err


def test_listening_without_invitations_is_refused_before_the_screen_changes(
    call: Call, opened: list[dict[str, Any]]
) -> None:
    called = call("run keyboard -p P01 --listen tls/127.0.0.1:7447")
    assert (called.code, opened) == (1, [])
    assert "Nobody has been invited yet" in called.err


def test_without_the_packages_of_the_link_it_is_reported_what_to_install(
    call: Call, opened: list[dict[str, Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    called = call("run keyboard -p P01 --operator")
    assert (called.code, opened) == (1, [])
    assert "pip install -e '.[link]'" in called.err


# --- a participant who is not known


@pytest.mark.parametrize(("answer", "code", "plans"), [(False, 1, []), (True, 7, ["P0L"])])
def test_an_unknown_code_is_asked_about_before_the_screen_changes(
    call: Call,
    opened: list[dict[str, Any]],
    monkeypatch: pytest.MonkeyPatch,
    answer: bool,
    code: int,
    plans: list[str],
) -> None:
    asked: list[str] = []
    monkeypatch.setattr("sar_tui.cli.common.is_interactive", lambda: True)
    monkeypatch.setattr(
        "sar_tui.cli.common.typer.confirm", lambda text, **_: asked.append(text) or answer
    )
    monkeypatch.setattr("sar_tui.cli.common.print", lambda *_, **__: None, raising=False)
    assert call("run keyboard -p P0l").code == code
    assert asked == ["There is no participant P0L. Is it P01? Is P0L a new participant?"]
    assert [how["plan"].participant for how in opened] == plans


def test_where_nobody_can_be_asked_a_new_participant_needs_to_be_said(
    call: Call, opened: list[dict[str, Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sar_tui.cli.common.is_interactive", lambda: False)
    refused = call("run keyboard -p P0l")
    assert refused == (
        2, "",
        "There is no participant P0L: give P01 if that is meant, or add --new for a new participant.\n"
    )  # fmt: skip
    assert call("run keyboard -p P01 --new").code == 2
    assert opened == []
    assert call("run keyboard -p P0l --new").code == 7
    assert call("run pairs -p P01 -p P03 --new").code == 7
    assert [how["plan"].participants for how in opened] == [("P0L",), ("P01", "P03")]

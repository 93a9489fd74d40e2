"""``sar-tui``, ``run`` and ``resume``: what the app is opened with. The app itself is tested
elsewhere.
"""

import importlib.util
import json
import sqlite3
import tempfile
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from sar_tui.link.discovery import joinable_sessions, live_sessions
from sar_tui.plugins import Catalogue
from sar_tui.store import participants, programmes
from sar_tui.store.database import connect
from sar_tui.store.programmes import Programme
from tests.outputs.markers.receivers import serial_line
from tests.program import Call

Opened = list[dict[str, Any]]
RUN = "run keyboard -p P01"
SIMULATE = "simulate keyboard --user average --seed 1 --attempts 1 --set prompts_per_attempt=2"


def save(data: Path, task: str, programme: Programme) -> None:
    with closing(connect(data)) as database:
        programmes.save(database, "P01", task, programme, after=0)


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch, data: Path) -> Iterator[Opened]:
    """Fake a terminal and an app, with two participants; yield the arguments of each opening. The
    app exits with 7.
    """
    with closing(connect(data)) as database:
        for code in ("P01", "P02"):
            participants.add(database, code)
    calls: Opened = []

    def run_app(folder: Path, catalogue: Catalogue, what: object = None, **given: Any) -> int:
        joinable = joinable_sessions(folder)
        calls.append({"folder": folder, "joinable": joinable, "what": what, **given})
        return 7

    monkeypatch.setattr("sar_tui.app.app.run_app", run_app)
    stream = SimpleNamespace(isatty=lambda: True)
    streams = SimpleNamespace(stdin=stream, stdout=stream, stderr=stream)
    monkeypatch.setattr("sar_tui.cli.common.sys", streams)
    with tempfile.TemporaryDirectory(prefix="sar") as sockets:
        monkeypatch.setenv("XDG_RUNTIME_DIR", sockets)
        yield calls


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
    assert (how["folder"], how["what"]) == (data, None)


def test_run_seats_two_left_and_right_each_with_a_sensor(call: Call, opened: Opened) -> None:
    settings = "--set policy=race --set respond_with=reaches"
    sensors = "--imu simulated --set imu_b=simulated:tremor"
    assert call(f"run pairs -p p01 -p p02 {settings} {sensors}").code == 7
    plan = opened[0]["what"]
    assert (plan.task.name, plan.parameters.policy) == ("pairs", "race")
    assert (plan.participant, plan.partner) == ("P01", "P02")
    assert (plan.parameters.imu, plan.parameters.imu_b) == ("simulated", "simulated:tremor")


JOINT = ("run", "pairs", "-p", "p01", "-p", "p02", "--set", "policy=joint attention")


@pytest.mark.parametrize(
    ("outputs", "cue", "does"),
    [
        ("speech,tones:go", "both", "looks"),
        ("tones", "gesture", "points"),
        ("servo:123456", "gaze", "looks"),
        ("screen", "gaze", ""),
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
    for seed in ("--seed 5", "", ""):
        assert call(f"{RUN} --set attempts=3 --theme high-contrast {seed}").code == 7
    plan, *others = (how["what"] for how in opened)
    assert (plan.task.name, plan.participant, plan.theme) == ("keyboard", "P01", "high-contrast")
    assert (plan.mode, plan.parameters.attempts) == ("live", 3)
    assert len({plan.seed, *(other.seed for other in others)}) == 3, "a new one is drawn"
    assert plan.seed == 5
    assert {(how["link"], *how["joinable"]) for how in opened} == {(None,)}, "nobody can join"


def test_options_override_the_participants_saved_settings_and_keep_the_rest(
    call: Call, opened: Opened, data: Path
) -> None:
    saved = {"attempts": 6, "prompts_per_attempt": 8, "outputs": ["screen", "tones"]}
    save(data, "keyboard", Programme({**saved, "language": "es"}, "high-contrast"))
    save(data, "reaching", Programme({"imu": "phidget:1"}))
    call(RUN)
    call(f"{RUN} --set attempts=2 --speech sound --language en")
    for option in ("--imu simulated:tremor", "--set imu=simulated:tremor", ""):
        assert call(f"run reaching -p P01 {option}").code == 7
    first, second, *reaching = (how["what"].parameters for how in opened)
    assert (first.attempts, first.outputs, first.language) == (6, ("screen", "tones"), "es")
    assert (second.attempts, second.language) == (2, "en")
    assert second.outputs == ("screen", "tones", "speech")
    assert (first.prompts_per_attempt, second.prompts_per_attempt) == (8, 8)
    assert [how["what"].theme for how in opened[:2]] == ["high-contrast"] * 2
    assert [each.imu for each in reaching] == ["simulated:tremor", "simulated:tremor", "phidget:1"]


def test_outputs_are_named_either_way_and_the_option_speech_adds_speech(
    call: Call, opened: Opened, tmp_path: Path
) -> None:
    where = f"file:{tmp_path}"
    cases: dict[str, tuple[object, str]] = {
        "--outputs screen,speech": (("screen", "speech"), ""),
        "--set outputs=screen,speech": (("screen", "speech"), ""),
        f"--speech {where}": (("screen", "speech"), where),
        f"--speech {where} --outputs tones,speech": (("tones", "speech"), where),
        f"--set speech={where}": (("screen",), where),
    }
    for options, (outputs, speech) in cases.items():
        assert call(f"{RUN} {options}").code == 7
        parameters = opened[-1]["what"].parameters
        assert parameters.outputs == outputs, options
        assert not speech or parameters.speech == speech, options


def test_a_simulated_session_speaks_the_language_it_is_given_and_into_files(
    call: Call, data: Path, tmp_path: Path
) -> None:
    assert call(f"{SIMULATE} --speech file:{tmp_path}/said").code == 0
    stored = call("show last --json").json["session"]["parameters"]
    assert (stored["outputs"], stored["speech"]) == (["screen", "speech"], f"file:{tmp_path}/said")
    for language, thanks in (("en", "Thank you"), ("es", "racias")):
        assert call(f"{SIMULATE} --language {language}").code == 0
        session = call("show last --json").json["session"]
        assert session["parameters"]["language"] == language
        with closing(connect(data)) as database:
            said = "SELECT final FROM actions WHERE kind='goodbye' ORDER BY rowid DESC"
            (final,) = database.execute(said).fetchone()
        assert thanks in json.loads(final)["text"]


@pytest.mark.parametrize("command", ["", RUN])
def test_the_app_and_a_session_are_opened_with_the_addresses_of_markers(
    call: Call, opened: Opened, command: str
) -> None:
    pytest.importorskip("serial")
    with serial_line() as line:
        to = ["udp://127.0.0.1:9", f"serial:{line.name}@9600", "udp://127.0.0.1:10"]
        assert call(f"{command} --markers {to[0]},{to[1]} --markers {to[2]}").code == 7
    assert call(f"{command} --sync-flash").code == 7
    found = [(how["markers"], how["sync_flash"]) for how in opened]
    assert found == [(tuple(to), False), ((), True)]


# --- resumed


def test_resume_goes_on_with_the_session_that_is_named(
    call: Call, opened: Opened, data: Path, session: str
) -> None:
    call("simulate keyboard --user poor --attempts 1")
    with sqlite3.connect(data / "sar-tui.db") as connection:
        connection.execute("UPDATE sessions SET mode='live', status='running'")
    assert call("resume", session[:6]).code == 7
    assert opened[0]["what"] == session


@pytest.mark.parametrize("arguments", ["resume", "resume last"])
def test_resume_without_an_id_says_whose_session_it_is_and_asks(
    call: Call,
    opened: Opened,
    session: str,
    monkeypatch: pytest.MonkeyPatch,
    arguments: str,
) -> None:
    call("simulate keyboard --user poor --attempts 1")
    answers = [False, True]
    monkeypatch.setattr("typer.confirm", lambda *_, **__: answers.pop(0))
    called = call(arguments)
    assert (called.code, opened, "Nothing was resumed." in called.out) == (1, [], True)
    called = call(arguments)
    assert (called.code, opened[0]["what"]) == (7, session)
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
    call: Call, opened: Opened, session: str
) -> None:
    assert call(f"{RUN} --operator").code == 7
    assert call("resume", session, "--operator").code == 7
    first, resumed = opened
    (live,) = first["joinable"]
    assert (live.session, live.task, live.participants) == (first["what"].id, "keyboard", ("P01",))
    assert live.description().startswith("P01, keyboard, since ")
    assert first["link"].link == first["what"].id
    assert first["link"].pid is None  # its process has ended
    assert [live.session for live in resumed["joinable"]] == [session]
    assert live_sessions() == []


def test_a_link_or_marker_that_cannot_be_is_refused_before_the_screen_changes(
    call: Call, opened: Opened, monkeypatch: pytest.MonkeyPatch
) -> None:
    call(f"{RUN} --listen tls/lab:none").refused("has no valid port")
    listened = call(f"{RUN} --listen tls/127.0.0.1:7447")
    listened.refused("Nobody has been invited yet", code=1)
    for place in ("lsl.find_spec", "serial_line.find_spec"):
        monkeypatch.setattr(f"sar_tui.outputs.markers.{place}", lambda name: None)
    for address in ("lsl", "serial:/dev/ttyUSB0"):
        extra = address.partition(":")[0]
        said = f"pip install -e '.[{extra}]'"
        call(f"{RUN} --markers {address}").refused(said, code=1)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    call(f"{RUN} --operator").refused("pip install -e '.[link]'", code=1)
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
    assert [how["what"].participant for how in opened] == plans


def test_where_nobody_can_be_asked_a_new_participant_needs_to_be_said(
    call: Call, opened: Opened, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sar_tui.cli.common.is_interactive", lambda: False)
    call("run keyboard -p P0l").refused("give P01 if that is meant, or add --new")
    call(f"{RUN} --new").refused()
    assert opened == []
    assert call("run keyboard -p P0l --new").code == 7
    assert call("run pairs -p P01 -p P03 --new").code == 7
    assert [how["what"].participants for how in opened] == [("P0L",), ("P01", "P03")]

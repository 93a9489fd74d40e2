"""The output of docs/add-an-output.md, taken from the page: it keeps the contract, and runs as the
page says.
"""

import os
import re
import select
import sqlite3
import sys
import tomllib
import tty
from collections.abc import Callable, Iterator
from importlib.metadata import EntryPoint
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.task import Task
from sar_tui.model.units import MS, SECOND
from sar_tui.outputs import outputs
from sar_tui.outputs.node import LONGEST_DETAIL, PER_CHARACTER, STOP_TIMEOUT, TIMEOUT
from sar_tui.outputs.output import OutputError
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from tests.outputs.contract import CHECKS, Rig
from tests.plugged_in import offer

PAGE = (Path(__file__).parents[2] / "docs" / "add-an-output.md").read_text(encoding="utf-8")


def block(language: str, number: int = 0) -> str:
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)[number]


@pytest.fixture
def serial_robot(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The page's module, as if it were installed, with its entry point."""
    module = ModuleType("serial_robot")
    exec(compile(block("python"), "serial_robot.py", "exec"), module.__dict__)
    monkeypatch.setitem(sys.modules, "serial_robot", module)
    ((name, value),) = tomllib.loads(block("toml"))["project"]["entry-points"][
        "sar_tui.outputs"
    ].items()
    entry = EntryPoint(name, value, "sar_tui.outputs")
    offer(monkeypatch, "sar_tui.outputs", [entry])
    return module


@pytest.fixture
def line() -> Iterator[tuple[str, Callable[[int], str]]]:
    """Path of a serial line, and a function that waits for a number of lines at its other end and
    returns them.
    """
    near, far = os.openpty()
    tty.setraw(far)

    def read_lines(lines: int) -> str:
        received = b""
        while received.count(b"\n") < lines and select.select([near], [], [], 30)[0]:
            received += os.read(near, 65536)
        return received.decode()

    yield os.ttyname(far), read_lines
    os.close(near)
    os.close(far)


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
def test_it_fulfils_the_contract(
    serial_robot: ModuleType, line: tuple[str, Callable[[int], str]], check: Callable[[Rig], None]
) -> None:
    rig = Rig(serial_robot.SerialRobot(line[0]), VirtualClock(), ["gesture"])
    check(rig)
    rig.output.close()


def test_it_sends_commands_and_stops_to_the_robot(
    serial_robot: ModuleType, line: tuple[str, Callable[[int], str]]
) -> None:
    path, read_lines = line
    rig = Rig(serial_robot.SerialRobot(path), VirtualClock(), ["gesture"])
    rig.ask("gesture", "one", "wave")
    rig.ask("gesture", "two", "nod")
    assert read_lines(1) == "wave 600\n"
    rig.clock.advance(650 * MS)  # type: ignore[attr-defined]
    rig.output.stop()
    assert read_lines(2) == "nod 400\nstill\n"


def test_a_missing_robot_fails_with_a_reason_and_may_be_connected_later(
    serial_robot: ModuleType, tmp_path: Path
) -> None:
    path = tmp_path / "ttyUSB0"
    rig = Rig(serial_robot.SerialRobot(str(path)), VirtualClock(), ["gesture"])
    rig.ask("gesture", "before")
    assert rig.states("before", "gesture") == ["failed"]
    assert rig.detail("before", "gesture").startswith("The robot cannot do wave. Plug it in")
    assert not path.exists()
    path.touch()
    rig.ask("gesture", "after")
    rig.wait_for("gesture", "after")
    assert rig.states("after", "gesture") == ["started", "done"]


def test_an_incomplete_address_is_reported(serial_robot: ModuleType) -> None:
    with pytest.raises(OutputError, match="Say which serial line"):
        outputs.check_outputs(["screen", "robot"])
    outputs.check_outputs(["screen", "robot:/dev/ttyUSB0"])


def test_in_a_session_it_waves_twice_and_the_query_of_the_page_finds_it(
    serial_robot: ModuleType,
    keyboard: type[Task],
    catalogue: Catalogue,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    robot = tmp_path / "robot.txt"
    robot.touch()
    settings: dict[str, Any] = {"attempts": 3, "outputs": ["screen", f"robot:{robot}"]}
    plan = make_plan(catalogue, keyboard, ["SIM"], settings, seed=1, mode="simulated")
    session = simulate(plan, PEOPLE["average"], tmp_path / "data", catalogue)
    *commands, last = robot.read_text().splitlines()
    assert (commands[0], commands[-1], last) == ("wave 1800", "wave 1800", "still")
    assert len(commands) >= 5, "a greeting, three answers, a goodbye"
    monkeypatch.chdir(tmp_path)
    exec(compile(block("python", 1), "query.py", "exec"), {})
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[4] for line in lines] == ["queued", "started", "done"] * len(commands)
    with sqlite3.connect(tmp_path / "data" / "sar-tui.db") as connection:
        (opened,) = connection.execute(
            "SELECT message FROM events WHERE session=? AND topic='output/opened'", (session,)
        ).fetchall()
    assert f"robot:{robot}" in opened[0]


def test_a_robot_that_cannot_be_stopped_is_reported(
    serial_robot: ModuleType, tmp_path: Path
) -> None:
    path = tmp_path / "ttyUSB0"
    path.touch()
    rig = Rig(serial_robot.SerialRobot(str(path)), VirtualClock(), ["gesture"])
    rig.ask("gesture", "a")
    path.unlink()
    rig.output.stop()
    assert rig.states("a", "gesture") == ["started", "aborted"]
    assert rig.detail("a", "gesture") == "The robot could not be stopped."


def test_it_is_fifty_lines_or_so() -> None:
    assert sum(bool(line.strip()) for line in block("python").splitlines()) <= 55


def test_the_page_names_the_time_limit_of_an_output() -> None:
    page = " ".join(PAGE.split())
    limit = (
        f"fails after {TIMEOUT // SECOND} seconds, plus {PER_CHARACTER // MS} ms per "
        "character for `say`"
    )
    assert limit in page
    assert f"A part that is not over after {STOP_TIMEOUT // SECOND} seconds has failed." in page
    assert f"Details are cut to {LONGEST_DETAIL} characters." in page

"""``--markers`` on the command line, ``sar-tui markers``, and what ``show`` tells of markers."""

import importlib.util
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgspec
import pytest

from sar_tui.loop.topics import MARKERS
from sar_tui.model.messages import MarkersChanged
from sar_tui.reports.output_summary import marker_summaries
from sar_tui.store.database import connect_to_read
from tests.cli.test_sessions import record
from tests.outputs.markers.receivers import serial_line, udp_receiver
from tests.program import Call

RUN = ("run", "keyboard", "-p", "P01", "--new")


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> list[Sequence[str]]:
    """Fake a terminal and an app; return the addresses of markers it was opened with."""
    calls: list[Sequence[str]] = []

    def run_app(*_: object, markers: Sequence[str] = (), **__: object) -> int:
        calls.append(markers)
        return 0

    monkeypatch.setattr("sar_tui.app.app.run_app", run_app)
    stream = SimpleNamespace(isatty=lambda: True)
    monkeypatch.setattr(
        "sar_tui.cli.common.sys", SimpleNamespace(stdin=stream, stdout=stream, stderr=stream)
    )
    return calls


@pytest.mark.parametrize("command", [(), RUN])
def test_the_app_and_a_session_are_opened_with_the_addresses(
    call: Call, opened: list[Sequence[str]], command: tuple[str, ...]
) -> None:
    pytest.importorskip("serial")
    with serial_line() as line:
        to = ["udp://127.0.0.1:9", f"serial:{line.name}@9600", "udp://127.0.0.1:10"]
        assert call(*command, "--markers", f"{to[0]},{to[1]}", "--markers", to[2]).code == 0
    assert opened == [tuple(to)]


def test_nothing_is_sent_unless_asked_for(call: Call, opened: list[Sequence[str]]) -> None:
    assert call(*RUN).code == 0
    assert opened == [()]


@pytest.mark.parametrize("command", [(), RUN])
def test_the_app_and_a_session_can_begin_with_a_flash(
    call: Call,
    opened: list[Sequence[str]],
    monkeypatch: pytest.MonkeyPatch,
    command: tuple[str, ...],
) -> None:
    flashes: list[bool] = []
    monkeypatch.setattr(
        "sar_tui.app.app.run_app", lambda *_, sync_flash, **__: flashes.append(sync_flash)
    )
    assert call(*command, "--sync-flash").code == 0
    assert call(*command).code == 0
    assert flashes == [True, False]
    called = call("--sync-flash sessions")
    assert called.code == 2
    assert "--sync-flash goes after the command" in called.err


@pytest.mark.parametrize(
    ("address", "package", "extra"),
    [("lsl", "pylsl", "lsl"), ("serial:/dev/ttyUSB0", "serial", "serial")],
)
def test_a_missing_package_is_named_before_the_screen_changes(
    call: Call,
    opened: list[Any],
    monkeypatch: pytest.MonkeyPatch,
    address: str,
    package: str,
    extra: str,
) -> None:
    find = importlib.util.find_spec
    module = {"lsl": "lsl", "serial": "serial_line"}[extra]
    monkeypatch.setattr(
        f"sar_tui.outputs.markers.{module}.find_spec",
        lambda name: None if name == package else find(name),
    )
    called = call(*RUN, "--markers", address)
    assert (called.code, opened) == (1, [])
    assert f"pip install -e '.[{extra}]'" in called.err


def test_test_markers_are_sent(call: Call) -> None:
    with udp_receiver() as receiver:
        called = call("markers", receiver.address, "--count", 3, "--every", 0)
        received = [receiver.next() for _ in range(3)]
    assert (called.code, called.out) == (0, f"{receiver.address}: 3 sent, 0 lost.\n")
    assert [(marker["event"], marker["number"]) for marker in received] == [
        ("test", n) for n in (1, 2, 3)
    ]


def test_show_says_where_markers_went_and_how_many_arrived(
    call: Call, simulated: str, tmp_path: Path
) -> None:
    common = {"destination": "lsl", "at": 1}
    for change in (
        MarkersChanged(**common, state="open", detail="LSL's clock minus the session's: 5 ns"),
        MarkersChanged(**common, state="failing", detail="It broke."),
        MarkersChanged(
            **common, state="closed", sent=7, lost=2, unheard=1, late_ms=0.25, latest_ms=1.5
        ),
    ):
        record(tmp_path, simulated, MARKERS.name, **msgspec.structs.asdict(change))
    assert (
        "Markers to lsl: 7 sent, 2 lost; 1 sent while nobody listened; prompts sent 0.2 ms after "
        "their onset, at most "
        "1.5 ms. It broke. LSL's clock minus the session's: 5 ns."
        in " ".join(call("show", simulated).out.split())
    )
    (summary,) = call("show", simulated, "--json").json["markers"]
    assert (summary["sent"], summary["lost"], summary["unfinished"]) == (7, 2, 0)
    opened = msgspec.structs.asdict(MarkersChanged(destination="udp://h:1", at=1, state="open"))
    record(tmp_path, simulated, MARKERS.name, **opened)
    assert (
        "Markers to udp://h:1: 0 sent, 0 lost; not counted in a run that was killed or is not over."
        in " ".join(call("show", simulated).out.split())
    )
    with connect_to_read(tmp_path / "data") as database:
        assert marker_summaries(database, "another") == []

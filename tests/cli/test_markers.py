"""``--markers`` on the command line, ``sar-tui markers``, and what ``show`` tells of markers."""

from collections.abc import Sequence
from importlib.util import find_spec
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

RUN = "run keyboard -p P01 --new"
Opened = list[tuple[Sequence[str], bool]]


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> Opened:
    """Fake a terminal and an app; return the addresses of markers it was opened with, and whether
    it begins with a flash.
    """
    calls: Opened = []

    def run_app(*_: object, markers: Sequence[str], sync_flash: bool, **__: object) -> int:
        calls.append((markers, sync_flash))
        return 0

    monkeypatch.setattr("sar_tui.app.app.run_app", run_app)
    stream = SimpleNamespace(isatty=lambda: True)
    streams = SimpleNamespace(stdin=stream, stdout=stream, stderr=stream)
    monkeypatch.setattr("sar_tui.cli.common.sys", streams)
    return calls


@pytest.mark.parametrize("command", ["", RUN])
def test_the_app_and_a_session_are_opened_with_the_addresses(
    call: Call, opened: Opened, command: str
) -> None:
    pytest.importorskip("serial")
    with serial_line() as line:
        to = ["udp://127.0.0.1:9", f"serial:{line.name}@9600", "udp://127.0.0.1:10"]
        assert call(f"{command} --markers {to[0]},{to[1]} --markers {to[2]}").code == 0
    assert call(f"{command} --sync-flash").code == 0
    assert call(command).code == 0
    assert opened == [(tuple(to), False), ((), True), ((), False)]


@pytest.mark.parametrize(
    ("address", "package", "module"),
    [("lsl", "pylsl", "lsl"), ("serial:/dev/ttyUSB0", "serial", "serial_line")],
)
def test_a_missing_package_is_named_before_the_screen_changes(
    call: Call,
    opened: Opened,
    monkeypatch: pytest.MonkeyPatch,
    address: str,
    package: str,
    module: str,
) -> None:
    place = f"sar_tui.outputs.markers.{module}.find_spec"
    monkeypatch.setattr(place, lambda name: None if name == package else find_spec(name))
    extra = address.partition(":")[0]
    call(f"{RUN} --markers {address}").refused(f"pip install -e '.[{extra}]'", code=1)
    assert opened == []


def test_test_markers_are_sent(call: Call) -> None:
    with udp_receiver() as receiver:
        called = call("markers", receiver.address, "--count", 3, "--every", 0)
        received = [receiver.next() for _ in range(3)]
    called.shows(f"{receiver.address}: 3 sent, 0 lost.\n")
    sent = [(marker["event"], marker["number"]) for marker in received]
    assert sent == [("test", n) for n in (1, 2, 3)]


def test_show_says_where_markers_went_and_how_many_arrived(
    call: Call, simulated: str, tmp_path: Path
) -> None:
    def record_change(destination: str, **change: Any) -> None:
        message = MarkersChanged(destination=destination, at=1, **change)
        record(tmp_path, simulated, MARKERS.name, **msgspec.structs.asdict(message))

    record_change("lsl", state="open", detail="LSL's clock minus the session's: 5 ns")
    record_change("lsl", state="failing", detail="It broke.")
    counts = {"sent": 7, "lost": 2, "unheard": 1, "late_ms": 0.25, "latest_ms": 1.5}
    record_change("lsl", state="closed", **counts)
    record_change("udp://h:1", state="open")
    shown = " ".join(call("show", simulated).out.split())
    for said in (
        "Markers to lsl: 7 sent, 2 lost; 1 sent while nobody listened; prompts sent 0.2 ms after",
        "at most 1.5 ms. It broke. LSL's clock minus the session's: 5 ns.",
        "Markers to udp://h:1: 0 sent, 0 lost; not counted in a run that was killed",
    ):
        assert said in shown
    summary, _ = call("show", simulated, "--json").json["markers"]
    assert (summary["sent"], summary["lost"], summary["unfinished"]) == (7, 2, 0)
    with connect_to_read(tmp_path / "data") as database:
        assert marker_summaries(database, "another") == []

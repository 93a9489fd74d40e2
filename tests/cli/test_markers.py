"""``sar-tui markers``, and what ``show`` tells of markers."""

from pathlib import Path
from typing import Any

import msgspec

from sar_tui.loop.topics import MARKERS
from sar_tui.model.messages import MarkersChanged
from sar_tui.reports.output_summary import marker_summaries
from sar_tui.store.database import connect_to_read
from tests.cli.test_sessions import record
from tests.outputs.markers.receivers import udp_receiver
from tests.program import Call


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

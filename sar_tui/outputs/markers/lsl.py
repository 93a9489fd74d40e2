"""Markers as a stream of the Lab Streaming Layer (LSL)."""

import time
from importlib.util import find_spec
from typing import Any

from sar_tui import __version__
from sar_tui.drivers import lsl
from sar_tui.model.units import MS, SECOND
from sar_tui.outputs.markers.marker import CODES, Marker, MarkerError

SAME_CLOCK_NS = 100_000
"""LSL's clock is ours if the two differ by less, which is then the time it takes to read them."""
_LAST_SECONDS = 0.1
"""Time for the last markers to leave, before the stream is closed."""


class Lsl:
    """Sends markers as an LSL stream ``sar-tui`` of the type ``Markers``: one channel of JSON
    texts, stamped exactly.

    LSL stamps are seconds of the host's monotonic clock: on Linux the clock of the session.
    Elsewhere the offset between the two is measured when the stream opens and added; how far it has
    drifted is measured at the end.
    """

    address = "lsl"

    def __init__(self) -> None:
        self._outlet: Any = None
        self._measured_ns = self._offset_ns = 0

    def check(self) -> None:
        if find_spec("pylsl") is None:
            raise MarkerError(lsl.no_package())
        _library()

    def open(self, session: str, task: str) -> str:
        pylsl = _library()
        self._measured_ns = lsl.clock_offset_ns(pylsl)
        self._offset_ns = 0 if abs(self._measured_ns) < SAME_CLOCK_NS else self._measured_ns
        info = pylsl.StreamInfo(
            "sar-tui", "Markers", 1, pylsl.IRREGULAR_RATE, pylsl.cf_string, f"sar-tui-{session}"
        )
        described = info.desc()
        for name, value in (
            ("session", session),
            ("task", task),
            ("version", __version__),
            ("clock_offset_ns", str(self._offset_ns)),
        ):
            described.append_child_value(name, value)
        channel = described.append_child("channels").append_child("channel")
        channel.append_child_value("label", "marker")
        channel.append_child_value("type", "Marker")
        events = described.append_child("events")
        for name in CODES:
            events.append_child_value("event", name)
        self._outlet = pylsl.StreamOutlet(info)
        return f"LSL's clock minus the session's: {self._measured_ns} ns"

    def send(self, marker: Marker) -> bool:
        heard = bool(self._outlet.have_consumers())
        self._outlet.push_sample([marker.text], (marker.ns + self._offset_ns) / SECOND)
        return heard

    def close(self) -> str:
        if self._outlet is None:
            return ""
        if self._outlet.have_consumers():
            time.sleep(_LAST_SECONDS)
        self._outlet = None
        drift_ns = lsl.clock_offset_ns(_library()) - self._measured_ns
        if abs(drift_ns) < SAME_CLOCK_NS:
            return ""
        return (
            f"LSL's clock and the session's drifted apart by {drift_ns / MS:.3f} ms: align by "
            "the prompts"
        )


def _library() -> Any:
    try:
        return lsl.library()
    except lsl.NoLibrary as error:
        raise MarkerError(str(error)) from error

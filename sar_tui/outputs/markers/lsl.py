"""Markers as a stream of the Lab Streaming Layer (LSL)."""

import contextlib
import os
import time
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from sar_tui import __version__
from sar_tui.drivers.installation import pip_install_extra
from sar_tui.loop.clock import host_now
from sar_tui.model.units import MS, SECOND
from sar_tui.outputs.markers.marker import CODES, Marker, MarkerError

SAME_CLOCK_NS = 100_000
"""LSL's clock is ours if the two differ by less, which is then the time it takes to read them."""
_READINGS = 50
_LAST_SECONDS = 0.1
"""Time for the last markers to leave, before the stream is closed."""
_QUIET = "[log]\nlevel = -3\n"
"""Lets LSL write nothing to the terminal, where its lines would cover the session's screen."""
_configured = False


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
            raise MarkerError(no_package())
        library()

    def open(self, session: str, task: str) -> str:
        pylsl = library()
        self._measured_ns = clock_offset_ns(pylsl)
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
        drift_ns = clock_offset_ns(library()) - self._measured_ns
        if abs(drift_ns) < SAME_CLOCK_NS:
            return ""
        return (
            f"LSL's clock and the session's drifted apart by {drift_ns / MS:.3f} ms: align by "
            "the prompts"
        )


def clock_offset_ns(pylsl: Any) -> int:
    """Return LSL's clock minus the session's, in ns: the reading of many that took least time."""
    readings = []
    for _ in range(_READINGS):
        before = host_now()
        theirs = float(pylsl.local_clock())
        after = host_now()
        readings.append((after - before, round(theirs * SECOND) - (before + after) // 2))
    return min(readings)[1]


def library() -> Any:
    """Import LSL, so that it stays quiet unless the user's own configuration says otherwise. Raises
    MarkerError.
    """
    global _configured  # noqa: PLW0603 - LSL reads its configuration once in a process
    try:
        import pylsl
    except (
        ImportError,
        OSError,
        RuntimeError,
    ) as error:  # its library written in C is missing or too old
        raise MarkerError(
            f"LSL cannot be loaded ({str(error).splitlines()[0]}). {no_package()}"
        ) from error
    if not _configured:
        _configured = True
        own = _own_configuration()
        if "[log]" not in own:
            # pylsl raises it for an older library of the system, which stays noisy but works
            with contextlib.suppress(NotImplementedError):
                pylsl.set_config_content(f"{own}\n{_QUIET}")
    return pylsl


def _own_configuration() -> str:
    """Return the configuration that LSL would read: the first of its usual files; empty if there is
    none.
    """
    named = os.environ.get("LSLAPICFG")
    usual = ("lsl_api.cfg", Path("~/lsl_api/lsl_api.cfg").expanduser(), "/etc/lsl_api/lsl_api.cfg")
    for path in [named] if named else usual:
        try:
            return Path(path).read_text(encoding="utf-8", errors="replace")
        except OSError:
            continue
    return ""


def no_package() -> str:
    """Return the sentence that says how to install what is missing."""
    return f"Markers over LSL need a package that is not installed here: {pip_install_extra('lsl')}"

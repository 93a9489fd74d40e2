"""Receivers of markers: a UDP socket, a serial line, an LSL inlet.

Tests are skipped where datagrams do not reach this machine itself, unless
``SAR_TUI_TEST_LSL=required``.
"""

import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import msgspec
import pytest

PATIENCE_S = 60.0
"""Longest wait for a marker, on a machine that is very busy."""
_IS_REQUIRED = os.environ.get("SAR_TUI_TEST_LSL") == "required"


class UdpReceiver:
    """A socket on this machine that receives markers."""

    def __init__(self) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._need_loopback()
        self._socket.settimeout(PATIENCE_S)
        self.address = f"udp://127.0.0.1:{self._socket.getsockname()[1]}"

    def _need_loopback(self) -> None:
        self._socket.settimeout(PATIENCE_S if _IS_REQUIRED else 2.0)
        try:
            self._socket.sendto(b"{}", self._socket.getsockname())
            self._socket.recv(16)
        except OSError:
            self.close()
            if _IS_REQUIRED:
                raise
            pytest.skip("datagrams do not arrive: there is no loopback network")

    def next(self) -> dict[str, Any]:
        marker: dict[str, Any] = msgspec.json.decode(self._socket.recv(65536))
        return marker

    def until(self, event: str) -> list[dict[str, Any]]:
        """Receive markers up to one of this event."""
        received = [self.next()]
        while received[-1]["event"] != event:
            received.append(self.next())
        return received

    def close(self) -> None:
        self._socket.close()


@contextmanager
def udp_receiver() -> Iterator[UdpReceiver]:
    receiver = UdpReceiver()
    try:
        yield receiver
    finally:
        receiver.close()


class Line:
    """A pseudo-terminal as a serial line: the end of the trigger box, and the name of the
    computer's end.
    """

    def __init__(self) -> None:
        self._box, self._computer = os.openpty()
        self.name = os.ttyname(self._computer)

    def read(self, count: int) -> bytes:
        """Read this many bytes."""
        got = b""
        while len(got) < count:
            got += os.read(self._box, count - len(got))
        return got

    def unplug(self) -> None:
        for end in (self._box, self._computer):
            if end >= 0:
                os.close(end)
        self._box = self._computer = -1


@contextmanager
def serial_line() -> Iterator[Line]:
    if os.name != "posix":
        pytest.skip("pseudo-terminals are needed in place of serial lines")
    line = Line()
    try:
        yield line
    finally:
        line.unplug()


def lsl_inlet(session: str) -> Any:
    """Return an inlet that receives the markers of a session, or skip the test if streams cannot be
    found here.
    """
    pylsl = pytest.importorskip("pylsl")
    UdpReceiver().close()
    found = pylsl.resolve_byprop(
        "source_id", f"sar-tui-{session}", 1, PATIENCE_S if _IS_REQUIRED else 10.0
    )
    if not found and not _IS_REQUIRED:
        pytest.skip("LSL finds no stream on this machine: it has no loopback network")
    inlet = pylsl.StreamInlet(found[0])
    inlet.open_stream(PATIENCE_S)
    return inlet

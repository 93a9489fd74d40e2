"""Destinations of markers, by their addresses."""

import re
import socket
from collections.abc import Iterable, Sequence

from sar_tui.outputs.markers.lsl import Lsl
from sar_tui.outputs.markers.marker import Destination, Marker, MarkerError
from sar_tui.outputs.markers.serial_line import SerialLine


def split_addresses(given: Iterable[str]) -> tuple[str, ...]:
    """Return the addresses in texts that each hold one or several, separated by commas."""
    return tuple(address.strip() for text in given for address in text.split(","))


def make_destinations(addresses: Sequence[str]) -> list[Destination]:
    """Return the destinations of addresses. Raises MarkerError if one is invalid or repeated."""
    made: list[Destination] = []
    for address in addresses:
        destination = _make(address)
        if any(destination.address == other.address for other in made):
            raise MarkerError(f"Markers are sent to {address} twice: leave one out.")
        made.append(destination)
    return made


def _make(address: str) -> Destination:
    if address == "lsl":
        return Lsl()
    if address.startswith("udp:"):
        return Udp(address)
    if address.startswith("serial:"):
        return SerialLine(address)
    raise MarkerError(
        f"Markers cannot be sent to {address!r}: use lsl, udp://HOST:PORT or serial:PORT."
    )


_ADDRESS = re.compile(r"udp://(?P<host>\[[0-9A-Fa-f:.%]+\]|[^\s:/\[\]]+):(?P<port>\d{1,5})/?")


class Udp:
    """Sends each marker as a datagram of JSON to ``udp://HOST:PORT``. Raises MarkerError if the
    address is invalid.
    """

    def __init__(self, address: str) -> None:
        match = _ADDRESS.fullmatch(address)
        if match is None or not 0 < int(match["port"]) < 65536:
            raise MarkerError(
                f"{address!r} is no address for markers: use udp://HOST:PORT, such as "
                "udp://10.0.0.5:5005."
            )
        self.address = address
        self._host, self._port = match["host"].strip("[]"), int(match["port"])
        self._socket: socket.socket | None = None
        self._to: tuple[object, ...] = ()

    def check(self) -> None:
        """Raise MarkerError if the host's name is unknown. That somebody listens there cannot be
        known.
        """
        self._resolve()

    def open(self, session: str, task: str) -> str:
        family, self._to = self._resolve()
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        return ""

    def send(self, marker: Marker) -> bool:
        assert self._socket
        try:
            self._socket.sendto(marker.text.encode(), self._to)
        except OSError as error:
            raise MarkerError(
                f"Nothing can be sent to {self.address}: {error.strerror or error}."
            ) from error
        return True

    def close(self) -> str:
        if self._socket:
            self._socket.close()
            self._socket = None
        return ""

    def _resolve(self) -> tuple[socket.AddressFamily, tuple[object, ...]]:
        try:
            found = socket.getaddrinfo(self._host, self._port, type=socket.SOCK_DGRAM)
        except (OSError, UnicodeError) as error:
            raise MarkerError(
                f"The computer {self._host} of {self.address} is not known here: check its name."
            ) from error
        return found[0][0], found[0][4]

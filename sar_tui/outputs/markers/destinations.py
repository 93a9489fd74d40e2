"""Destinations of markers, by their addresses."""

from collections.abc import Iterable, Sequence

from sar_tui.outputs.markers.destination import Destination
from sar_tui.outputs.markers.lsl import Lsl
from sar_tui.outputs.markers.marker import MarkerError
from sar_tui.outputs.markers.serial_line import SerialLine
from sar_tui.outputs.markers.udp import Udp


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

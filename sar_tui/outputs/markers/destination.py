"""The contract of a destination of markers."""

from typing import Protocol

from sar_tui.outputs.markers.marker import Marker


class Destination(Protocol):
    """A place to which markers are sent. All methods but ``check`` are called on one thread of its
    own.
    """

    address: str
    """As it was given; it names the destination in the log."""

    def check(self) -> None:
        """Raise MarkerError if nothing can be sent there now, before a session starts."""
        ...

    def open(self, session: str, task: str) -> str:
        """Open it for a session. Return a fact for the log, or an empty text. Raises
        MarkerError.
        """
        ...

    def send(self, marker: Marker) -> bool:
        """Send a marker. Return False if it is known that nobody received it. Raises
        MarkerError.
        """
        ...

    def close(self) -> str:
        """Release it. Return a fact for the log, or an empty text. May be called twice."""
        ...

"""Interface between the participant's program and the broker process.

Messages are put together here and encoded on another thread.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

from sar_tui.link import protocol
from sar_tui.link.peer import Welcome
from sar_tui.link.protocol import BrokerCommand, BrokerEvent
from sar_tui.loop.bus import Record
from sar_tui.model.messages import ActAnswered


class OutgoingBatch(NamedTuple):
    """Messages of the bus for all peers; batches are numbered from 1."""

    number: int
    records: Sequence[Record]

    def to_command(self) -> BrokerCommand:
        """Encode it as a command to the broker."""
        batch = protocol.Batch(self.number, protocol.encode_frames(self.records))
        return protocol.Publish(self.number, protocol.encode(batch))


class OutgoingSnapshot(NamedTuple):
    """State of the session after batch ``number``, for one peer."""

    name: str
    number: int
    welcome: Welcome
    records: Sequence[Record]

    def to_command(self) -> BrokerCommand:
        """Encode it as a command to the broker."""
        snapshot = protocol.Snapshot(
            self.number, self.welcome, protocol.encode_frames(self.records)
        )
        return protocol.SendTo(self.name, protocol.encode(snapshot))


class OutgoingAnswers(NamedTuple):
    """Answers to acts of one peer."""

    name: str
    answers: list[ActAnswered]

    def to_command(self) -> BrokerCommand:
        """Encode it as a command to the broker."""
        return protocol.SendTo(self.name, protocol.encode(protocol.Answers(self.answers)))


class OutgoingSamples(NamedTuple):
    """Samples of the sensor at a seat."""

    seat: str
    samples: bytes

    def to_command(self) -> BrokerCommand:
        """Encode it as a command to the broker."""
        return protocol.SensorSamples(self.seat, self.samples)


class BrokerEnded(NamedTuple):
    """The broker process ended. ``is_final``: it could not be restarted."""

    detail: str
    is_final: bool = False


Outgoing = OutgoingBatch | OutgoingSnapshot | OutgoingSamples | OutgoingAnswers
BrokerListener = Callable[[BrokerEvent | BrokerEnded], object]


class Channel(Protocol):
    """Connection of a node to the broker process."""

    def listen(self, listener: BrokerListener) -> None:
        """Call ``listener`` on any thread with each event, and first with those that came
        before.
        """

    def send(self, message: Outgoing) -> bool:
        """Queue a message without blocking; False, and it is dropped, if the queue is full."""

    def check(self) -> None:
        """Kill a broker process that no longer answers, so that it is restarted."""

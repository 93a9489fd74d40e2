"""What the participant's program hands to the link's process, and hears from it; made small here, encoded elsewhere."""

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

from sar_tui.framework.bus import Record
from sar_tui.link import protocol
from sar_tui.link.peer import Welcome
from sar_tui.link.protocol import BrokerCommand, BrokerEvent


class OutgoingBatch(NamedTuple):
    """What happened, to everybody; the batches are numbered from 1."""

    number: int
    records: Sequence[Record]

    def order(self) -> BrokerCommand:
        """As the broker takes it."""
        return protocol.Publish(
            self.number, protocol.encode(protocol.Batch(self.number, protocol.encode_frames(self.records)))
        )


class OutgoingSnapshot(NamedTuple):
    """How things stand after that batch, to one peer."""

    name: str
    number: int
    welcome: Welcome
    records: Sequence[Record]

    def order(self) -> BrokerCommand:
        """As the broker takes it."""
        greeting = protocol.Snapshot(self.number, self.welcome, protocol.encode_frames(self.records))
        return protocol.SendTo(self.name, protocol.encode(greeting))


class OutgoingSamples(NamedTuple):
    """A sensor's samples."""

    seat: str
    samples: bytes

    def order(self) -> BrokerCommand:
        """As the broker takes it."""
        return protocol.SensorSamples(self.seat, self.samples)


class BrokerEnded(NamedTuple):
    """The link's process ended, or was ended. ``is_final``: it could not be started anew."""

    detail: str
    is_final: bool = False


Outgoing = OutgoingBatch | OutgoingSnapshot | OutgoingSamples
BrokerListener = Callable[[BrokerEvent | BrokerEnded], object]


class Channel(Protocol):
    """The link's process, as a node sees it."""

    def listen(self, hear: BrokerListener) -> None:
        """Have ``hear`` told what comes, and what came before, on any thread."""

    def send(self, what: Outgoing) -> bool:
        """Put it on its way, at once; False, and it is gone, where too much is on its way already."""

    def check(self) -> None:
        """End a process that no longer answers, so that another takes its place."""

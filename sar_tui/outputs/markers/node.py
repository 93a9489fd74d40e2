"""Node that sends a session's markers."""

import threading
from collections.abc import Sequence
from functools import partial
from typing import Any, ClassVar, Literal

from sar_tui.loop.bus import Bus, Topic
from sar_tui.loop.clock import Clock
from sar_tui.loop.node import Node
from sar_tui.loop.topics import MARKERS
from sar_tui.model.messages import MarkersChanged, Message, Shown
from sar_tui.outputs.markers.destination import Destination
from sar_tui.outputs.markers.marker import Marker
from sar_tui.outputs.markers.sender import Changed, Sender
from sar_tui.outputs.markers.translation import Translation


class MarkerNode(Node):
    """Sends markers of the session's messages, and reports what became of them.

    It hands each marker to the threads that send it, and never waits.

    Args:
        destinations: where to.
        session: the session's id.
        task: its task's name.
        seats: the task's seats.
        clock: the session's clock.
    """

    name = "markers"
    emits: ClassVar[tuple[Topic[MarkersChanged], ...]] = (MARKERS,)

    def __init__(
        self,
        destinations: Sequence[Destination],
        session: str,
        task: str,
        seats: Sequence[str],
        clock: Clock,
    ) -> None:
        self._translation = Translation(session, seats)
        self._clock = clock
        self._early: list[MarkersChanged] | None = []
        self._lock = threading.Lock()
        self._is_attached = self._is_detached = False
        self._senders = [
            Sender(destination, session, task, self._change_of(destination.address), clock.now)
            for destination in destinations
        ]

    def attach(self, bus: Bus) -> None:
        """Join a bus, and report what happened to the destinations until now."""
        super().attach(bus)
        for topic in self._translation.topics:
            bus.subscribe(topic, partial(self._handle, topic), self.name)
        self._is_attached = True
        with self._lock:
            early, self._early = self._early, None
        for change in early or ():
            bus.post(MARKERS, change)

    def detach(self) -> None:
        """Send what is left, and report how many markers were sent and lost."""
        if self._is_detached:
            return
        self._is_detached = True
        for sender in self._senders:
            sender.finish()
            late_ms = sender.late_ms
            self._report(
                MarkersChanged(
                    destination=sender.address,
                    state="closed",
                    at=self._clock.now(),
                    detail=sender.closing,
                    sent=sender.sent,
                    lost=sender.lost,
                    unheard=sender.unheard,
                    late_ms=late_ms[0] if late_ms else None,
                    latest_ms=late_ms[1] if late_ms else None,
                )
            )

    def shown(self, shown: Shown) -> None:
        """Send the marker of a prompt that has just reached the terminal. Called from the thread
        that wrote it.
        """
        for marker in self._translation.shown(shown):
            self._put(marker)

    def _handle(self, topic: Topic[Any], message: Message) -> None:
        """Send the markers of a message, unless it was kept from an earlier run."""
        if self._is_attached:
            for marker in self._translation.markers(topic, self.now, message):
                self._put(marker)

    def _put(self, marker: Marker) -> None:
        for sender in self._senders:
            sender.put(marker)

    def _change_of(self, address: str) -> Changed:
        """Return the function that a sender's thread calls when its destination changes."""

        def changed(state: Literal["open", "failing", "working"], detail: str) -> None:
            self._report(
                MarkersChanged(
                    destination=address, state=state, at=self._clock.now(), detail=detail
                )
            )

        return changed

    def _report(self, change: MarkersChanged) -> None:
        with self._lock:
            if self._early is not None:
                self._early.append(change)
                return
        self.bus.post(MARKERS, change)

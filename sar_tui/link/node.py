"""The link on the bus: what happens goes out to peers, and what the operator with the baton does comes in."""

import functools
from typing import Any, ClassVar

import msgspec

from sar_tui.framework import messages as m
from sar_tui.framework.bus import Bus, Record, Topic
from sar_tui.framework.clock import MS, SECOND
from sar_tui.framework.node import Node
from sar_tui.framework.topics import DECISION, MODE, NOTE_ADDED, OPERATOR, PRESENCE, PROPOSAL_SEEN, REFUSED, REMARK
from sar_tui.link import protocol
from sar_tui.link.admission import role_of
from sar_tui.link.channel import BrokerEnded, Channel, OutgoingBatch, OutgoingSamples, OutgoingSnapshot
from sar_tui.link.control_lock import ControlLock
from sar_tui.link.feed import SENT, SessionFeed
from sar_tui.link.peer import Welcome
from sar_tui.link.protocol import (
    ActReceived,
    BrokerEvent,
    PeerJoined,
    PeerLeft,
    ProtocolError,
    RequestRefused,
    SnapshotRequested,
)
from sar_tui.link.rate_limit import RepeatThrottle

AFTER = 40 * MS
"""What happens goes out this much later, together with what has happened by then."""
PROMPT_PATIENCE = 500 * MS
"""A prompt that is on its way holds everything back, but no longer than this."""
OLDEST = 60 * SECOND
"""An act can have been this long ago, as its stamp tells; an older stamp is taken to be wrong."""
_CHECK = SECOND
_NO_BATON = "Another operator holds the baton."
_NO_SEAT = "There is no such seat in this session."


class LinkNode(Node):
    """Stands between the bus and the process that holds the link; it decides who of several operators acts.

    Args:
        channel: the process.

    Attributes:
        welcome: what the session is, to be set before it begins; each peer is told its own name and role with it.
    """

    welcome: Welcome

    name = "link"
    emits: ClassVar[tuple[Topic[Any], ...]] = (
        OPERATOR,
        DECISION,
        REMARK,
        MODE,
        PROPOSAL_SEEN,
        NOTE_ADDED,
        PRESENCE,
        REFUSED,
    )

    def __init__(self, channel: Channel) -> None:
        super().__init__()
        self._channel = channel
        self._feed = SessionFeed()
        self._baton = ControlLock()
        self._number = 0
        self._refused: RepeatThrottle[tuple[str, str, str]] = RepeatThrottle()
        self._to_greet: dict[str, None] = {}
        self._is_due = self._is_detached = False
        self._held_since: int | None = None

    def attach(self, bus: Bus) -> None:
        """Join a bus, and let the link's process talk."""
        super().attach(bus)
        for topic in SENT:
            if topic.keep:
                bus.subscribe(topic, functools.partial(self._feed.keep, topic), self.name)
        bus.tap(self._tapped)
        self._channel.listen(lambda news: bus.clock.call_soon(lambda: self.hear(news)))
        self._check()

    def detach(self) -> None:
        """Send what is left, and hear no more. The process is its opener's to end."""
        if hasattr(self, "bus") and not self._is_detached:
            self._send()
            self._is_detached = True

    # --- what comes in -----------------------------------------------------------------------------------------

    def hear(self, news: BrokerEvent | BrokerEnded) -> None:
        """Take news of the link's process, on the bus' own thread."""
        if self._is_detached:
            return
        match news:
            case PeerJoined(name=name):
                self._came(name)
            case PeerLeft(name=name, state=state, detail=detail):
                self._gone(name, state, detail)
            case SnapshotRequested(name=name):
                self._to_greet[name] = None
                self._schedule(0)
            case ActReceived(name=name, topic=protocol.TAKE_CONTROL):
                self._take_baton(name)
            case ActReceived():
                self._acted(news)
            case RequestRefused(name=name, what=what, why=why, count=count):
                self._tell_refused(name, what, why, count)
            case BrokerEnded(detail=detail, is_final=is_final):
                for name in list(self._baton.peers):
                    self._gone(name, "lost", detail)
                if is_final:
                    self._refuse("link", "the link", detail)

    def _came(self, name: str) -> None:
        role = role_of(name)
        if role is None or name in self._baton.peers:
            return
        holder = self._baton.holder
        self._baton.join(name, role)
        self._tell(name, role, "joined")
        self._tell_holder(holder)

    def _gone(self, name: str, state: str, detail: str) -> None:
        if (role := self._baton.peers.get(name)) is None:
            return
        holder = self._baton.holder
        self._baton.leave(name)
        self._to_greet.pop(name, None)
        self._tell(name, role, "left" if state == "left" else "lost", detail)
        self._tell_holder(holder)

    def _take_baton(self, name: str) -> None:
        holder = self._baton.holder
        if self._baton.take(name):
            self._tell_holder(holder)
        else:
            self._refuse(name, protocol.TAKE_CONTROL, "Only an operator who is there can take it.")

    def _acted(self, acted: ActReceived) -> None:
        """Post an act of the operator who may act; it carries their name, and a time at which it can have been."""
        if acted.name != self._baton.holder:
            if acted.topic != PROPOSAL_SEEN.name:  # another's panel shows what is offered, too
                self._refuse(acted.name, acted.topic, _NO_BATON)
            return
        try:
            act: Any = protocol.decode_act(acted.topic, acted.message)
        except ProtocolError as error:
            self._refuse(acted.name, acted.topic, str(error))
            return
        if self.welcome.participants and act.seat not in self.welcome.participants:
            self._refuse(acted.name, acted.topic, _NO_SEAT)
            return
        now = self.bus.clock.now()
        at = now if not act.at else min(now, max(act.at, now - OLDEST))
        self.emit(protocol.OPERATOR_TOPICS[acted.topic], msgspec.structs.replace(act, actor=acted.name, at=at))

    def _refuse(self, name: str, what: str, why: str) -> None:
        """Tell of it; what is refused again and again, once a second."""
        if count := self._refused.add((name, what, why), self.bus.clock.now()):
            self._tell_refused(name, what, why, count)

    def _tell_refused(self, name: str, what: str, why: str, count: int) -> None:
        self.emit(REFUSED, m.ActRefused(actor=name, what=what, why=why, count=count))

    def _tell_holder(self, before: str) -> None:
        """Tell who has the baton, if that is another one than before."""
        holder = self._baton.holder
        if holder and holder != before:
            self._tell(holder, "operator", "baton")

    def _tell(self, name: str, role: m.Role, state: Any, detail: str = "") -> None:
        changed = m.OperatorChanged(
            actor=name,
            role=role,
            state=state,
            operated=bool(self._baton.holder),
            holder=self._baton.holder,
            detail=detail,
            peers=dict(self._baton.peers),
        )
        self.emit(PRESENCE, changed)

    # --- what goes out -----------------------------------------------------------------------------------------

    def _tapped(self, cascade: list[Record]) -> None:
        self._feed.hear(cascade)
        if not self._baton.peers:
            self._feed.forget()
        elif self._feed.has_news:
            self._schedule(AFTER)

    def _schedule(self, after: int) -> None:
        if not self._is_due and not self._is_detached:
            self._is_due = True
            clock = self.bus.clock
            clock.call_at(clock.now() + after, self._due)

    def _due(self) -> None:
        """Send, unless a prompt is on its way to the screen: then a little later."""
        self._is_due = False
        if self._is_detached:
            return
        now = self.bus.clock.now()
        self._held_since = (self._held_since or now) if self._feed.awaits_onset else None
        if self._held_since is not None and now - self._held_since < PROMPT_PATIENCE:
            self._schedule(AFTER)
            return
        self._send()

    def _send(self) -> None:
        """Hand over what has happened, and greet who has to be greeted; what was lost is made good by a greeting."""
        missed = self._feed.missed
        if records := self._feed.take():
            self._number += 1
            missed |= not self._channel.send(OutgoingBatch(self._number, records))
        for seat, samples in self._feed.take_samples().items():
            self._channel.send(OutgoingSamples(seat, samples))
        if missed:
            self._to_greet |= dict.fromkeys(self._baton.peers)
        story = self._feed.story() if self._to_greet else []
        for name in list(self._to_greet):
            welcome = msgspec.structs.replace(self.welcome, name=name, role=role_of(name) or "observer")
            if self._channel.send(OutgoingSnapshot(name, self._number, welcome, story)):
                del self._to_greet[name]
        if self._to_greet:
            self._schedule(SECOND)

    def _check(self) -> None:
        """See from time to time that the link's process answers, and tell what was refused meanwhile."""
        if not self._is_detached:
            self._channel.check()
            clock = self.bus.clock
            for (name, what, why), count in self._refused.due(clock.now()):
                self._tell_refused(name, what, why, count)
            clock.call_at(clock.now() + _CHECK, self._check)

"""Admission of peers and their messages: who is admitted, what is forwarded, what is refused. No
Zenoh, no pipes.
"""

import re
import threading
from collections.abc import Callable, Hashable
from typing import Any, Generic, Literal, TypeVar

import msgspec

from sar_tui.link import protocol
from sar_tui.link.presence import MAX_PEERS, Presence, needs_control
from sar_tui.link.protocol import (
    ActReceived,
    AnswersRequested,
    BrokerEvent,
    PeerJoined,
    PeerLeft,
    PeerUnproven,
    Pong,
    ProtocolError,
    RequestRefused,
    SessionMessage,
    SnapshotRequested,
    VisitAsked,
)
from sar_tui.model.messages import ActAnswered, Role
from sar_tui.model.units import SECOND

K = TypeVar("K", bound=Hashable)

ACTS_PER_S, ACTS_BURST = 30, 60
"""Limit of what a peer sends; nobody types faster."""
SNAPSHOTS_PER_S, SNAPSHOTS_BURST = 1, 3
"""Limit of how often a peer is sent the whole state of the session."""


class TokenBucket:
    """Token bucket: ``rate`` tokens per second, at most ``burst`` at once."""

    def __init__(self, rate: float, burst: int) -> None:
        self._rate, self._burst = rate, burst
        self._tokens = float(burst)
        self._at: int | None = None

    def take(self, now: int) -> bool:
        """Take a token at ``now`` (ns, never decreasing); False if there is none."""
        if self._at is not None:
            self._tokens = min(self._burst, self._tokens + (now - self._at) / SECOND * self._rate)
        self._at = now
        if self._tokens < 1:
            return False
        self._tokens -= 1
        return True


class ReportThrottle(Generic[K]):
    """Limits reports of a repeated event: the first at once, then one per ``interval`` (ns) with a
    count.

    It tracks at most ``max_keys`` events at a time and drops others until there is room.
    """

    def __init__(self, interval: int = SECOND, max_keys: int = 100) -> None:
        self._interval, self._max_keys = interval, max_keys
        self._reported_at: dict[K, int] = {}
        self._counts: dict[K, int] = {}

    def add(self, key: K, now: int) -> int:
        """Count an event; return its count since the last report if a report is due, else 0."""
        if key not in self._reported_at and len(self._reported_at) >= self._max_keys:
            return 0
        self._counts[key] = self._counts.get(key, 0) + 1
        return self._take(key, now)

    def due(self, now: int) -> list[tuple[K, int]]:
        """Return the events to report now, with their counts, and forget those that stopped."""
        found = [(key, count) for key in list(self._counts) if (count := self._take(key, now))]
        over = [
            key
            for key, at in self._reported_at.items()
            if key not in self._counts and now - at >= self._interval
        ]
        for key in over:
            del self._reported_at[key]
        return found

    def _take(self, key: K, now: int) -> int:
        if key in self._reported_at and now - self._reported_at[key] < self._interval:
            return 0
        self._reported_at[key] = now
        return self._counts.pop(key)


_Limited = Literal["act", "answer", "ping", "snapshot"]
_MAX_BUCKETS = 64
_MAX_REFUSALS = 40
"""Different refusals reported per second."""
_NAME = re.compile(r"(operator|observer)\.[A-Za-z0-9][A-Za-z0-9_.-]{0,99}")

_TOO_FAST = f"It sends more than {ACTS_PER_S} messages a second."
_TOO_LONG = f"It is longer than {protocol.MAX_ACT_BYTES} bytes."
_OBSERVER = "An observer can only stop the agent."
_TAKEN = "This name is in use. Choose another one, or wait until its owner has left."
_FULL = "Too many people are already connected to this session."
DECLINED = "They would rather not be watched today."
VISIT_ENDED = "They have ended the visit."
_NOT_AGREED = "The participant has not agreed to this visit."
ASKING = "They are asked on their screen whether you may watch."
_UNATTENDED = "The terminal of this panel does not answer."
_NEVER_ANSWERED = "the terminal answers no queries."
_RELAYED = "tmux, screen, Zellij or mosh answers for the terminal."


def role_of(name: str) -> Role | None:
    """Return the role that a peer's name begins with, or None if it is not a valid name."""
    if not _NAME.fullmatch(name):
        return None
    return "operator" if name.startswith("operator.") else "observer"


class Consent:
    """Those whom the participant lets watch. Everybody else is told only that they are asked, or
    why not.

    Args:
        forget_after: silence (ns) after which somebody does not ask any longer.
    """

    def __init__(self, forget_after: int) -> None:
        self._forget_after = forget_after
        self._agreed: set[str] = set()
        self._asking: dict[str, int] = {}
        self._refusal = ""

    def admit(self, name: str) -> None:
        """Let somebody watch."""
        self._agreed.add(name)
        self._asking.pop(name, None)

    def deny(self, why: str) -> None:
        """Let nobody watch, for this reason."""
        self._agreed.clear()
        self._asking.clear()
        self._refusal = why

    def has_agreed(self, name: str) -> bool:
        """Return True if somebody may watch."""
        return name in self._agreed

    def ask(self, name: str, now: int) -> tuple[str, bool]:
        """Note that somebody wants to watch. Return what they are told, and True if the participant
        has to be asked.
        """
        if self._refusal:
            return self._refusal, False
        if name not in self._asking and len(self._asking) >= MAX_PEERS:
            return _FULL, False
        is_new = name not in self._asking
        self._asking[name] = now
        return ASKING, is_new

    def withdraw(self, name: str) -> bool:
        """Note that somebody does not want to watch any longer; False if they did not ask."""
        return self._asking.pop(name, None) is not None

    def expire(self, now: int) -> list[str]:
        """Return those who have fallen silent before they were answered, and forget them."""
        silent = [name for name, at in self._asking.items() if now - at > self._forget_after]
        for name in silent:
            del self._asking[name]
        return silent


class Admission:
    """Checks each message of a peer. Thread-safe.

    A peer's name is the last part of the key it sent to; on the network, its certificate allows no
    other.

    Args:
        lost_after: silence (ns) after which a peer is lost.
        notify: sends an event to the program.
        answer: sends a message to a peer.
        clock_id: id of the session's clock, see `remote_clock.clock_id`.
        is_visit: True if nobody is admitted before the participant agrees, see `admit`.

    Attributes:
        number: number of the last batch that was sent to all peers.
    """

    def __init__(
        self,
        lost_after: int,
        notify: Callable[[BrokerEvent], object],
        answer: Callable[[str, SessionMessage], object],
        clock_id: str,
        *,
        is_visit: bool = False,
    ) -> None:
        self._consent = Consent(lost_after) if is_visit else None
        self._notify, self._answer, self._clock_id = notify, answer, clock_id
        self._lock = threading.RLock()
        self._presence = Presence(lost_after)
        self._lost_after = lost_after
        self._buckets: dict[tuple[_Limited, str], TokenBucket] = {}
        self._refused: ReportThrottle[tuple[str, str, str]] = ReportThrottle(max_keys=_MAX_REFUSALS)
        self.number = 0

    @property
    def present(self) -> list[str]:
        """Names of those who are admitted and present."""
        with self._lock:
            return self._presence.names

    def admit(self, name: str) -> None:
        """Let somebody watch whom the participant agreed to."""
        with self._lock:
            if self._consent:
                self._consent.admit(name)

    def deny(self, why: str) -> None:
        """Let nobody watch any longer, for this reason."""
        with self._lock:
            if self._consent:
                self._consent.deny(why)
                for name in self._presence.names:
                    self._presence.leave(name)
                    self._notify(PeerLeft(name, "left", why))

    def _must_ask(self, name: str, now: int, *, is_leaving: bool) -> str:
        """Return what somebody is told whom the participant has not agreed to; empty if they have,
        or need not. Ask the participant, if they were not yet.
        """
        if self._consent is None or self._consent.has_agreed(name):
            return ""
        if is_leaving:
            if self._consent.withdraw(name):
                self._notify(VisitAsked(name, withdrawn=True))
            return ASKING
        told, is_new = self._consent.ask(name, now)
        if is_new:
            self._notify(VisitAsked(name))
        return told

    def receive_ping(self, name: str, payload: bytes, now: int) -> None:
        """Handle a heartbeat received at ``now`` (ns, the session's clock)."""
        with self._lock:
            if not self._bucket("ping", name).take(now):
                self.refuse(name, "a heartbeat", _TOO_FAST, now)
                return
            try:
                ping = self._decode(name, payload, protocol.Ping)
            except ProtocolError as error:
                self.refuse(name, "a heartbeat", str(error), now)
                return
            if told := self._must_ask(name, now, is_leaving=ping.is_leaving):
                self._answer(name, Pong(ping.sent_at, 0, "", 0, ping.client_id, told))
                return
            if ping.is_leaving:
                self._answer(
                    name, Pong(ping.sent_at, now, self._clock_id, self.number, ping.client_id)
                )
                if self._presence.is_present(name, ping.client_id) and self._presence.leave(name):
                    self._notify(PeerLeft(name, "left"))
                return
            refusal = self._admit(
                name, ping.client_id, now, ping.silence, is_relayed=ping.is_relayed
            )
            self._answer(
                name, Pong(ping.sent_at, now, self._clock_id, self.number, ping.client_id, refusal)
            )
            if ping.wants_snapshot and not refusal and self._bucket("snapshot", name).take(now):
                self._notify(SnapshotRequested(name))
            if ping.unanswered and not refusal:
                self._notify(AnswersRequested(name, ping.unanswered))

    def receive_act(self, name: str, payload: bytes, now: int) -> None:
        """Handle an act received at ``now``: pass it on, or answer why not."""
        with self._lock:
            what, id = "an act", ""
            is_too_fast = not self._bucket("act", name).take(now)
            try:
                act = self._decode(name, payload, protocol.ActRequest)
                id = act.id
                if act.topic in protocol.OPERATOR_TOPICS:
                    what = act.topic
                if is_too_fast:
                    raise ProtocolError(_TOO_FAST)
                if self._consent and not self._consent.has_agreed(name):
                    raise ProtocolError(_NOT_AGREED)
                takes_control = act.topic == protocol.TAKE_CONTROL
                is_for_all = not takes_control and not needs_control(
                    protocol.decode_act(act.topic, act.message)
                )
                if role_of(name) == "observer" and not is_for_all:
                    raise ProtocolError(_OBSERVER)
                if refusal := self._admit(name, act.client_id, now, act.silence):
                    raise ProtocolError(refusal)
            except ProtocolError as error:
                self.refuse(name, what, str(error), now)
                if self._consent and not self._consent.has_agreed(name):
                    return
                # the panel asks for what a flood leaves unanswered
                if id and self._bucket("answer", name).take(now):
                    refused = ActAnswered(
                        id=id, actor=name, outcome="refused", why=str(error), at=now
                    )
                    self._answer(name, protocol.Answers([refused]))
                return
            self._notify(ActReceived(name, act.topic, act.message, id))

    def disconnect(self, name: str, now: int) -> None:
        """Handle a connection that broke at ``now`` without a goodbye: its peer is lost at once.

        If the peer was silent before, Zenoh gave up a connection that it may restore, so only
        ``tick`` counts it as lost.
        """
        with self._lock:
            if not self._presence.is_silent(name, now) and self._presence.leave(name):
                self._notify(PeerLeft(name, "lost", "The connection broke."))

    def tick(self, now: int) -> None:
        """Report peers that are lost or unproven, and requests that were refused, since the last
        tick.
        """
        ms = self._lost_after // 1_000_000
        with self._lock:
            for name, cause in self._presence.expire(now):
                why = (
                    f"No heartbeat for {ms} ms."
                    if cause == "silent"
                    else f"Its terminal did not answer for {ms} ms."
                )
                self._notify(PeerLeft(name, "lost", why))
            for name, doubt in self._presence.unproven(now):
                if role_of(name) == "operator":
                    self._notify(
                        PeerUnproven(name, _RELAYED if doubt == "relayed" else _NEVER_ANSWERED)
                    )
            for name in self._consent.expire(now) if self._consent else ():
                self._notify(VisitAsked(name, withdrawn=True))
            for (name, what, why), count in self._refused.due(now):
                self._notify(RequestRefused(name, what, why, count))

    def refuse(self, name: str, what: str, why: str, now: int) -> None:
        """Report, throttled, that a request was refused.

        An invalid name is replaced by "unknown", as it may be of any length and contain anything.
        """
        name = name if role_of(name) else "unknown"
        with self._lock:
            if count := self._refused.add((name, what, why), now):
                self._notify(RequestRefused(name, what, why, count))

    def _admit(
        self,
        name: str,
        client_id: str,
        now: int,
        silence: int | None,
        *,
        is_relayed: bool | None = None,
    ) -> str:
        """Record a heartbeat; return why its sender is not admitted, or an empty string."""
        match self._presence.heartbeat(name, client_id, now, silence, is_relayed=is_relayed):
            case "joined":
                self._notify(PeerJoined(name))
            case "taken":
                return _TAKEN
            case "full":
                return _FULL
            case "unattended":
                return _UNATTENDED
        return ""

    def _decode(self, name: str, payload: bytes, kind: type[msgspec.Struct]) -> Any:
        if role_of(name) is None:
            raise ProtocolError("It does not say who sent it.")
        if len(payload) > protocol.MAX_ACT_BYTES:
            raise ProtocolError(_TOO_LONG)
        return protocol.decode(payload, kind)

    def _bucket(self, what: _Limited, name: str) -> TokenBucket:
        """Return the bucket of a peer; beyond ``_MAX_BUCKETS``, peers share one."""
        key = (
            what,
            name if (what, name) in self._buckets or len(self._buckets) < _MAX_BUCKETS else "",
        )
        if key not in self._buckets:
            rate = (
                (SNAPSHOTS_PER_S, SNAPSHOTS_BURST)
                if what == "snapshot"
                else (ACTS_PER_S, ACTS_BURST)
            )
            self._buckets[key] = TokenBucket(*rate)
        return self._buckets[key]

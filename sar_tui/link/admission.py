"""What the broker makes of what peers send: who is let in, what is handed on, what is refused. No Zenoh, no pipes."""

import re
import threading
from collections.abc import Callable
from typing import Any, Literal

import msgspec

from sar_tui.framework.messages import Role
from sar_tui.link import protocol
from sar_tui.link.presence import Presence
from sar_tui.link.protocol import (
    ActReceived,
    BrokerEvent,
    PeerJoined,
    PeerLeft,
    Pong,
    ProtocolError,
    RequestRefused,
    SessionMessage,
    SnapshotRequested,
)
from sar_tui.link.rate_limit import RepeatThrottle, TokenBucket

ACTS_PER_S, ACTS_AT_ONCE = 30, 60
"""What a peer may send; nobody's fingers are faster."""
_GREETINGS_PER_S, _GREETINGS_AT_ONCE = 1, 3
_MOST_BUCKETS = 64
_MOST_REFUSALS = 40
"""Of different ones so many are told in a second."""
_NAME = re.compile(r"(operator|observer)\.[A-Za-z0-9][A-Za-z0-9_.-]{0,99}")

_TOO_FAST = f"It sends more than {ACTS_PER_S} messages a second."
_TOO_LONG = f"It is longer than {protocol.MAX_ACT_BYTES} bytes."
_OBSERVER = "An observer cannot act."
_TAKEN = "Somebody who is there already has this name. Choose another one, or wait until they have gone."
_FULL = "There are too many at this session already."


def role_of(name: str) -> Role | None:
    """The role that a peer's name begins with; None where it is no name of a peer."""
    if not _NAME.fullmatch(name):
        return None
    return "operator" if name.startswith("operator.") else "observer"


class Admission:
    """Looks at each message of a peer; from any thread.

    A peer's name is taken from the key that it sent to, which on the network its certificate allows it alone.

    Args:
        patience: how long (ns) a peer may be silent.
        tell: hands news to the program.
        answer: sends a peer an answer.
        host: whose clock it is, see `remote_clock.clock_id`.

    Attributes:
        number: of the last batch that was sent to everybody.
    """

    def __init__(
        self,
        patience: int,
        tell: Callable[[BrokerEvent], object],
        answer: Callable[[str, SessionMessage], object],
        host: str,
    ) -> None:
        self._tell, self._answer, self._host = tell, answer, host
        self._lock = threading.RLock()
        self._presence = Presence(patience)
        self._patience = patience
        self._paces: dict[tuple[Literal["act", "hello", "greeting"], str], TokenBucket] = {}
        self._refused: RepeatThrottle[tuple[str, str, str]] = RepeatThrottle(most=_MOST_REFUSALS)
        self.number = 0

    def hello(self, name: str, payload: bytes, now: int) -> None:
        """A sign of life came at ``now`` (ns, the session's clock)."""
        with self._lock:
            if not self._pace("hello", name).take(now):
                self.refuse(name, "a sign of life", _TOO_FAST, now)
                return
            try:
                hello = self._read(name, payload, protocol.Ping)
            except ProtocolError as error:
                self.refuse(name, "a sign of life", str(error), now)
                return
            if hello.leaves:
                self._answer(name, Pong(hello.ping, now, self._host, self.number, hello.who))
                if self._presence.is_there(name, hello.who) and self._presence.leave(name):
                    self._tell(PeerLeft(name, "left"))
                return
            refusal = self._let_in(name, hello.who, now)
            self._answer(name, Pong(hello.ping, now, self._host, self.number, hello.who, refusal))
            if hello.wants and not refusal and self._pace("greeting", name).take(now):
                self._tell(SnapshotRequested(name))

    def act(self, name: str, payload: bytes, now: int) -> None:
        """An act came at ``now``."""
        with self._lock:
            if not self._pace("act", name).take(now):
                self.refuse(name, "an act", _TOO_FAST, now)
                return
            what = "an act"
            try:
                act = self._read(name, payload, protocol.ActRequest)
                if role_of(name) == "observer":
                    raise ProtocolError(_OBSERVER)
                if act.topic in protocol.OPERATOR_TOPICS:
                    what = act.topic
                    protocol.decode_act(act.topic, act.message)
                elif act.topic != protocol.TAKE_CONTROL:
                    raise ProtocolError("It is not among what an operator may send.")
                if refusal := self._let_in(name, act.who, now):
                    raise ProtocolError(refusal)
            except ProtocolError as error:
                self.refuse(name, what, str(error), now)
                return
            self._tell(ActReceived(name, act.topic, act.message))

    def gone(self, name: str) -> None:
        """A peer's connection closed without a goodbye."""
        with self._lock:
            if self._presence.leave(name):
                self._tell(PeerLeft(name, "lost", "The connection broke."))

    def tick(self, now: int) -> None:
        """Time passes: tell who is lost, and what was refused meanwhile."""
        with self._lock:
            for name in self._presence.overdue(now):
                self._tell(PeerLeft(name, "lost", f"Nothing was heard for {self._patience // 1_000_000} ms."))
            for (name, what, why), count in self._refused.due(now):
                self._tell(RequestRefused(name, what, why, count))

    def refuse(self, name: str, what: str, why: str, now: int) -> None:
        """Tell that something of a peer's was refused; not each time, where it is often.

        What is no name of a peer is not repeated: it may be as long, and hold whatever, its sender likes.
        """
        name = name if role_of(name) else "unknown"
        with self._lock:
            if count := self._refused.add((name, what, why), now):
                self._tell(RequestRefused(name, what, why, count))

    def _let_in(self, name: str, who: str, now: int) -> str:
        """Take a sign of life: why its sender is not let in, or empty."""
        match self._presence.hear(name, who, now):
            case "joined":
                self._tell(PeerJoined(name))
            case "taken":
                return _TAKEN
            case "full":
                return _FULL
        return ""

    def _read(self, name: str, payload: bytes, kind: type[msgspec.Struct]) -> Any:
        if role_of(name) is None:
            raise ProtocolError("It does not say who it is from.")
        if len(payload) > protocol.MAX_ACT_BYTES:
            raise ProtocolError(_TOO_LONG)
        return protocol.decode(payload, kind)

    def _pace(self, what: Literal["act", "hello", "greeting"], name: str) -> TokenBucket:
        """Of a peer; whoever comes after many names shares one with the rest."""
        key = (what, name if (what, name) in self._paces or len(self._paces) < _MOST_BUCKETS else "")
        if key not in self._paces:
            rate = (_GREETINGS_PER_S, _GREETINGS_AT_ONCE) if what == "greeting" else (ACTS_PER_S, ACTS_AT_ONCE)
            self._paces[key] = TokenBucket(*rate)
        return self._paces[key]

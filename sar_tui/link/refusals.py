"""Who was refused, and why: read off the log of zenoh, which tells it nowhere else.

Zenoh writes its log to *standard output*, a line at a time. Whoever wants to read it gives the process that holds zenoh
the environment of ``log_environment`` and a pipe of its own in place of standard output, has zenoh begin its log
(``zenoh.init_log_from_env_or``), and reads the pipe for as long as that process runs: zenoh's network threads wait for
a full pipe. A line may hold a secret: nothing of it but what is made here of it goes anywhere. And it may hold what a
guest chose, line breaks and all: what is read here is for the record, and decides nothing.
"""

import re
from collections.abc import Iterable
from typing import Literal, NamedTuple, TypeVar

HOST_LOG = (
    "error,zenoh_link_tls::unicast=debug,zenoh_link_commons::tls=warn,"
    "zenoh_transport::unicast::establishment::accept=debug,zenoh::net::routing::interceptor::access_control=trace"
)
"""What a host has to log for its refusals to be seen; access control tells of what it denies at this level alone."""
GUEST_LOG = "error,zenoh::net::runtime::orchestrator=warn"
"""What a guest has to log for ``why_not_connected``."""
_MOST_KNOWN = 64
T = TypeVar("T")
_LONGEST_KEY = 120


class Refusal(NamedTuple):
    """A connection that was not accepted or was ended, or a message that was dropped.

    ``guest``: as in ``operator.anna``; empty where nobody proved who they are. ``why`` goes on from "Refused: ".
    """

    what: Literal["connection", "message"]
    guest: str
    why: str


def log_environment(levels: str) -> dict[str, str]:
    """What the environment of the process that holds zenoh has to say: how much is logged, and without colours."""
    return {"RUST_LOG": levels, "NO_COLOR": "1"}


_LINE = re.compile(r"^\S+ +(?P<level>[A-Z]+) +(?P<thread>\S.*?) (?P<target>zenoh\w*(?:::\w+)+): (?P<text>.*)$")
_ACCEPTED = re.compile(r"Accepted TLS connection on \S+: (?P<address>\S+)\. Common Name: (?P<guest>.+)\.$")
_TRANSPORT = re.compile(r"New transport link accepted from (?P<zid>[0-9a-f]+) to .* dst: tls/(?P<address>[^,\s]+),")
_JUDGED = re.compile(
    r"(?:Using cached result: )?(?P<zid>[0-9a-f]+) (?:on \S*?CertCommonName\((?P<guest>[^)]*)\)\S* )?(?:on \S+ )?"
    r"is (?P<verdict>authorized|unauthorized) to (?P<act>[A-Za-z/ ]+) \(ingress\) on (?P<key>.*)$"
)
_FORESEEN = re.compile(r"ACL \(ingress\): caching permissions for `(?P<key>.*)` \.\.\.$")
_ENDED = re.compile(r"Closing TLS link \S+ => (?P<address>\S+) : remote certificate chain expired")

_ACTS = {
    "Put": "send among",
    "Delete": "delete among",
    "Query": "ask for",
    "Reply": "answer for",
    "Declare/Undeclare Subscriber": "listen to",
    "Declare/Undeclare Queryable": "offer to answer for",
    "Liveliness Token": "sign itself in among",
    "Liveliness Query": "see whether there is",
    "Declare/Undeclare Liveliness Subscriber": "watch for",
}
"""What Zenoh calls them, and what they are to somebody who reads the record."""

_CERTIFICATE = (
    ("peer sent no certificates", "it has no certificate"),
    ("certificate expired", "its invitation has expired"),
    ("certificate not valid yet", "its certificate is not valid yet: one of the two clocks is wrong"),
    ("UnknownIssuer", "its certificate was made by another authority"),
    ("BadSignature", "its certificate was made by another authority"),
    ("invalid peer certificate", "its certificate is not one for a guest"),
    ("received fatal alert", "it does not trust this host's certificate"),
    ("peer is incompatible", "its TLS is too old"),
    ("corrupt message", "it does not speak TLS"),
    ("handshake eof", "it hung up before it said who it is"),
)
_NOT_CONNECTED = (
    ("alert: CertificateExpired", "The invitation has expired. Ask for a new one."),
    (
        "alert: UnknownCA",
        "The session there does not know this invitation: it was made for another data folder. Ask for a new one.",
    ),
    (
        "alert: DecryptError",
        "The session there does not know this invitation: it was made for another data folder. Ask for a new one.",
    ),
    ("alert: ", "The session there refused the certificate of this invitation. Ask for a new one."),
    ("not valid for name", "What answers there is a host that goes by other names. Ask for a new invitation."),
    ("certificate expired", "The certificate of the session there has expired. Have the session begun anew."),
    ("invalid peer certificate", "What answers there is not the host that this invitation was made by."),
    (
        "Connection refused",
        "Nothing listens there. Is a session running, with --listen and that port?",
    ),
    ("failed to lookup address", "There is no computer of that name on the network."),
)
_CANNOT = "The session there cannot be reached."


class Refusals:
    """Reads a host's log. It remembers which connection is whose, as some lines tell no name.

    Args:
        guests: who may come, as in ``operator.anna``.
    """

    def __init__(self, guests: Iterable[str]) -> None:
        self._guests = frozenset(guests)
        self._at: dict[str, str] = {}
        self._zid: dict[str, str] = {}
        self._foreseen: dict[str, tuple[str, set[str]]] = {}

    def heard(self, line: str) -> Refusal | None:
        """The refusal that a line of the log tells of, if it does."""
        found = _LINE.match(line)
        if found is None:
            return None
        text = found["text"]
        if judged := _JUDGED.match(text):
            return self._judged(found["thread"], judged, cached=text.startswith("Using"))
        if foreseen := _FORESEEN.match(text):
            _remember(self._foreseen, found["thread"], (foreseen["key"], set()))
        elif transport := _TRANSPORT.match(text):
            _remember(self._zid, transport["zid"], self._at.get(transport["address"], ""))
        elif accepted := _ACCEPTED.match(text):
            _remember(self._at, accepted["address"], accepted["guest"])
            if accepted["guest"] not in self._guests:
                why = "its invitation was revoked, or is not known here"
                return Refusal("connection", _shown(accepted["guest"]), why)
        elif ended := _ENDED.match(text):
            return Refusal("connection", self._at.get(ended["address"], ""), "its invitation has expired")
        elif found["target"] == "zenoh_link_tls::unicast" and found["level"] == "WARN":
            return Refusal("connection", "", _first(_CERTIFICATE, text) or "it could not prove who it is")
        return None

    def _judged(self, thread: str, judged: re.Match[str], *, cached: bool) -> Refusal | None:
        """What was judged, unless nobody did it.

        When a guest shortens a key, zenoh judges at once all that could be done there, and says so as if it had been.
        """
        act, key = judged["act"], judged["key"]
        foreseen, acts = self._foreseen.get(thread, ("", set()))
        if not cached and foreseen == key and act not in acts:
            acts.add(act)
            return None
        if judged["verdict"] == "authorized":
            return None
        guest = judged["guest"] or self._zid.get(judged["zid"], "")
        return Refusal("message", guest, f"it may not {_ACTS.get(act, act.lower())} {_place(key)}")


def why_not_connected(log: str) -> str:
    """Why a guest could not connect, by the log of that attempt: one or two sentences, for the guest to read."""
    attempts = [line for line in log.splitlines() if "Unable to connect to " in line and " any of " not in line]
    return _first(_NOT_CONNECTED, attempts[-1] if attempts else "") or _CANNOT


def _place(key: str) -> str:
    """Where in the session's part of the network, in words where it is a known place."""
    _, _, place = key.removeprefix("sar-tui/").partition("/")
    kind, _, whose = place.partition("/")
    words = {"out": "what the session tells", "act": "the acts of", "hello": "the signs of life of"}.get(kind)
    if words is None or bool(whose) == (kind == "out"):
        return f"“{_shown(key)}”"
    whose = "anybody" if whose in ("*", "**") else _shown(whose)
    return words if kind == "out" else f"{words} {whose}"


def _first(reasons: tuple[tuple[str, str], ...], text: str) -> str:
    return next((words for part, words in reasons if part in text), "")


def _remember(known: dict[str, T], key: str, value: T) -> None:
    known[key] = value
    if len(known) > _MOST_KNOWN:
        del known[next(iter(known))]


def _shown(key: str) -> str:
    """What somebody else chose, made fit to be printed."""
    return "".join(letter if letter.isprintable() else "�" for letter in key[:_LONGEST_KEY])

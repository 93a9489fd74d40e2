"""Refused connections and messages, parsed from Zenoh's log, the only place that reports them.

Zenoh writes its log to *standard output*. To read it, start the process that runs Zenoh with the
environment of ``log_environment`` and a pipe as standard output, call
``zenoh.init_log_from_env_or`` there, and read the pipe until the process ends: a full pipe blocks
Zenoh's network threads. A line may contain a secret, so only what is parsed here may leave this
module. It may also contain text that a guest chose, with line breaks, so nothing may be decided by
it.
"""

import re
from collections.abc import Iterable
from typing import Literal, NamedTuple, TypeVar

from sar_tui.model.visible_text import visible

HOST_LOG = (
    "error,zenoh_link_tls::unicast=debug,zenoh_link_commons::tls=warn,"
    "zenoh_transport::unicast::establishment::accept=debug,zenoh::net::routing::interceptor::access_control=trace"
)
"""Log levels at which a host's refusals appear; access control logs denials at ``trace`` only."""
GUEST_LOG = "error,zenoh::net::runtime::orchestrator=warn"
"""Log levels that ``why_not_connected`` needs."""
_MAX_KNOWN = 64
T = TypeVar("T")
_MAX_KEY = 120


class Refusal(NamedTuple):
    """Connection that was rejected or closed, or message that was dropped.

    ``guest``: such as ``operator.op1``; empty if unknown. ``why`` continues a sentence.
    """

    what: Literal["connection", "message"]
    guest: str
    why: str


def log_environment(levels: str) -> dict[str, str]:
    """Return environment variables for Zenoh's process: log levels, and no colours."""
    return {"RUST_LOG": levels, "NO_COLOR": "1"}


_LINE = re.compile(
    r"^\S+ +(?P<level>[A-Z]+) +(?P<thread>\S.*?) (?P<target>zenoh\w*(?:::\w+)+): (?P<text>.*)$"
)
_ACCEPTED = re.compile(
    r"Accepted TLS connection on \S+: (?P<address>\S+)\. Common Name: (?P<guest>.+)\.$"
)
_TRANSPORT = re.compile(
    r"New transport link accepted from (?P<zid>[0-9a-f]+) to .* dst: tls/(?P<address>[^,\s]+),"
)
_VERDICT = re.compile(
    r"(?:Using cached result: )?(?P<zid>[0-9a-f]+) (?:on "
    r"\S*?CertCommonName\((?P<guest>[^)]*)\)\S* )?(?:on \S+ )?"
    r"is (?P<verdict>authorized|unauthorized) to (?P<act>[A-Za-z/ ]+) \(ingress\) on (?P<key>.*)$"
)
_CACHING = re.compile(r"ACL \(ingress\): caching permissions for `(?P<key>.*)` \.\.\.$")
_EXPIRED = re.compile(
    r"Closing TLS link \S+ => (?P<address>\S+) : remote certificate chain expired"
)

_ACTS = {
    "Put": "send among",
    "Delete": "delete among",
    "Query": "ask for",
    "Reply": "answer for",
    "Declare/Undeclare Subscriber": "listen to",
    "Declare/Undeclare Queryable": "offer to answer for",
    "Liveliness Token": "announce itself among",
    "Liveliness Query": "see whether there is",
    "Declare/Undeclare Liveliness Subscriber": "watch for",
}
"""Zenoh's names of actions, and how the record puts them."""

_CERTIFICATE = (
    ("peer sent no certificates", "it has no certificate"),
    ("certificate expired", "its invitation has expired"),
    (
        "certificate not valid yet",
        "its certificate is not valid yet: one of the two clocks is wrong",
    ),
    ("UnknownIssuer", "its certificate was made by another authority"),
    ("BadSignature", "its certificate was made by another authority"),
    ("invalid peer certificate", "its certificate is not one for a guest"),
    ("received fatal alert", "it does not trust this host's certificate"),
    ("peer is incompatible", "its TLS is too old"),
    ("corrupt message", "it does not speak TLS"),
    ("handshake eof", "it closed the connection before it identified itself"),
)
_NO_LISTENER = "Nothing listens there. Is a session running, with --listen and that port?"
_NOT_CONNECTED = (
    ("alert: CertificateExpired", "The invitation has expired. Ask for a new one."),
    (
        "alert: UnknownCA",
        "The session there does not know this invitation: it was made for another data folder. "
        "Ask for a new one.",
    ),
    (
        "alert: DecryptError",
        "The session there does not know this invitation: it was made for another data folder. "
        "Ask for a new one.",
    ),
    ("alert: ", "The session there refused the certificate of this invitation. Ask for a new one."),
    ("not valid for name", "The host there has another name. Ask for a new invitation."),
    (
        "certificate expired",
        "The certificate of the session there has expired. Have the session restarted.",
    ),
    ("invalid peer certificate", "The host there is not the one that made this invitation."),
    (
        "Connection refused",
        _NO_LISTENER,
    ),
    ("failed to lookup address", "There is no computer of that name on the network."),
)
_UNREACHABLE = "The session there cannot be reached."


class RefusalLog:
    """Parser of a host's log. It remembers whose connection is whose, as some lines contain no
    name.

    Args:
        guests: those admitted, such as ``operator.op1``.
    """

    def __init__(self, guests: Iterable[str]) -> None:
        self._guests = frozenset(guests)
        self._guest_at: dict[str, str] = {}
        self._guest_of: dict[str, str] = {}
        self._caching: dict[str, tuple[str, set[str]]] = {}

    def parse(self, line: str) -> Refusal | None:
        """Return the refusal that a line of the log reports, if any."""
        found = _LINE.match(line)
        if found is None:
            return None
        text = found["text"]
        if verdict := _VERDICT.match(text):
            return self._parse_verdict(found["thread"], verdict, cached=text.startswith("Using"))
        if caching := _CACHING.match(text):
            _remember(self._caching, found["thread"], (caching["key"], set()))
        elif transport := _TRANSPORT.match(text):
            _remember(
                self._guest_of, transport["zid"], self._guest_at.get(transport["address"], "")
            )
        elif accepted := _ACCEPTED.match(text):
            _remember(self._guest_at, accepted["address"], accepted["guest"])
            if accepted["guest"] not in self._guests:
                why = "its invitation was revoked, or is not known here"
                return Refusal("connection", _printable(accepted["guest"]), why)
        elif expired := _EXPIRED.match(text):
            return Refusal(
                "connection",
                self._guest_at.get(expired["address"], ""),
                "its invitation has expired",
            )
        elif found["target"] == "zenoh_link_tls::unicast" and found["level"] == "WARN":
            return Refusal(
                "connection", "", _first(_CERTIFICATE, text) or "it could not identify itself"
            )
        return None

    def _parse_verdict(
        self, thread: str, verdict: re.Match[str], *, cached: bool
    ) -> Refusal | None:
        """Return the refusal of a verdict, unless Zenoh only caches permissions.

        When a guest declares a key, Zenoh logs its verdict on each possible action there, as if it
        had been tried.
        """
        act, key = verdict["act"], verdict["key"]
        cached_key, acts = self._caching.get(thread, ("", set()))
        if not cached and cached_key == key and act not in acts:
            acts.add(act)
            return None
        if verdict["verdict"] == "authorized":
            return None
        guest = verdict["guest"] or self._guest_of.get(verdict["zid"], "")
        return Refusal(
            "message", guest, f"it may not {_ACTS.get(act, act.lower())} {_describe(key)}"
        )


def why_not_connected(log: str, *, to_router: bool = False) -> str:
    """Return why a guest could not connect, from the log of that attempt, in one or two sentences
    for the guest.
    """
    attempts = [
        line
        for line in log.splitlines()
        if "Unable to connect to " in line and " any of " not in line
    ]
    why = _first(_NOT_CONNECTED, attempts[-1] if attempts else "") or _UNREACHABLE
    if to_router:
        why = "Nothing listens there. Is the router running?" if why == _NO_LISTENER else why
        why = why.replace("session", "router")
    return why


def _describe(key: str) -> str:
    """Return a key in words, if it is one of the link's."""
    _, _, place = key.removeprefix("sar-tui/").partition("/")
    kind, _, whose = place.partition("/")
    text = {
        "out": "the messages of the session",
        "act": "the acts of",
        "hello": "the heartbeats of",
    }.get(kind)
    if text is None or bool(whose) == (kind == "out"):
        return f"“{_printable(key)}”"
    whose = "anybody" if whose in ("*", "**") else _printable(whose)
    return text if kind == "out" else f"{text} {whose}"


def _first(reasons: tuple[tuple[str, str], ...], text: str) -> str:
    return next((reason for part, reason in reasons if part in text), "")


def _remember(known: dict[str, T], key: str, value: T) -> None:
    known[key] = value
    if len(known) > _MAX_KNOWN:
        del known[next(iter(known))]


def _printable(key: str) -> str:
    """Return untrusted text shortened, with control characters made visible."""
    return visible(key[:_MAX_KEY])

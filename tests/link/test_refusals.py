"""Refusals parsed from Zenoh's log. The lines are from Zenoh 1.10; `test_link_faults` produces new
ones.
"""

import pytest

from sar_tui.link.refusals import Refusal, RefusalLog, why_not_connected

ZID = "b5fa3a2865218a34b09927dff29185fb"
TLS = "2026-11-21T19:38:04.543323Z  WARN acc-0 ThreadId(05) zenoh_link_tls::unicast: "
ACL = (
    "2026-11-21T19:38:03.971810Z TRACE  rx-0 ThreadId(08) "
    "zenoh::net::routing::interceptor::access_control: "
)
HINT = " Hint: increase the system open file limit."
KEY = "sar-tui/1422cbb3724b/act/operator.anna"
EVE_CAME = (
    "2026-11-21T19:38:03.971039Z DEBUG acc-0 ThreadId(05) zenoh_link_tls::unicast: Accepted TLS "
    "connection on "
    "127.0.0.1:50529: 127.0.0.1:39750. Common Name: observer.eve."
)
EVE_OPENED = (
    "2026-11-21T19:38:03.971568Z DEBUG acc-0 ThreadId(05) "
    "zenoh_transport::unicast::establishment::accept: New "
    f"transport link accepted from {ZID} to 6702d3c00651398862d7c3468323badf: "
    "TransportLinkUnicast { link: Link { "
    "src: tls/127.0.0.1:50529, dst: tls/127.0.0.1:39750, mtu: 49152, is_reliable: true, "
    "is_streamed: true }, config: "
    "TransportLinkUnicastConfig { direction: Inbound, batch: BatchConfig { mtu: 49152, "
    "is_streamed: true, "
    "is_compression: false }, priorities: None, reliability: None } } "
)
EVE = f"{ZID} on Interface(lo)+CertCommonName(observer.eve)+Transport(Tls)+{ZID}"


TO_ANNA = Refusal("message", "observer.eve", "it may not send among the acts of operator.anna")
REVOKED = "its invitation was revoked, or is not known here"
BY_CONNECTION = f"{ACL}Using cached result: {ZID} is unauthorized to Put (ingress) on {KEY}"


@pytest.fixture
def log() -> RefusalLog:
    return RefusalLog(["operator.anna", "observer.eve"])


@pytest.mark.parametrize(
    ("message", "why"),
    [
        ("peer sent no certificates.", "it has no certificate"),
        (
            "invalid peer certificate: certificate expired: verification time 1795289884 (UNIX), "
            "but certificate is "
            "not valid after 1795203483 (86401 seconds ago).",
            "its invitation has expired",
        ),
        (
            "invalid peer certificate: UnknownIssuer.",
            "its certificate was made by another authority",
        ),
        (
            "invalid peer certificate: certificate does not allow extended key usage for client "
            "authentication, allows "
            "server authentication.",
            "its certificate is not one for a guest",
        ),
        ("received fatal alert: UnknownCA.", "it does not trust this host's certificate"),
        ("peer is incompatible: SupportedVersionsExtensionRequired.", "its TLS is too old"),
        ("received corrupt message of type InvalidContentType.", "it does not speak TLS"),
        ("tls handshake eof.", "it closed the connection before it identified itself"),
        ("something that no version said so far.", "it could not identify itself"),
    ],
)
def test_rejected_connection_is_reported_with_its_reason(
    log: RefusalLog, message: str, why: str
) -> None:
    assert log.parse(TLS + message + HINT) == Refusal("connection", "", why)


def test_a_guest_is_accepted_or_refused_by_name_if_it_was_revoked(log: RefusalLog) -> None:
    assert log.parse(EVE_CAME) is None
    assert log.parse(EVE_OPENED) is None
    assert RefusalLog(["operator.anna"]).parse(EVE_CAME) == Refusal(
        "connection", "observer.eve", REVOKED
    )


@pytest.mark.parametrize(
    ("act", "place", "why"),
    [
        ("Liveliness Query", "out", "it may not see whether there is the messages of the session"),
        ("Declare/Undeclare Subscriber", "act/*", "it may not listen to the acts of anybody"),
        ("Put", "act/operator.anna", "it may not send among the acts of operator.anna"),
        ("Put", "hello/operator.ben", "it may not send among the heartbeats of operator.ben"),
        ("Put", "elsewhere", "it may not send among “sar-tui/1422cbb3724b/elsewhere”"),
        ("Something New", "out", "it may not something new the messages of the session"),
    ],
)
def test_denied_action_is_described_with_its_sender(
    log: RefusalLog, act: str, place: str, why: str
) -> None:
    line = f"{ACL}{EVE} is unauthorized to {act} (ingress) on sar-tui/1422cbb3724b/{place}"
    assert log.parse(line) == Refusal("message", "observer.eve", why)


def test_denial_without_name_is_attributed_by_connection(log: RefusalLog) -> None:
    assert log.parse(BY_CONNECTION) == Refusal("message", "", TO_ANNA.why)
    log.parse(EVE_CAME)
    log.parse(EVE_OPENED)
    assert log.parse(BY_CONNECTION) == TO_ANNA


@pytest.mark.parametrize(
    "line",
    [
        f"{ACL}{EVE} is authorized to Put (ingress) on sar-tui/1422cbb3724b/hello/observer.eve",
        f"{ACL}{EVE} is unauthorized to Put (egress) on sar-tui/1422cbb3724b/back/operator.anna",
        f"{ACL}Using cached result: {ZID} is authorized to Put (egress) on "
        "sar-tui/1422cbb3724b/out",
        "2026-11-21T19:38:03.781410Z DEBUG ThreadId(01) "
        "zenoh::net::routing::interceptor::access_control: Access "
        "control is disabled",
        "2026-11-21T19:22:07.573894Z  INFO ThreadId(01) zenoh::net::runtime::orchestrator: Zenoh "
        "can be reached at: "
        "tls/127.0.0.1:38741",
        "Z/",
        "",
    ],
)
def test_other_lines_are_no_refusal(log: RefusalLog, line: str) -> None:
    assert log.parse(line) is None


def test_cached_permissions_are_no_refusal(log: RefusalLog) -> None:
    assert log.parse(f"{ACL}ACL (ingress): caching permissions for `{KEY}` ...") is None
    for act in ("Query", "Reply", "Put", "Delete", "Declare/Undeclare Queryable"):
        assert log.parse(f"{ACL}{EVE} is unauthorized to {act} (ingress) on {KEY}") is None
    assert log.parse(f"{ACL}{EVE} is authorized to Liveliness Query (ingress) on {KEY}") is None
    done = f"{ACL}{EVE} is unauthorized to Put (ingress) on {KEY}"
    assert log.parse(done) == TO_ANNA


def test_connection_closed_on_expiry_is_reported(log: RefusalLog) -> None:
    log.parse(EVE_CAME)
    ended = (
        "2026-11-21T19:29:12.001263Z  WARN acc-0 ThreadId(04) "
        "zenoh_link_commons::tls::expiration: Closing TLS link "
        "127.0.0.1:50529 => 127.0.0.1:39750 : remote certificate chain expired"
    )
    assert log.parse(ended) == Refusal("connection", "observer.eve", "its invitation has expired")


def test_untrusted_key_is_made_printable(log: RefusalLog) -> None:
    line = f"{ACL}{EVE} is unauthorized to Put (ingress) on a\x1b[31m{'x' * 1000}"
    refusal = log.parse(line)
    assert refusal is not None
    assert refusal.why.isprintable()
    assert len(refusal.why) < 200


def test_memory_is_bounded(log: RefusalLog) -> None:
    for port in range(10_000):
        log.parse(EVE_CAME.replace("39750", str(port)))
    log.parse(EVE_CAME)
    log.parse(EVE_OPENED)
    assert log.parse(BY_CONNECTION) == TO_ANNA
    assert len(log._guest_at) < 100


# --- guest

HEAD = (
    "2026-11-21T19:22:08.687339Z  WARN ThreadId(01) zenoh::net::runtime::orchestrator: Unable "
    "to connect to "
)
SOURCE = " at /src/io/zenoh-links/zenoh-link-tls/src/unicast.rs:226."


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ("received fatal alert: UnknownCA", "does not know this invitation"),
        ("received fatal alert: CertificateExpired", "has expired"),
        ("received fatal alert: UnsupportedCertificate", "refused the certificate"),
        (
            "Can not create a new TLS link bound to IpAddress(V4(Ipv4Addr([127, 0, 0, 1]))): "
            "invalid peer certificate: "
            "UnknownIssuer",
            "is not the one that made",
        ),
        (
            "Can not create a new TLS link bound to IpAddress(V4(Ipv4Addr([127, 0, 0, 1]))): "
            "[127.0.0.1:1: Connection "
            "refused (os error 111)",
            "Nothing listens there",
        ),
        (
            "failed to lookup address information: Name or service not known",
            "no computer of that name",
        ),
        ("something that no version said so far", "cannot be reached"),
    ],
)
def test_reason_of_failed_connection(said: str, words: str) -> None:
    log = (
        f"{HEAD}tls/127.0.0.1:38741! {said}{SOURCE}\n"
        f"{HEAD}any of [Single(tls/127.0.0.1:38741)]!  at "
        "/src/zenoh/src/net/runtime/orchestrator.rs:447.\n"
    )
    assert words in why_not_connected(log)


def test_private_key_in_the_log_is_not_repeated() -> None:
    said = "Cannot create a new TLS listener to tls/127.0.0.1:1#connect_private_key_base64=S3VjaGVu"
    log = f"{HEAD}tls/127.0.0.1:1! {said}"
    assert why_not_connected(log) == "The session there cannot be reached."

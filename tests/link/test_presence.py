"""Presence of peers, and which operator is in control."""

from sar_tui.framework.clock import SECOND
from sar_tui.link.control_lock import ControlLock
from sar_tui.link.presence import MAX_PEERS, Presence


def test_silent_peer_is_lost_once() -> None:
    presence = Presence(2 * SECOND)
    assert presence.heartbeat("operator.anna", "1", 0) == "joined"
    assert presence.heartbeat("operator.anna", "1", SECOND) == "present"
    assert presence.expire(3 * SECOND) == []
    assert presence.expire(3 * SECOND + 1) == ["operator.anna"]
    assert presence.expire(9 * SECOND) == []
    assert presence.heartbeat("operator.anna", "1", 10 * SECOND) == "joined"


def test_name_belongs_to_one_program_until_it_leaves() -> None:
    presence = Presence(2 * SECOND)
    presence.heartbeat("operator.anna", "first", 0)
    assert presence.heartbeat("operator.anna", "second", 0) == "taken"
    assert presence.is_present("operator.anna", "first")
    assert not presence.is_present("operator.anna", "second")
    assert presence.leave("operator.anna")
    assert presence.heartbeat("operator.anna", "second", 1) == "joined"


def test_number_of_peers_is_limited() -> None:
    presence = Presence(2 * SECOND)
    assert {presence.heartbeat(f"observer.{number}", "1", 0) for number in range(MAX_PEERS)} == {"joined"}
    assert presence.heartbeat("observer.late", "1", 0) == "full"
    assert not presence.leave("observer.late")


def test_first_operator_gets_control_and_observer_never() -> None:
    lock = ControlLock()
    lock.join("observer.olaf", "observer")
    assert lock.holder == ""
    lock.join("operator.anna", "operator")
    lock.join("operator.ben", "operator")
    assert lock.holder == "operator.anna"
    assert not lock.take("observer.olaf")
    assert lock.holder == "operator.anna"


def test_only_present_operator_can_take_control() -> None:
    lock = ControlLock()
    lock.join("operator.anna", "operator")
    assert not lock.take("operator.ben")
    lock.join("operator.ben", "operator")
    assert lock.take("operator.ben")
    assert lock.holder == "operator.ben"


def test_control_passes_on_when_its_holder_leaves() -> None:
    lock = ControlLock()
    for name in ("operator.anna", "operator.ben"):
        lock.join(name, "operator")
    lock.leave("operator.anna")
    assert lock.holder == "operator.ben"
    lock.join("operator.anna", "operator")
    assert lock.holder == "operator.ben"
    lock.leave("operator.ben")
    lock.leave("operator.anna")
    assert lock.holder == ""
    lock.join("operator.anna", "operator")
    assert lock.holder == "operator.anna"

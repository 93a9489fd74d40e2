"""Presence of peers, and which operator is in control."""

from sar_tui.link.presence import FIRST_ANSWER_WITHIN, MAX_PEERS, ControlLock, Presence
from sar_tui.model.units import MS, SECOND


def test_silent_peer_is_lost_once() -> None:
    presence = Presence(2 * SECOND)
    assert presence.heartbeat("operator.anna", "1", 0) == "joined"
    assert presence.heartbeat("operator.anna", "1", SECOND) == "present"
    assert presence.expire(3 * SECOND) == []
    assert presence.expire(3 * SECOND + 1) == [("operator.anna", "silent")]
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


def pings(presence: Presence, begin: int, end: int, silence: int | None) -> None:
    """Send heartbeats of a panel whose terminal has been silent for ``silence`` at ``begin``, and
    stays silent.
    """
    for now in range(begin, end, 150 * MS):
        presence.heartbeat(
            "operator.anna", "1", now, None if silence is None else silence + now - begin
        )


def test_a_panel_whose_terminal_answers_no_more_is_lost_though_its_program_runs() -> None:
    presence = Presence(2 * SECOND)
    presence.heartbeat("operator.anna", "1", 0, 0)
    pings(presence, 0, 2 * SECOND, 0)
    assert presence.expire(2 * SECOND) == []
    assert presence.expire(2 * SECOND + 1) == [("operator.anna", "unattended")]


def test_it_is_admitted_again_when_its_terminal_answers() -> None:
    presence = Presence(2 * SECOND)
    presence.heartbeat("operator.anna", "1", 0, 0)
    presence.expire(3 * SECOND)
    assert presence.heartbeat("operator.anna", "1", 3 * SECOND, 3 * SECOND) == "unattended"
    assert "operator.anna" not in presence
    assert presence.heartbeat("operator.anna", "1", 4 * SECOND, 10 * MS) == "joined"


def test_its_name_is_free_meanwhile() -> None:
    presence = Presence(2 * SECOND)
    presence.heartbeat("operator.anna", "1", 0, 0)
    pings(presence, 0, 3 * SECOND, 0)
    presence.expire(3 * SECOND)
    assert presence.heartbeat("operator.anna", "2", 3 * SECOND, 0) == "joined"
    assert presence.heartbeat("operator.anna", "1", 3 * SECOND, 0) == "taken"


def test_a_terminal_that_has_never_answered_is_not_lost_but_unproven() -> None:
    presence = Presence(2 * SECOND)
    pings(presence, 0, FIRST_ANSWER_WITHIN, None)
    assert presence.unproven(FIRST_ANSWER_WITHIN) == []
    assert presence.unproven(FIRST_ANSWER_WITHIN + 1) == [("operator.anna", "never answered")]
    assert presence.unproven(FIRST_ANSWER_WITHIN + 2) == []
    assert presence.expire(FIRST_ANSWER_WITHIN + 1) == []


def test_a_terminal_that_another_program_answers_for_is_unproven_at_once() -> None:
    presence = Presence(2 * SECOND)
    presence.heartbeat("operator.anna", "1", 0, 0, is_relayed=True)
    presence.heartbeat("operator.ben", "1", 0, 0, is_relayed=False)
    assert presence.unproven(0) == [("operator.anna", "relayed")]


def test_an_older_answer_does_not_count() -> None:
    presence = Presence(2 * SECOND)
    presence.heartbeat("operator.anna", "1", 10 * SECOND, 0)
    presence.heartbeat("operator.anna", "1", 10 * SECOND, 5 * SECOND)
    presence.heartbeat("operator.anna", "1", 10 * SECOND)
    assert presence.expire(12 * SECOND) == []


def test_number_of_peers_is_limited() -> None:
    presence = Presence(2 * SECOND)
    assert {presence.heartbeat(f"observer.{number}", "1", 0) for number in range(MAX_PEERS)} == {
        "joined"
    }
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

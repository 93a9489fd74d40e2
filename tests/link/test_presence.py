"""Who is at the link, and who of them acts."""

from sar_tui.framework.clock import SECOND
from sar_tui.link.control_lock import ControlLock
from sar_tui.link.presence import MOST_PEERS, Presence


def test_a_peer_that_is_silent_for_longer_than_the_patience_is_lost_once() -> None:
    presence = Presence(2 * SECOND)
    assert presence.hear("operator.anna", "1", 0) == "joined"
    assert presence.hear("operator.anna", "1", SECOND) == "there"
    assert presence.overdue(3 * SECOND) == []
    assert presence.overdue(3 * SECOND + 1) == ["operator.anna"]
    assert presence.overdue(9 * SECOND) == []
    assert presence.hear("operator.anna", "1", 10 * SECOND) == "joined"


def test_a_second_program_of_the_same_name_waits_until_the_first_is_gone() -> None:
    presence = Presence(2 * SECOND)
    presence.hear("operator.anna", "first", 0)
    assert presence.hear("operator.anna", "second", 0) == "taken"
    assert presence.is_there("operator.anna", "first")
    assert not presence.is_there("operator.anna", "second")
    assert presence.leave("operator.anna")
    assert presence.hear("operator.anna", "second", 1) == "joined"


def test_there_is_room_for_so_many_and_no_more() -> None:
    presence = Presence(2 * SECOND)
    assert {presence.hear(f"observer.{number}", "1", 0) for number in range(MOST_PEERS)} == {"joined"}
    assert presence.hear("observer.late", "1", 0) == "full"
    assert not presence.leave("observer.late")


def test_the_first_operator_gets_the_baton_and_an_observer_never() -> None:
    baton = ControlLock()
    baton.join("observer.olaf", "observer")
    assert baton.holder == ""
    baton.join("operator.anna", "operator")
    baton.join("operator.ben", "operator")
    assert baton.holder == "operator.anna"
    assert not baton.take("observer.olaf")
    assert baton.holder == "operator.anna"


def test_taking_the_baton_moves_it_at_once_if_one_is_there() -> None:
    baton = ControlLock()
    baton.join("operator.anna", "operator")
    assert not baton.take("operator.ben")
    baton.join("operator.ben", "operator")
    assert baton.take("operator.ben")
    assert baton.holder == "operator.ben"


def test_when_its_holder_is_gone_the_baton_goes_to_another_operator_or_waits_for_one() -> None:
    baton = ControlLock()
    for name in ("operator.anna", "operator.ben"):
        baton.join(name, "operator")
    baton.leave("operator.anna")
    assert baton.holder == "operator.ben"
    baton.join("operator.anna", "operator")
    assert baton.holder == "operator.ben"
    baton.leave("operator.ben")
    baton.leave("operator.anna")
    assert baton.holder == ""
    baton.join("operator.anna", "operator")
    assert baton.holder == "operator.anna"

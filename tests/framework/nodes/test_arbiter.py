"""Given a proposal, when a trial runs, then it waits; when none does, it passes straight through."""

from sar_tui.framework.bus import Bus, Topic
from sar_tui.framework.clock import VirtualClock
from sar_tui.framework.messages import Action, Message, Proposal, Waiting
from sar_tui.framework.node import Node, on
from sar_tui.framework.nodes.arbiter import Arbiter
from sar_tui.framework.topics import ACTION, PROPOSED, WAITING


class Told(Message, frozen=True, kw_only=True):
    what: str = ""
    word: str = ""


TOLD = Topic("test/told", Told, origin="input")


class Teller(Node):
    name = "teller"
    emits = (WAITING, PROPOSED)

    @on(TOLD)
    def told(self, told: Told) -> None:
        if told.what:
            self.emit(WAITING, Waiting(what=told.what, stage="trial"))  # type: ignore[arg-type]
        if told.word:
            self.emit(PROPOSED, Proposal(id=told.word, kind="feedback", text=told.word, face="happy", seat="B"))


def played(*script: Told) -> list[list[Action]]:
    bus = Bus(VirtualClock())
    for node in (Teller(), Arbiter()):
        node.attach(bus)
    actions: list[Action] = []
    bus.subscribe(ACTION, actions.append)
    after = []
    for told in script:
        bus.publish(TOLD, told)
        after.append(list(actions))
        actions.clear()
    return after


def test_outside_a_trial_everything_is_passed_on_as_it_is() -> None:
    ((action,),) = played(Told(word="hello"))
    assert action == Action(
        seat="B",
        id="hello",
        kind="feedback",
        text="hello",
        face="happy",
        decision="accepted",
        actor="agent",
    )


def test_nothing_is_passed_on_in_a_trial_and_all_of_it_in_order_once_it_is_over() -> None:
    for what in ("foreperiod", "storage", "response"):
        *held, passed = played(Told(what=what), Told(word="a"), Told(what=what, word="b"), Told(what="enter"))
        assert held == [[], [], []]
        assert [action.text for action in passed] == ["a", "b"]


def test_what_was_passed_on_is_not_passed_on_again() -> None:
    *_, first, second = played(Told(what="response"), Told(word="a"), Told(what="quiet"), Told(what="enter"))
    assert ([action.text for action in first], second) == (["a"], [])

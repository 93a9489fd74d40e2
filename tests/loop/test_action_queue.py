"""The action queue begins one action at a time, by priority."""

from hypothesis import given
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from sar_tui.loop.action_queue import ActionQueue
from sar_tui.model.messages import ActionPart, Policy, Proposal

POLICIES: tuple[Policy, ...] = ("queue", "interrupt", "drop")
OPEN: set[tuple[str, ActionPart]] = {("speech", "say"), ("robot", "gesture"), ("robot", "say")}


def proposal(
    name: str, priority: int = 0, policy: Policy = "queue", due: int = 0, seat: str = "A"
) -> Proposal:
    return Proposal(
        seat=seat, id=name, kind="feedback", text=name, priority=priority, policy=policy, due=due
    )


def begun(queue: ActionQueue, one: Proposal) -> ActionQueue:
    queue.add(one)
    queue.begin(one, OPEN)
    return queue


@given(st.integers(0, 9), st.integers(0, 9), st.sampled_from(POLICIES))
def test_only_an_interrupting_action_of_at_least_equal_priority_replaces_the_current_one(
    under_way: int, priority: int, policy: Policy
) -> None:
    queue = begun(ActionQueue(), proposal("first", under_way))
    second = proposal("second", priority, policy)
    queue.add(second)
    assert queue.next(0) == (second if policy == "interrupt" and priority >= under_way else None)


def test_feedback_for_one_seat_does_not_interrupt_that_for_the_other() -> None:
    queue = begun(ActionQueue(), proposal("to B", 40, "queue", seat="B"))
    queue.add(proposal("to A", 40, "interrupt"))
    assert queue.next(0) is None
    queue.add(proposal("to B again", 40, "interrupt", seat="B"))
    queue.take("to A")
    assert [waiting.id for waiting in queue.waiting] == ["to B again"]
    assert queue.next(0) in queue.waiting


def test_feedback_for_either_seat_interrupts_less_important_actions() -> None:
    queue = begun(ActionQueue(), Proposal(id="hello", kind="greeting", text="Hello.", priority=30))
    queue.add(proposal("to B", 40, "interrupt", seat="B"))
    assert queue.next(0) in queue.waiting


class QueueMachine(RuleBasedStateMachine):
    """Uses the queue as the arbiter does, and checks its invariants."""

    def __init__(self) -> None:
        super().__init__()
        self.queue = ActionQueue()
        self.now = 0
        self.count = 0
        self.waiting: dict[str, Proposal] = {}
        self.open: set[tuple[str, ActionPart]] = set()
        self.current: Proposal | None = None

    @rule(
        priority=st.integers(0, 3),
        policy=st.sampled_from(POLICIES),
        delay=st.one_of(st.just(0), st.integers(0, 50)),
    )
    def propose(self, priority: int, policy: Policy, delay: int) -> None:
        self.count += 1
        new = proposal(f"a{self.count}", priority, policy, self.now + delay)
        self.waiting[new.id] = new
        self.queue.add(new)

    @rule(passed=st.integers(1, 60))
    def wait(self, passed: int) -> None:
        self.now += passed

    @rule(parts=st.sets(st.sampled_from(sorted(OPEN))))
    def take_a_turn(self, parts: set[tuple[str, ActionPart]]) -> None:
        chosen = self.queue.next(self.now)
        ready = [waiting for waiting in self.waiting.values() if waiting.due <= self.now]
        if chosen is None:
            assert self.current is not None or not ready, "nothing waits that could begin"
            return
        assert chosen is max(ready, key=lambda waiting: waiting.priority), "the oldest of them"
        if self.current is not None:
            assert chosen.policy == "interrupt"
            assert chosen.priority >= self.current.priority
        self.queue.begin(chosen, parts)
        del self.waiting[chosen.id]
        self.open = set(parts)
        self.current = chosen if parts else None

    @precondition(lambda self: self.current is not None)
    @rule(part=st.sampled_from(sorted(OPEN)), mine=st.booleans())
    def report(self, part: tuple[str, ActionPart], mine: bool) -> None:
        assert self.current is not None
        over = self.queue.finish_part(self.current.id if mine else "another", *part)
        if mine:
            self.open.discard(part)
        assert over == (mine and not self.open)
        if over:
            self.current = None

    @rule()
    def abandon(self) -> None:
        self.queue.abandon()
        self.current = None
        self.open.clear()

    @rule(only=st.sampled_from(["", *POLICIES]))
    def give_up(self, only: str) -> None:
        gone = {
            given_up.id for given_up in self.queue.remove(lambda each: only in ("", each.policy))
        }
        assert gone == {
            name for name, waiting in self.waiting.items() if only in ("", waiting.policy)
        }
        self.waiting = {name: waiting for name, waiting in self.waiting.items() if name not in gone}

    @invariant()
    def one_thing_at_most_is_under_way_and_nothing_is_lost(self) -> None:
        assert self.queue.current == self.current
        assert self.queue.is_acting == bool(self.open)
        by_priority = sorted(self.waiting.values(), key=lambda waiting: -waiting.priority)
        assert self.queue.waiting == tuple(by_priority)

    @invariant()
    def it_knows_when_to_look_again(self) -> None:
        later = [waiting.due for waiting in self.waiting.values() if waiting.due > self.now]
        assert self.queue.next_due(self.now) == (min(later) if later else None)


TestQueue = QueueMachine.TestCase

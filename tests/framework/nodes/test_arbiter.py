"""Given what the agent proposes, when outputs take their time, then it does one thing at a time, none in a trial."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.framework import messages as m
from sar_tui.framework.bus import Bus, Record, Topic
from sar_tui.framework.clock import MS, SECOND, VirtualClock
from sar_tui.framework.node import Node, on
from sar_tui.framework.nodes.arbiter import PATIENCE, PER_CHARACTER, Arbiter
from sar_tui.framework.parameters import TaskParameters, build
from sar_tui.framework.topics import (
    ACTING,
    ACTION,
    DROPPED,
    HALT,
    OPERATOR,
    OUTPUT,
    PROPOSED,
    REPORT,
    SESSION,
    SESSION_ENDED,
    WAITING,
)
from sar_tui.outputs.node import OutputNode
from tests.outputs.contract import THEME as BARE
from tests.outputs.fake_outputs import Speaker


class Told(m.Message, frozen=True, kw_only=True):
    waiting: m.Waiting | None = None
    ended: m.SessionEnded | None = None
    proposals: tuple[m.Proposal, ...] = ()


TOLD = Topic("test/told", Told, origin="input")
IN_TRIAL = ("foreperiod", "storage", "response")


class Teller(Node):
    """Stands in for the event handler and the action center."""

    name = "teller"
    emits = (WAITING, PROPOSED, SESSION_ENDED)

    @on(TOLD)
    def told(self, told: Told) -> None:
        if told.waiting:
            self.emit(WAITING, told.waiting)
        if told.ended:
            self.emit(SESSION_ENDED, told.ended)
        for proposal in told.proposals:
            self.emit(PROPOSED, proposal)


class Floor:
    """An arbiter, and outputs that can do this and that: they report what a test has them report."""

    def __init__(
        self,
        outputs: dict[str, tuple[m.ActionPart, ...]] | None = None,
        extra: tuple[Node, ...] = (),
        **settings: object,
    ) -> None:
        parameters = build(TaskParameters, settings)
        self.clock = VirtualClock(SECOND)
        self.bus = Bus(self.clock)
        self.records: list[Record] = []
        self.bus.tap(self.records.extend)
        for node in (Teller(), Arbiter(parameters, BARE), *extra):
            node.attach(self.bus)
        self.begin(outputs or {})

    def begin(self, outputs: dict[str, tuple[m.ActionPart, ...]], run: int = 1) -> None:
        for name, can in outputs.items():
            self.bus.publish(OUTPUT, m.OutputOpened(output=name, address=name, can=can))
        self.bus.publish(SESSION, m.SessionStarted(run=run, task="lift", theme="calm", seed=1))

    def wait_for(self, what: Any, stage: Any = "trial", reason: str = "") -> None:
        """The session comes to wait for something."""
        self.bus.publish(TOLD, Told(waiting=m.Waiting(what=what, stage=stage, reason=reason)))

    def propose(self, *names: str, **how: Any) -> None:
        made = [proposal(name, **how) for name in names]
        self.bus.publish(TOLD, Told(proposals=tuple(made)))

    def report(self, action: str, state: Any = "done", output: str = "speech", part: m.ActionPart = "say") -> None:
        told = m.OutputReport(action=action, output=output, part=part, state=state, at=self.clock.now())
        self.bus.publish(REPORT, told)

    def stop(self, at: int = 0) -> None:
        self.bus.publish(OPERATOR, m.Operator(command="stop", at=at))

    def all(self, topic: Topic[Any]) -> list[Any]:
        return [record.message for record in self.records if record.topic is topic]

    @property
    def acted(self) -> list[str]:
        return [action.id for action in self.all(ACTION)]

    @property
    def dropped(self) -> list[tuple[str, str]]:
        return [(dropped.id, dropped.reason) for dropped in self.all(DROPPED)]

    @property
    def halted(self) -> list[tuple[str, str]]:
        return [(halt.action, halt.reason) for halt in self.all(HALT)]

    @property
    def acting(self) -> list[bool]:
        return [agent.acting for agent in self.all(ACTING)]


def proposal(name: str, **how: Any) -> m.Proposal:
    return m.Proposal(**{"id": name, "kind": "feedback", "text": name, "spoken": name, **how})


@pytest.fixture
def floor() -> Floor:
    """With one output that speaks."""
    return Floor({"speech": ("say",)})


# --- passed on as it is, and not in a trial -------------------------------------------------------------------


def test_outside_a_trial_proposals_are_passed_on_unchanged() -> None:
    floor = Floor()
    whole: dict[str, Any] = {
        "seat": "B",
        "face": "happy",
        "gesture": "wave",
        "gaze": "left",
        "tone": "success",
        "valence": "positive",
        "degree": "strong",
        "attempt": 3,
        "joins": True,
        "priority": 7,
        "policy": "drop",
    }
    floor.propose("hello", **whole)
    (action,) = floor.all(ACTION)
    assert action == m.Action(
        id="hello", kind="feedback", text="hello", spoken="hello", decision="accepted", actor="agent", **whole
    )


@pytest.mark.parametrize("what", IN_TRIAL)
def test_proposals_in_a_trial_are_passed_on_in_order_after_it(what: str) -> None:
    floor = Floor()
    floor.wait_for(what)
    floor.propose("a")
    floor.wait_for(what)
    floor.propose("b")
    assert floor.acted == []
    floor.wait_for("enter", "attempt")
    assert floor.acted == ["a", "b"]
    floor.wait_for("quiet")
    assert floor.acted == ["a", "b"], "not again"


def test_waiting_for_storage_at_the_end_is_not_a_trial() -> None:
    floor = Floor()
    floor.wait_for("storage", "ended")
    floor.propose("bye")
    assert floor.acted == ["bye"]


# --- one at a time --------------------------------------------------------------------------------------------


def test_a_queued_action_waits_for_the_current_one(floor: Floor) -> None:
    floor.propose("a", "b", "c")
    assert (floor.acted, floor.acting) == (["a"], [True])
    floor.report("a", "queued")
    floor.report("a", "started")
    assert floor.acted == ["a"]
    for number, (name, end) in enumerate([("a", "done"), ("b", "failed"), ("c", "aborted")], 1):
        floor.report(name, end)
        assert floor.acted == ["a", "b", "c"][: number + 1]
    assert floor.acting == [True, False], "told when it changes, not with each action"


def test_a_higher_priority_goes_first(floor: Floor) -> None:
    floor.propose("a")
    floor.propose("b", priority=1)
    floor.propose("c", priority=2)
    floor.report("a")
    floor.report("c")
    assert floor.acted == ["a", "c", "b"]


def test_an_action_is_over_when_every_output_has_done_its_part_of_it() -> None:
    floor = Floor({"speech": ("say",), "robot": ("gesture", "gaze", "say"), "screen": ("show",)})
    floor.propose("a", gesture="wave")
    for output, part in (("speech", "say"), ("robot", "say"), ("robot", "gaze"), ("screen", "show")):
        floor.report("a", "done", output, part)  # type: ignore[arg-type]
        assert floor.acting == [True], "its gesture goes on"
    floor.report("a", "done", "robot", "gesture")
    assert floor.acting == [True, False]


def test_text_on_the_screen_is_not_waited_for() -> None:
    floor = Floor({"screen": ("show",)})
    floor.propose("a", "b")
    assert (floor.acted, floor.acting) == (["a", "b"], [])


# --- breaking off ---------------------------------------------------------------------------------------------


def test_an_interrupting_action_halts_one_of_equal_or_lower_priority(floor: Floor) -> None:
    floor.propose("a", priority=3)
    floor.propose("b", priority=3, policy="interrupt")
    assert floor.halted == [("a", "interrupted")]
    assert [record.topic for record in floor.records if record.topic in (HALT, ACTION)] == [ACTION, HALT, ACTION]
    floor.report("a", "aborted")
    assert floor.acting == [True], "b goes on"
    floor.report("b")
    assert floor.acting == [True, False]


def test_an_interrupting_action_waits_for_one_of_higher_priority(floor: Floor) -> None:
    floor.propose("a", priority=3)
    floor.propose("b", priority=2, policy="interrupt")
    assert (floor.acted, floor.halted) == (["a"], [])
    floor.report("a")
    assert floor.acted == ["a", "b"]


def test_nothing_is_interrupted_in_a_trial(floor: Floor) -> None:
    floor.wait_for("response")
    floor.propose("a", policy="interrupt")
    assert (floor.acted, floor.halted) == ([], [])


@pytest.mark.parametrize(
    ("what", "stage", "halted"),
    [
        ("enter", "instructions", []),
        ("resume", "paused", [("a", "left")]),
        ("enter", "attempt", [("a", "left")]),
        ("agent", "trial", [("a", "left")]),
    ],
)
def test_instructions_are_halted_when_the_participant_continues(
    floor: Floor, what: str, stage: str, halted: list[tuple[str, str]]
) -> None:
    floor.propose("a", kind="instruction")
    floor.wait_for(what, stage)
    assert floor.halted == halted


# --- too late, too early --------------------------------------------------------------------------------------


def test_an_action_of_policy_drop_is_dropped_by_a_trial(floor: Floor) -> None:
    floor.propose("a")
    floor.propose("b", policy="drop")
    floor.propose("c")
    floor.wait_for("enter", "attempt")
    assert floor.dropped == []
    floor.wait_for("agent")
    assert floor.dropped == [("b", "late")]
    floor.report("a")
    assert floor.acted == ["a", "c"]


def test_an_action_of_policy_drop_is_finished_once_begun(floor: Floor) -> None:
    floor.propose("a", policy="drop")
    floor.wait_for("agent")
    assert (floor.dropped, floor.halted) == ([], [])


def test_an_action_begins_exactly_when_it_is_due(floor: Floor) -> None:
    floor.propose("a", due=floor.clock.now() + 2500 * MS)
    floor.clock.advance(2500 * MS - 1)
    assert floor.acted == []
    floor.clock.advance(1)
    assert floor.acted == ["a"]


def test_an_action_due_in_a_trial_begins_after_it(floor: Floor) -> None:
    floor.propose("a", due=floor.clock.now() + 10)
    floor.wait_for("response")
    floor.clock.advance(SECOND)
    assert floor.acted == []
    floor.wait_for("enter", "attempt")
    assert floor.acted == ["a"]


def test_a_due_action_interrupts_while_others_wait(floor: Floor) -> None:
    floor.propose("a", "b")
    floor.propose("c", priority=5, policy="interrupt", due=floor.clock.now() + SECOND)
    floor.clock.advance(SECOND)
    assert floor.acted == ["a", "c"]


# --- stopped --------------------------------------------------------------------------------------------------


def test_the_stop_key_halts_everything_and_drops_what_waits(floor: Floor) -> None:
    floor.propose("a", "b")
    floor.propose("c", due=floor.clock.now() + SECOND)
    pressed = floor.clock.now() - 5 * MS
    floor.stop(pressed)
    assert sorted(floor.dropped) == [("b", "stopped"), ("c", "stopped")]
    (halt,) = floor.all(HALT)
    assert (halt.action, halt.reason, halt.asked) == ("", "stopped", pressed)
    floor.report("a", "aborted")
    floor.clock.advance(10 * SECOND)
    assert (floor.acted, floor.acting) == (["a"], [True, False])
    floor.propose("d")
    assert floor.acted == ["a", "d"], "and it can speak again"


def test_the_stop_key_works_in_a_trial_too(floor: Floor) -> None:
    floor.wait_for("response")
    floor.propose("a")
    floor.stop()
    floor.wait_for("enter", "attempt")
    assert (floor.acted, floor.dropped) == ([], [("a", "stopped")])
    assert floor.all(HALT)[0].asked == floor.clock.now(), "without a stamp of its own it counts from its handling"


def test_other_commands_stop_nothing(floor: Floor) -> None:
    floor.propose("a")
    for command in ("pause", "resume", "skip", "mark"):
        floor.bus.publish(OPERATOR, m.Operator(command=command))  # type: ignore[arg-type]
    assert floor.halted == []


# --- outputs that fall silent, and another run ----------------------------------------------------------------


def test_no_session_hangs_on_an_output_that_never_answers(floor: Floor) -> None:
    patience = PATIENCE + PER_CHARACTER
    floor.propose("a", "b")
    floor.clock.advance(patience - 1)
    assert floor.acted == ["a"]
    floor.clock.advance(1)
    assert floor.acted == ["a", "b"]
    assert floor.halted == [("a", "interrupted")], "and it is told to be quiet"
    floor.clock.advance(patience)
    assert floor.acting == [True, False]


def test_the_time_limit_grows_with_the_text(floor: Floor) -> None:
    floor.propose("a", spoken="a" * 800)
    floor.clock.advance(PATIENCE + 799 * PER_CHARACTER)
    assert floor.acting == [True]


@pytest.mark.parametrize("reason", ["", "pain", "sensor"])
def test_nothing_begins_in_a_pause(floor: Floor, reason: str) -> None:
    floor.wait_for("resume", "paused", reason=reason)
    floor.propose("a")
    assert floor.acted == []
    floor.wait_for("enter", "attempt")
    assert floor.acted == ["a"]


def test_a_resumed_session_greets_in_its_pause(floor: Floor) -> None:
    floor.wait_for("enter", "paused", reason="interrupted")
    floor.propose("a", kind="greeting")
    assert floor.acted == ["a"]


def test_waiting_instructions_are_dropped_on_the_next_screen(floor: Floor) -> None:
    floor.wait_for("enter", "instructions")
    floor.propose("hello")
    floor.propose("a", kind="instruction")
    floor.wait_for("enter", "attempt")
    floor.report("hello")
    assert (floor.acted, floor.dropped) == (["hello"], [("a", "late")])


def test_each_action_has_its_own_time_limit(floor: Floor) -> None:
    floor.propose("a", "b")
    floor.clock.advance(PATIENCE - 1)
    floor.report("a")
    floor.clock.advance(PATIENCE - 1)
    assert floor.acting == [True]


def test_a_new_run_starts_with_an_empty_queue_and_its_own_outputs(floor: Floor) -> None:
    floor.wait_for("response")
    floor.propose("late")
    floor.wait_for("enter", "attempt")
    floor.propose("waits")
    floor.propose("due", due=floor.clock.now() + SECOND)
    floor.begin({"robot": ("gesture",)}, run=2)
    assert sorted(floor.dropped) == [("due", "late"), ("waits", "late")]
    assert floor.acting == [True, False]
    floor.clock.advance(2 * PATIENCE)
    assert floor.acted == ["late"]
    floor.propose("b")
    assert floor.acting == [True, False], "nobody speaks in this run"
    floor.propose("c", gesture="wave")
    assert floor.acting == [True, False, True]


def test_a_new_run_is_not_in_a_trial() -> None:
    floor = Floor()
    floor.wait_for("response")
    floor.begin({}, run=2)
    floor.propose("welcome")
    assert floor.acted == ["welcome"]


# --- whatever happens -----------------------------------------------------------------------------------------

EVENTS = st.one_of(
    st.tuples(
        st.just("propose"),
        st.integers(0, 3),
        st.sampled_from(["queue", "interrupt", "drop"]),
        st.sampled_from([0, 0, 700, 2500]),
    ),
    st.tuples(st.just("trial"), st.sampled_from(IN_TRIAL)),
    st.tuples(st.just("between"), st.sampled_from(["enter", "agent", "quiet"])),
    st.tuples(st.just("wait"), st.integers(1, 3000)),
    st.tuples(st.just("stop")),
)


@given(st.lists(EVENTS, max_size=40), st.integers(1, 3000), st.integers(1, 3000))
def test_actions_never_overlap_or_begin_in_a_trial_and_none_is_lost(
    events: list[Any], takes_ms: int, robot_takes_ms: int
) -> None:
    robot = Speaker(robot_takes_ms)
    robot.name = "robot"
    extra = tuple(OutputNode(output, output.name, BARE) for output in (Speaker(takes_ms), robot))
    floor = Floor(extra=extra)
    in_trial = False
    for number, (what, *how) in enumerate(events):
        before = len(floor.acted)
        match what:
            case "propose":
                priority, policy, delay_ms = how
                due = floor.clock.now() + delay_ms * MS
                floor.propose(f"a{number}", priority=priority, policy=policy, due=due)
            case "trial":
                in_trial = True
                floor.wait_for(how[0])
                before = len(floor.acted)
            case "between":
                in_trial = False
                floor.wait_for(how[0])
            case "wait":
                floor.clock.advance(how[0] * MS)
            case "stop":
                floor.stop()
        floor.clock.advance(0)
        if in_trial:
            assert len(floor.acted) == before
    floor.wait_for("enter", "attempt")
    floor.clock.advance(100 * len(events) * SECOND)

    proposed = [f"a{number}" for number, event in enumerate(events) if event[0] == "propose"]
    assert sorted([*floor.acted, *(name for name, _ in floor.dropped)]) == sorted(proposed)
    assert floor.acting == [True, False] * (len(floor.acting) // 2)
    for output in ("speech", "robot"):
        said: list[str] = []
        for report in floor.all(REPORT):
            if report.output == output and report.state == "started":
                assert said == [], "one utterance is over before the next begins"
                said.append(report.action)
            elif report.output == output and report.state != "queued":
                said = [name for name in said if name != report.action]
        assert said == []

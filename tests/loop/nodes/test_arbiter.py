"""The arbiter passes on one action at a time, and none in a trial."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop import topics as t
from sar_tui.loop.bus import Bus, Record, Topic
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node, on
from sar_tui.loop.nodes.arbiter import ACTION_TIMEOUT, PER_CHARACTER, Arbiter
from sar_tui.loop.session import RULES
from sar_tui.model import messages as m
from sar_tui.model.units import MS, SECOND
from sar_tui.outputs.node import OutputNode
from sar_tui.rules.parameters import TaskParameters, build
from tests.outputs.contract import THEME as PLAIN_THEME
from tests.outputs.fake_outputs import Speaker


class Event(m.Message, frozen=True, kw_only=True):
    waiting: m.Waiting | None = None
    ended: m.SessionEnded | None = None
    proposals: tuple[m.Proposal, ...] = ()


EVENT = Topic("test/event", Event, origin="input")
IN_TRIAL = ("foreperiod", "storage", "response")


class EventSource(Node):
    """Stub of the event handler and the action center."""

    name = "teller"
    emits = (t.WAITING, t.PROPOSED, t.SESSION_ENDED)

    @on(EVENT)
    def happened(self, event: Event) -> None:
        if event.waiting:
            self.emit(t.WAITING, event.waiting)
        if event.ended:
            self.emit(t.SESSION_ENDED, event.ended)
        for proposal in event.proposals:
            self.emit(t.PROPOSED, proposal)


class ArbiterDriver:
    """Drives an arbiter and its outputs, which report what a test says."""

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
        for node in (EventSource(), Arbiter(parameters, PLAIN_THEME), *extra):
            node.attach(self.bus)
        self.begin(outputs or {})

    def begin(self, outputs: dict[str, tuple[m.ActionPart, ...]], run: int = 1) -> None:
        for name, can in outputs.items():
            self.bus.publish(t.OUTPUT, m.OutputOpened(output=name, address=name, can=can))
        self.bus.publish(
            t.SESSION, m.SessionStarted(run=run, task="lift", theme="calm", seed=1, rules=RULES)
        )

    def wait_for(self, what: Any, stage: Any = "trial", reason: str = "") -> None:
        """Publish that the session waits for something."""
        self.bus.publish(EVENT, Event(waiting=m.Waiting(what=what, stage=stage, reason=reason)))

    def propose(self, *names: str, **how: Any) -> None:
        made = [proposal(name, **how) for name in names]
        self.bus.publish(EVENT, Event(proposals=tuple(made)))

    def report(
        self, action: str, state: Any = "done", output: str = "speech", part: m.ActionPart = "say"
    ) -> None:
        report = m.OutputReport(
            action=action, output=output, part=part, state=state, at=self.clock.now()
        )
        self.bus.publish(t.REPORT, report)

    def stop(self, at: int = 0) -> None:
        self.bus.publish(t.COMMAND, m.SessionCommand(command="stop", at=at))

    def all(self, topic: Topic[Any]) -> list[Any]:
        return [record.message for record in self.records if record.topic is topic]

    @property
    def acted(self) -> list[str]:
        return [action.id for action in self.all(t.ACTION)]

    @property
    def dropped(self) -> list[tuple[str, str]]:
        return [(dropped.id, dropped.reason) for dropped in self.all(t.DROPPED)]

    @property
    def halted(self) -> list[tuple[str, str]]:
        return [(halt.action, halt.reason) for halt in self.all(t.HALT)]

    @property
    def acting(self) -> list[bool]:
        return [agent.acting for agent in self.all(t.ACTING)]


def proposal(name: str, **how: Any) -> m.Proposal:
    return m.Proposal(**{"id": name, "kind": "feedback", "text": name, "spoken": name, **how})


@pytest.fixture
def driver() -> ArbiterDriver:
    """Drive an arbiter with one output that speaks."""
    return ArbiterDriver({"speech": ("say",)})


# --- proposals outside and inside trials


def test_outside_a_trial_proposals_are_passed_on_unchanged() -> None:
    driver = ArbiterDriver()
    driver.wait_for("storage", "ended")
    looks = {"face": "happy", "gesture": "wave", "gaze": "left", "tone": "success"}
    sense = {"kind": "encouragement", "seat": "B", "valence": "positive", "degree": "strong"}
    whole: dict[str, Any] = {**looks, **sense, "attempt": 3, "joins": True, "priority": 7}
    whole["policy"] = "drop"
    driver.propose("hello", **whole)
    (action,) = driver.all(t.ACTION)
    assert action == m.Action(
        id="hello", text="hello", spoken="hello", decision="accepted", actor="agent", **whole
    )


@pytest.mark.parametrize("what", IN_TRIAL)
def test_proposals_in_a_trial_are_passed_on_in_order_after_it(what: str) -> None:
    driver = ArbiterDriver()
    driver.wait_for(what)
    driver.propose("a")
    driver.wait_for(what)
    driver.propose("b")
    assert driver.acted == []
    driver.wait_for("enter", "attempt")
    assert driver.acted == ["a", "b"]
    driver.wait_for("quiet")
    assert driver.acted == ["a", "b"], "not again"


# --- one at a time


def test_a_queued_action_waits_for_the_current_one(driver: ArbiterDriver) -> None:
    driver.propose("a", "b", "c")
    assert (driver.acted, driver.acting) == (["a"], [True])
    driver.report("a", "queued")
    driver.report("a", "started")
    assert driver.acted == ["a"]
    for number, (name, end) in enumerate([("a", "done"), ("b", "failed"), ("c", "aborted")], 1):
        driver.report(name, end)
        assert driver.acted == ["a", "b", "c"][: number + 1]
    assert driver.acting == [True, False], "published on changes only, not with each action"


def test_an_action_is_over_when_every_output_has_done_its_part_of_it() -> None:
    robot: tuple[m.ActionPart, ...] = ("gesture", "gaze", "say")
    driver = ArbiterDriver({"speech": ("say",), "robot": robot, "screen": ("show",)})
    driver.propose("a", gesture="wave")
    for done in ("speech say", "robot say", "robot gaze", "screen show"):
        output, part = done.split()
        driver.report("a", "done", output, part)  # type: ignore[arg-type]
        assert driver.acting == [True], "its gesture continues"
    driver.report("a", "done", "robot", "gesture")
    assert driver.acting == [True, False]


# --- interrupting


def test_an_interrupting_action_halts_one_of_equal_or_lower_priority(driver: ArbiterDriver) -> None:
    driver.propose("a", priority=3)
    driver.propose("b", priority=3, policy="interrupt")
    assert driver.halted == [("a", "interrupted")]
    topics = [one.topic for one in driver.records if one.topic in (t.HALT, t.ACTION)]
    assert topics == [t.ACTION, t.HALT, t.ACTION]
    driver.report("a", "aborted")
    assert driver.acting == [True], "b continues"
    driver.report("b")
    assert driver.acting == [True, False]


@pytest.mark.parametrize(
    ("what", "stage", "is_halted"),
    [
        ("enter", "instructions", False),
        ("resume", "paused", True),
        ("enter", "attempt", True),
        ("agent", "trial", True),
    ],
)
def test_instructions_are_halted_when_the_participant_continues(
    driver: ArbiterDriver, what: str, stage: str, is_halted: bool
) -> None:
    driver.propose("a", kind="instruction")
    driver.wait_for(what, stage)
    assert driver.halted == [("a", "left")] * is_halted


# --- too late, too early


def test_an_action_of_policy_drop_is_dropped_by_a_trial(driver: ArbiterDriver) -> None:
    driver.propose("a")
    driver.propose("b", policy="drop")
    driver.propose("c")
    driver.wait_for("enter", "attempt")
    assert driver.dropped == []
    driver.wait_for("quiet")
    assert driver.dropped == [("b", "late")]
    driver.report("a")
    assert driver.acted == ["a", "c"]


# --- the stop key


def test_the_stop_key_stops_all_actions_and_drops_waiting_ones(driver: ArbiterDriver) -> None:
    driver.propose("a", "b")
    driver.propose("c", due=driver.clock.now() + SECOND)
    pressed = driver.clock.now() - 5 * MS
    driver.stop(pressed)
    assert sorted(driver.dropped) == [("b", "stopped"), ("c", "stopped")]
    (halt,) = driver.all(t.HALT)
    assert (halt.action, halt.reason, halt.asked) == ("", "stopped", pressed)
    driver.report("a", "aborted")
    driver.clock.advance(10 * SECOND)
    assert (driver.acted, driver.acting) == (["a"], [True, False])
    driver.propose("d")
    assert driver.acted == ["a", "d"], "and it can speak again"


def test_the_stop_key_works_in_a_trial_too(driver: ArbiterDriver) -> None:
    driver.wait_for("response")
    driver.propose("a")
    driver.stop()
    driver.wait_for("enter", "attempt")
    assert (driver.acted, driver.dropped) == ([], [("a", "stopped")])
    assert driver.all(t.HALT)[0].asked == driver.clock.now(), (
        "without a time stamp it counts from its handling"
    )


# --- silent outputs, and a new run


def test_no_session_hangs_on_an_output_that_never_answers(driver: ArbiterDriver) -> None:
    patience = ACTION_TIMEOUT + PER_CHARACTER
    driver.propose("a", "b")
    driver.clock.advance(patience - 1)
    assert driver.acted == ["a"]
    driver.clock.advance(1)
    assert driver.acted == ["a", "b"]
    assert driver.halted == [("a", "interrupted")], "and its output is halted"
    driver.clock.advance(patience)
    assert driver.acting == [True, False]


def test_each_action_has_its_own_time_limit_which_grows_with_its_text(
    driver: ArbiterDriver,
) -> None:
    driver.propose("a", spoken="a" * 800)
    driver.propose("b")
    driver.clock.advance(ACTION_TIMEOUT + 799 * PER_CHARACTER)
    assert driver.acted == ["a"]
    driver.report("a")
    driver.clock.advance(ACTION_TIMEOUT)
    assert (driver.acted, driver.acting) == (["a", "b"], [True])


def test_nothing_begins_in_a_pause_but_the_greeting_of_a_resumed_session(
    driver: ArbiterDriver,
) -> None:
    driver.wait_for("resume", "paused", reason="pain")
    driver.propose("a")
    assert driver.acted == []
    driver.wait_for("enter", "paused", reason="interrupted")
    assert driver.acted == ["a"]


def test_a_new_run_starts_with_an_empty_queue_and_its_own_outputs(driver: ArbiterDriver) -> None:
    driver.propose("late", "waits")
    driver.propose("due", due=driver.clock.now() + SECOND)
    driver.wait_for("response")
    driver.begin({"robot": ("gesture",)}, run=2)
    assert sorted(driver.dropped) == [("due", "late"), ("waits", "late")]
    assert driver.acting == [True, False]
    driver.clock.advance(2 * ACTION_TIMEOUT)
    assert driver.acted == ["late"]
    driver.propose("b")
    assert driver.acted == ["late", "b"], "no trial of this run has begun"
    assert driver.acting == [True, False], "no output speaks in this run"
    driver.propose("c", gesture="wave")
    assert driver.acting == [True, False, True]


# --- arbitrary input

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
    extra = tuple(
        OutputNode(output, output.name, PLAIN_THEME) for output in (Speaker(takes_ms), robot)
    )
    driver = ArbiterDriver(extra=extra)
    in_trial = False
    for number, (what, *how) in enumerate(events):
        before = len(driver.acted)
        match what:
            case "propose":
                priority, policy, delay_ms = how
                due = driver.clock.now() + delay_ms * MS
                driver.propose(f"a{number}", priority=priority, policy=policy, due=due)
            case "trial":
                in_trial = True
                driver.wait_for(how[0])
                before = len(driver.acted)
            case "between":
                in_trial = False
                driver.wait_for(how[0])
            case "wait":
                driver.clock.advance(how[0] * MS)
            case "stop":
                driver.stop()
        driver.clock.advance(0)
        if in_trial:
            assert len(driver.acted) == before
    driver.wait_for("enter", "attempt")
    driver.clock.advance(100 * len(events) * SECOND)

    proposed = [f"a{number}" for number, event in enumerate(events) if event[0] == "propose"]
    assert sorted([*driver.acted, *(name for name, _ in driver.dropped)]) == sorted(proposed)
    assert driver.acting == [True, False] * (len(driver.acting) // 2)
    for output in ("speech", "robot"):
        said: list[str] = []
        for report in driver.all(t.REPORT):
            if report.output == output and report.state == "started":
                assert said == [], "one utterance is over before the next begins"
                said.append(report.action)
            elif report.output == output and report.state != "queued":
                said = [name for name in said if name != report.action]
        assert said == []

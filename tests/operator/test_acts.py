"""The log of the panel marks as done only what has happened, for the operator who acts and for
those who watch.
"""

from collections.abc import Callable, Iterable
from typing import Any

import pytest

from sar_tui.link.node import SENT
from sar_tui.link.peer import Connection, Frame
from sar_tui.loop.answers import answer_to
from sar_tui.loop.bus import Record, Topic
from sar_tui.loop.topics import (
    ANSWERED,
    COMMAND,
    NOTE_ADDED,
    OUTPUT,
    PRESENCE,
    REMARK,
    STEP_ENDED,
    STOPPED,
    WAITING,
)
from sar_tui.model import messages as m
from sar_tui.model.messages import Message, Role
from sar_tui.model.step import Step
from sar_tui.model.theme import Theme
from sar_tui.model.units import SECOND
from sar_tui.operator import status_view
from sar_tui.operator.commands import Commands
from sar_tui.operator.event_text import Line
from sar_tui.operator.session_state import UNCONFIRMED, Stop
from sar_tui.outputs.node import OutputNode
from sar_tui.outputs.output import Output
from sar_tui.plugins import Catalogue
from tests.loop_driver import LoopDriver
from tests.operator import panel_driver as b
from tests.outputs.fake_outputs import FakeOutput, Speaker

ANNA = b.ANNA
KEPT = "Saying “Well held.”: not done, {}; the text is kept"


class Panel:
    """A panel's commands and log at a session, without a screen. What it sends arrives at once, or
    when a test says so.

    Attributes:
        history: the log at each message of the session.
    """

    role: Role
    name = ANNA

    def __init__(self, driver: LoopDriver, role: Role = "operator") -> None:
        self.role = role
        self.name = f"{role}.anna"
        self.driver = driver
        self.commands = Commands()
        self.commands.peer = self
        self.history: list[list[Line]] = []
        self.is_slow = False
        self.on_its_way: list[Callable[[], None]] = []
        self.commands.receive(Connection("connected"))
        self.commands.receive(b.welcome(role))
        self._receive(driver.records)
        driver.session.bus.tap(self._receive)

    def _receive(self, cascade: Iterable[Record]) -> None:
        frames = [Frame(*record) for record in cascade if record.topic in SENT]
        if frames:
            self.commands.receive(frames)
            self.history.append(self.lines)

    # --- the link

    def send(self, topic: Topic[Any], message: Message) -> None:
        def arrive() -> None:
            self.driver.session.bus.publish(topic, message)

        self.on_its_way.append(arrive)
        if not self.is_slow:
            self.deliver()

    def deliver(self) -> None:
        while self.on_its_way:
            self.on_its_way.pop(0)()

    def now(self) -> int:
        return self.driver.clock.now()

    def take_control(self) -> None: ...

    def close(self) -> None: ...

    # --- the operator

    def decide(self, verdict: Any) -> None:
        """Decide on the most urgent proposal."""
        approval = self.commands.pending[0]
        self.commands.shown = (approval.proposal.id, self.now() - SECOND)
        assert self.commands.decide(approval, verdict, self.now())

    def press(self, command: str, text: str) -> None:
        assert self.commands.command(text, command, self.now())

    @property
    def lines(self) -> list[Line]:
        now, state = self.now(), self.commands.state
        return [*state.log, *(stop.line(now) for stop in state.stops), *self.commands.log.lines]

    @property
    def texts(self) -> list[str]:
        return [line.text for line in self.lines]

    @property
    def last(self) -> tuple[str, str]:
        """Text without the time of the link, and tone, of the newest act."""
        line = self.commands.log.lines[-1]
        return line.text.partition(" · link")[0], line.tone

    def was_good(self, text: str) -> bool:
        """Return True if the log has ever marked a line with this text as done."""
        return any(
            line.tone == "good" and text in line.text for lines in self.history for line in lines
        )


def session(theme: Theme, *outputs: Output, **settings: Any) -> LoopDriver:
    """Start a session with an operator, at the end of its first attempt."""
    nodes = [OutputNode(output, output.name, theme) for output in outputs]
    quiet = {"attempts": 3, "prompts_per_attempt": 2, "encouragement": False, "filler": "never"}
    driver = LoopDriver(Catalogue().task("keyboard"), theme, extra=nodes, **quiet | settings)
    joined = m.OperatorChanged(
        actor=ANNA, state="baton", operated=True, holder=ANNA, peers={ANNA: "operator"}
    )
    driver.session.bus.publish(PRESENCE, joined)
    driver.wait(10_000)
    driver.enter()
    driver.attempt()
    return driver


# --- decisions


@pytest.mark.parametrize(
    ("verdict", "doing", "done"),
    [
        ("accept", "Approving feedback …", "Approved feedback"),
        ("veto", "Vetoing feedback …", "Vetoed feedback"),
    ],
)
@pytest.mark.parametrize("delay_ms", [0, 9000])
def test_a_decision_is_marked_as_done_when_the_session_has_decided(
    calm: Theme, verdict: str, doing: str, done: str, delay_ms: int
) -> None:
    panel = Panel(session(calm, operator_feedback="approve", feedback_delay_ms=delay_ms))
    panel.is_slow = True
    panel.decide(verdict)
    assert panel.last == (doing, "plain")
    panel.deliver()
    assert panel.last == (done, "good")


def test_a_decision_that_comes_too_late_is_never_marked_as_done(calm: Theme) -> None:
    panel = Panel(session(calm, operator_feedback="veto"))
    panel.is_slow = True
    panel.decide("accept")
    panel.driver.wait(10_000)
    panel.deliver()
    assert panel.last == (
        "Approving feedback: too late, it was decided, or its time was over",
        "bad",
    )
    assert not panel.was_good("Approv")


def test_an_edit_that_comes_too_late_can_still_be_said(calm: Theme) -> None:
    panel = Panel(session(calm, operator_feedback="veto"))
    panel.is_slow = True
    approval = panel.commands.pending[0]
    panel.commands.shown = (approval.proposal.id, panel.now() - SECOND)
    assert panel.commands.edit(approval, "Well held.", panel.now())
    assert panel.commands.log.unused_text(REMARK) == ""
    panel.driver.wait(10_000)
    panel.deliver()
    assert panel.commands.log.unused_text(REMARK) == "Well held."
    assert panel.commands.say("Well held!", "A", panel.now())
    assert panel.commands.log.unused_text(REMARK) == ""


def test_a_level_is_marked_as_decided_when_it_is(calm: Theme) -> None:
    panel = Panel(session(calm, operator_difficulty="approve"))
    panel.decide("accept")
    assert panel.last == ("Approved difficulty", "good")


def test_an_action_under_way_is_cancelled_when_its_output_is_still(calm: Theme) -> None:
    robot = FakeOutput("robot", frozenset({"say"}))
    panel = Panel(session(calm, robot))
    (current,) = [panel.commands.state.arbiter.current] if panel.commands.state.arbiter else []
    assert current
    panel.commands.send(
        "Cancelled feedback",
        b.t.DECISION,
        m.Decision(action=current.id, verdict="veto"),
        panel.now(),
    )
    assert panel.last == ("Cancelling feedback …", "plain")
    robot.report(current.id, "say", "aborted")
    panel.driver.wait(0)
    assert panel.last == ("Cancelled feedback", "good")


# --- remarks


def test_a_remark_is_said_only_when_its_output_has_said_it(calm: Theme) -> None:
    driver = session(calm, Speaker(1500))
    panel = Panel(driver)
    driver.wait(10_000)
    driver.begin_attempt()
    assert panel.commands.say("Well held.", "A", panel.now())
    assert panel.last == ("Saying “Well held.” after the response …", "plain")
    driver.answer()
    driver.wait(1000)
    assert not panel.was_good("Well held")
    driver.wait(1500)
    assert panel.last == ("Said “Well held.”", "good")


def test_text_on_a_screen_is_said_as_soon_as_it_is_shown(calm: Theme) -> None:
    screen = FakeOutput("display", frozenset({"show"}))
    panel = Panel(session(calm, screen))
    panel.commands.say("Well held.", "A", panel.now())
    assert panel.last == ("Saying “Well held.” …", "plain")
    action = screen.asked[-1][1]
    screen.report(action, "show", "started")
    panel.driver.wait(0)
    assert panel.last == ("Said “Well held.”", "good")


def test_a_remark_that_an_output_could_not_say_is_not_confirmed(calm: Theme) -> None:
    panel = Panel(session(calm, FakeOutput("speech", frozenset({"say"}), breaks=("say",))))
    panel.commands.say("Well held.", "A", panel.now())
    panel.driver.wait(0)
    assert panel.last == (KEPT.format("an output failed: speech"), "bad")


@pytest.mark.parametrize(
    ("waits", "outcome"),
    [(True, "the agent was stopped"), (False, "it was stopped before its end")],
    ids=["queued", "spoken"],
)
def test_a_remark_that_is_stopped_was_not_said(calm: Theme, waits: bool, outcome: str) -> None:
    panel = Panel(session(calm, Speaker(1500)))
    panel.driver.wait(10_000)
    if waits:
        panel.driver.begin_attempt()
    panel.commands.say("Well held.", "A", panel.now())
    panel.driver.operate("stop")
    panel.driver.wait(100)
    assert panel.last == (KEPT.format(outcome), "bad")
    assert not panel.was_good("Well held")


# --- commands


@pytest.mark.parametrize(
    ("command", "text", "doing"),
    [
        ("pause", "Paused", "Pausing"),
        ("skip", "Skipped the prompt", "Skipping the prompt"),
        ("repeat", "Repeated the prompt", "Repeating the prompt"),
        ("end", "Ended the session", "Ending the session"),
    ],
)
def test_a_command_is_marked_as_done_when_it_was_carried_out(
    calm: Theme, command: str, text: str, doing: str
) -> None:
    panel = Panel(session(calm))
    panel.driver.begin_attempt()
    panel.is_slow = True
    panel.press(command, text)
    assert panel.last == (f"{doing} …", "plain")
    panel.deliver()
    assert panel.last == (text, "good")


def test_a_level_set_by_hand_is_marked_as_done(calm: Theme) -> None:
    panel = Panel(session(calm))
    panel.commands.level(1, panel.now())
    assert panel.last[1] == "good"


def test_a_command_that_comes_too_late_is_not_marked_as_done(calm: Theme) -> None:
    panel = Panel(session(calm))
    panel.press("skip", "Skipped the prompt")
    assert panel.last == ("Skipping the prompt: too late, no prompt is shown", "bad")
    assert not panel.was_good("Skip")


@pytest.mark.parametrize(
    ("state", "why"), [("lost", "the connection was lost"), ("ended", "the session is over")]
)
def test_after_a_lost_connection_an_act_is_not_confirmed_until_its_answer_comes(
    calm: Theme, state: Any, why: str
) -> None:
    panel = Panel(session(calm, Speaker(1500)))
    panel.driver.wait(10_000)
    panel.commands.say("Well held.", "A", panel.now())
    panel.commands.receive(Connection(state))
    assert panel.last == (f"Saying “Well held.”: not confirmed: {why}", "bad")
    panel.commands.receive(Connection("connected"))
    panel.commands.receive(b.welcome())
    assert panel.last == (f"Saying “Well held.”: not confirmed: {why}", "bad")
    panel.driver.wait(1500)
    assert panel.last == ("Said “Well held.”", "good")


def test_each_of_three_remarks_that_the_link_refuses_at_once_says_so(calm: Theme) -> None:
    panel = Panel(session(calm))
    panel.is_slow = True
    for _ in range(3):
        assert panel.commands.say("Well held.", "A", panel.now())
    for act in panel.commands.log.acts:
        why = "Another operator is in control."
        answer = answer_to(act.message, panel.now(), "refused", why)
        panel.commands.receive([b.frame(ANSWERED, answer)])
    line = (KEPT.format("another operator is in control"), "bad")
    assert [(each.text, each.tone) for each in panel.commands.log.lines] == [line] * 3
    assert panel.commands.log.unused_text(REMARK) == "Well held."


# --- stopping the agent


def test_a_stop_is_confirmed_by_the_outputs(calm: Theme) -> None:
    driver = session(calm, Speaker(9000), FakeOutput("robot", frozenset({"gesture"})))
    panel = Panel(driver)
    panel.press("stop", "Stopped")
    assert "You stopped the agent: stopping robot, speech …" in panel.texts
    assert not panel.was_good("stopp")
    driver.wait(1000)
    assert "You stopped the agent: stopping robot …" in panel.texts
    driver.wait(1500)
    assert "You stopped the agent: not confirmed: robot (It did not stop in time.)" in panel.texts
    assert not panel.was_good("stopp")


@pytest.mark.parametrize("role", ["operator", "observer"])
def test_everybody_sees_that_the_participant_pressed_f2(calm: Theme, role: Role) -> None:
    driver = session(calm, Speaker(9000))
    panel = Panel(driver, role)
    driver.operate("stop")
    assert "P01 pressed F2: stopping speech …" in panel.texts
    assert (
        "Stopping speech … · P01"
        in status_view.activity(panel.commands.state, 60, panel.now()).plain
    )
    driver.wait(10)
    assert "P01 pressed F2: stopped after 0 ms" in panel.texts
    assert "✓ Stopped · P01 pressed F2" in status_view.activity(panel.commands.state, 60).plain
    driver.wait(10_000)
    driver.attempt()
    assert "pressed F2" not in status_view.activity(panel.commands.state, 60, panel.now()).plain


def test_an_output_that_never_answers_is_named() -> None:
    stop = Stop(1000, "P01 pressed F2", frozenset({"robot", "speech"}))
    stop = stop.reported(m.OutputStopped(output="speech", asked=1000, at=1000))
    assert stop.outcome(1000 + UNCONFIRMED) == ("stopping robot …", "plain")
    assert stop.outcome(1001 + UNCONFIRMED) == ("not confirmed: robot", "bad")


def test_a_stop_that_never_arrived_is_logged_as_such(calm: Theme) -> None:
    panel = Panel(session(calm, Speaker(9000)))
    panel.is_slow = True
    panel.press("stop", "Stopped")
    assert panel.last == ("Stopping …", "plain")
    panel.commands.receive(Connection("lost"))
    assert panel.last == ("Stopping: not confirmed: the connection was lost", "bad")


def test_only_outputs_that_are_open_are_waited_for() -> None:
    opened = m.OutputOpened(output="speech", address="speech", can=("say",))
    stop = m.SessionCommand(command="stop", at=b.START)
    commands = Commands()
    commands.receive(b.welcome())
    commands.receive([b.frame(OUTPUT, opened), b.frame(COMMAND, stop)])
    assert commands.state.stops[-1].awaited == {"speech"}
    commands.receive(
        [b.frame(STOPPED, m.OutputStopped(output="speech", asked=b.START, at=b.START))]
    )
    assert commands.state.stops[-1].outcome(b.START)[1] == "good"


def test_the_operator_skips_a_question_and_no_other_one(calm: Theme) -> None:
    asking = {"questions": ("effort", "tiredness"), "questions_every": 1}
    panel = Panel(session(calm, **asking))
    waiting = panel.commands.state.waiting
    assert waiting
    assert waiting.step
    panel.is_slow = True
    assert panel.commands.prompt_command("Skipped the prompt", "skip", panel.now())
    assert panel.last == ("Skipping the question …", "plain")
    panel.deliver()
    assert panel.last == ("Skipped the question", "good")
    (ended,) = panel.driver.all(STEP_ENDED)
    assert (ended.number, ended.status) == (waiting.step.number, "skipped")


def test_a_question_that_the_participant_alone_can_answer_is_not_skipped() -> None:
    consent = Step(
        name="consent",
        text="Do you agree?",
        kind="choice",
        labels=("yes", "no"),
        before=True,
        required="yes",
    )
    commands = Commands()
    commands.receive(Connection("connected"))
    commands.receive(b.welcome())
    asked = m.AskedStep(number=1, step=consent)
    commands.receive([b.frame(WAITING, b.waiting("step", "step", step=asked))])
    assert not commands.prompt_command("Skipped the prompt", "skip", b.START)
    assert "Nobody else can answer that" in commands.log.lines[-1].text


# --- those who watch


def watched(calm: Theme, **settings: Any) -> tuple[Panel, Panel]:
    """Start a session with an operator and an observer."""
    driver = session(calm, Speaker(500), **settings)
    return Panel(driver), Panel(driver, "observer")


def test_an_observer_sees_the_operators_decisions_with_their_outcome(calm: Theme) -> None:
    operator, observer = watched(calm, operator_feedback="approve")
    operator.decide("accept")
    assert observer.last == ("anna: Approved feedback", "good")


def test_an_observer_sees_remarks_notes_marks_and_modes(calm: Theme) -> None:
    operator, observer = watched(calm)
    now = operator.now()
    operator.commands.say("Well held.", "A", now)
    assert observer.last == ("anna: Saying “Well held.” …", "plain")
    operator.commands.note("coughs", now)
    operator.commands.event("phone rang", now)
    operator.commands.hold(now)
    operator.commands.level(1, now)
    operator.driver.wait(1000)
    assert [(line.text, line.tone) for line in observer.commands.log.lines] == [
        ("anna: Said “Well held.”", "good"),
        ("anna: Noted “coughs”", "good"),
        ("anna: Event: phone rang", "good"),
        ("anna: Difficulty: manual", "good"),
        (f"anna: Level {operator.commands.state.next_level}", "good"),
    ]


def test_a_therapists_mark_is_in_the_log_of_everybody() -> None:
    commands = Commands()
    commands.receive(b.welcome("observer", marks=b.MARKS))
    mark = m.SessionCommand(id="1", command="mark", actor="therapist", reason="missed", at=b.START)
    commands.receive([b.frame(COMMAND, mark), b.frame(ANSWERED, answer_to(mark, b.START))])
    assert commands.log.lines == [Line(b.START, "therapist: Marked: marker missed", "good")]


@pytest.mark.parametrize(("actor", "by"), [("therapist", "therapist: "), (ANNA, "you: ")])
def test_a_mark_that_is_removed_is_logged_as_removed(actor: str, by: str) -> None:
    commands = Commands()
    commands.receive(b.welcome(marks=b.MARKS))
    # without a time stamp, as in the app
    mark = m.SessionCommand(id="1", command="mark", actor=actor, reason="missed")
    removed = answer_to(mark, b.START, why="removed")
    commands.receive([b.frame(COMMAND, mark), b.frame(ANSWERED, removed)])
    assert commands.log.lines == [Line(b.START, f"{by}Unmarked: marker missed", "good")]


def test_earlier_notes_are_there_for_an_observer_who_joins_late_and_are_not_doubled() -> None:
    note = b.frame(NOTE_ADDED, m.NoteAdded(text="coughs", actor=ANNA, at=b.START))
    commands = Commands()
    for _ in range(2):  # the connection is lost in between
        commands.receive(b.welcome("observer"))
        commands.receive([note])
    assert [line.text for line in commands.log.lines] == ["anna: Noted “coughs”"]


def test_ones_own_acts_are_not_doubled_when_the_session_sends_them_again(calm: Theme) -> None:
    panel = Panel(session(calm))
    panel.commands.note("coughs", panel.now())
    panel.commands.receive(b.welcome())
    panel.commands.receive([b.frame(NOTE_ADDED, panel.driver.last(NOTE_ADDED))])
    assert [line.text.partition(" · ")[0] for line in panel.commands.log.lines] == [
        "Noted “coughs”"
    ]

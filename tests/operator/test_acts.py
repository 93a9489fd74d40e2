"""The log of the panel marks as done only what the session has answered so, for the operator who
acts and for those who watch. What the session answers when: `tests/loop/test_answers.py`.
"""

from collections.abc import Callable
from typing import Any

import pytest
from msgspec.structs import replace

from sar_tui.link.peer import Connection
from sar_tui.loop.answers import answer_to
from sar_tui.loop.bus import Topic
from sar_tui.loop.topics import (
    ACTION,
    ANSWERED,
    ARBITER_STATE,
    COMMAND,
    DECISION,
    HALT,
    MODE,
    NOTE_ADDED,
    OUTPUT,
    PENDING_APPROVAL,
    REMARK,
    STOPPED,
    WAITING,
)
from sar_tui.model import messages as m
from sar_tui.model.language import ENGLISH, Language
from sar_tui.model.messages import Role
from sar_tui.model.step import Step
from sar_tui.model.units import MS, SECOND
from sar_tui.operator import status_view
from sar_tui.operator.act_log import mark_wording
from sar_tui.operator.commands import Commands
from sar_tui.operator.event_text import Line
from sar_tui.operator.session_state import UNCONFIRMED, Stop
from tests.operator import panel_driver as b

NOW = b.START
PROPOSAL = b.approval("p1")


class Panel:
    """A panel's commands and log at a session, without a screen."""

    def __init__(self, role: Role = "operator", tr: Language = ENGLISH) -> None:
        self.commands = Commands(tr)
        self.peer = b.FakePeer(self.commands.receive, role)
        self.commands.peer = self.peer
        self.commands.receive(Connection("connected"))
        self.commands.receive(b.welcome(role, marks=b.MARKS))
        self.receive(WAITING, b.waiting("foreperiod"))
        self.receive(PENDING_APPROVAL, PROPOSAL)
        self.receive(ARBITER_STATE, b.arbiter_state(PROPOSAL))
        self.commands.shown = ("p1", NOW - SECOND)

    def receive(self, topic: Topic[Any], message: m.Message) -> None:
        self.commands.receive([b.frame(topic, message)])

    def answer(self, outcome: m.ActOutcome = "done", why: str = "", number: int = -1) -> None:
        """Receive the session's answer to the last act, or another one."""
        act = self.peer.sent[number][1]
        self.receive(ANSWERED, answer_to(act, act.at + 5 * MS, outcome, why))

    @property
    def lines(self) -> list[tuple[str, str]]:
        """Text and tone of each line on an act."""
        return [(line.text, line.tone) for line in self.commands.log.lines]

    def stops(self, now: int) -> list[Line]:
        return [stop.line(now) for stop in self.commands.state.stops]


@pytest.fixture
def panel() -> Panel:
    return Panel()


def decision(verdict: Any, **parts: Any) -> m.Decision:
    return m.Decision(action="p1", verdict=verdict, **parts)


def command(command: Any, reason: str = "", **more: Any) -> m.SessionCommand:
    return m.SessionCommand(command=command, reason=reason, **more)


ACTS: list[tuple[Callable[[Commands], bool], str, str]] = [
    (lambda c: c.decide(PROPOSAL, "accept", NOW), "Approving feedback", "Approved feedback"),
    (lambda c: c.edit(PROPOSAL, "Good.", NOW), "Editing feedback", "Edited feedback"),
    (lambda c: c.pause(NOW), "Pausing", "Paused"),
    (
        lambda c: c.prompt_command("skip", NOW),
        "Skipping the prompt",
        "Skipped the prompt",
    ),
    (lambda c: c.level(1, NOW), "Level 4 → 5", "Level 4 → 5"),
    (lambda c: c.hold(NOW), "Level held", "Level held"),
    (lambda c: c.note("coughs", NOW), "Noting “coughs”", "Noted “coughs”"),
    (lambda c: c.event("phone rang", NOW), "Event: phone rang", "Event: phone rang"),
    (
        lambda c: c.send(mark_wording("missed", c.tr), COMMAND, command("mark", "missed"), NOW),
        "Marking: missed",
        "Marked: missed",
    ),
]


@pytest.mark.parametrize(("act", "doing", "done"), ACTS, ids=[done for *_, done in ACTS])
def test_an_act_is_marked_as_done_when_the_session_has_answered_so(
    panel: Panel, act: Callable[[Commands], bool], doing: str, done: str
) -> None:
    assert act(panel.commands)
    assert panel.lines == [(f"{doing} …", "plain")]
    panel.answer()
    assert panel.lines == [(f"{done} · link 5 ms", "good")]


def test_an_act_that_is_late_or_refused_is_never_marked_as_done(panel: Panel) -> None:
    for _ in range(2):
        panel.commands.prompt_command("skip", NOW)
    panel.answer("late", "No prompt is shown.", 0)
    panel.answer("refused", "It did not arrive.", 1)
    assert panel.lines == [
        ("Skipping the prompt: too late, no prompt is shown", "bad"),
        ("Skipping the prompt: not done, it did not arrive", "bad"),
    ]


@pytest.mark.parametrize(
    ("waiting", "when"),
    [
        (b.waiting("response"), " after the response"),
        (b.waiting("resume", "paused"), " after the pause"),
        (b.waiting("enter", "attempt"), ""),
    ],
)
def test_a_remark_says_what_it_waits_for(panel: Panel, waiting: m.Waiting, when: str) -> None:
    panel.receive(WAITING, waiting)
    assert panel.commands.say("Well held.", "A", NOW)
    assert panel.lines == [(f"Saying “Well held.”{when} …", "plain")]


def test_each_of_three_remarks_that_are_refused_says_so_and_its_text_can_be_said_again(
    panel: Panel,
) -> None:
    for _ in range(3):
        assert panel.commands.say("Well held.", "A", NOW)
    for number in range(3):
        panel.answer("refused", "An output failed: speech.", number)
    text = "Saying “Well held.”: not done, an output failed: speech; the text is kept"
    assert panel.lines == [(text, "bad")] * 3
    assert panel.commands.log.unused_text(REMARK) == "Well held."


def test_an_edit_that_comes_too_late_can_still_be_said(panel: Panel) -> None:
    assert panel.commands.edit(PROPOSAL, "Well held.", NOW)
    assert panel.commands.log.unused_text(REMARK) == ""
    panel.answer("late")
    assert panel.commands.log.unused_text(REMARK) == "Well held."
    assert panel.commands.say("Well held!", "A", NOW)
    assert panel.commands.log.unused_text(REMARK) == ""


@pytest.mark.parametrize(
    ("state", "why"), [("lost", "the connection was lost"), ("ended", "the session is over")]
)
def test_after_a_lost_connection_an_act_is_not_confirmed_until_its_answer_comes(
    panel: Panel, state: Any, why: str
) -> None:
    panel.commands.command("stop", NOW)
    panel.commands.say("Well held.", "A", NOW)
    panel.commands.receive(Connection(state))
    panel.commands.receive(Connection("connected"))
    panel.commands.receive(b.welcome())
    stop = (f"Stopping: not confirmed: {why}", "bad")
    assert panel.lines == [stop, (f"Saying “Well held.”: not confirmed: {why}", "bad")]
    panel.answer()
    assert panel.lines == [stop, ("Said “Well held.” · link 5 ms", "good")]


def test_the_operator_skips_the_question_that_is_asked_unless_only_the_participant_can_answer_it(
    panel: Panel,
) -> None:
    consent = Step(name="consent", text="?", kind="choice", labels=("yes", "no"), required="yes")
    asked = m.AskedStep(number=1, step=replace(consent, before=True))
    panel.receive(WAITING, b.waiting("step", "step", step=asked))
    assert not panel.commands.prompt_command("skip", NOW)
    assert panel.peer.sent == []
    effort = m.AskedStep(number=7, step=Step(name="effort", text="How hard?", kind="text"))
    panel.receive(WAITING, b.waiting("step", "step", step=effort))
    assert panel.commands.prompt_command("skip", NOW)
    act = panel.peer.sent[-1][1]
    assert (act.command, act.reason, act.value) == ("skip", "step", 7)


# --- stopping the agent


def stopped(output: str, at: int, detail: str = "") -> m.OutputStopped:
    return m.OutputStopped(output=output, asked=NOW, at=at, detail=detail)


def test_a_stop_is_confirmed_by_the_outputs_that_are_open(panel: Panel) -> None:
    for output in ("speech", "robot"):
        opened = m.OutputOpened(output=output, address=output, can=("say",))
        panel.receive(OUTPUT, opened)
    assert panel.commands.command("stop", NOW)
    assert panel.lines == [("Stopping …", "plain")]
    panel.receive(COMMAND, panel.peer.sent[-1][1])
    panel.answer()
    assert panel.lines == [], "a stop that arrived has a line of its own"
    you = "You stopped the agent"
    assert panel.stops(NOW) == [Line(NOW, f"{you}: stopping robot, speech …")]
    panel.receive(STOPPED, stopped("speech", NOW + 30 * MS))
    assert panel.stops(NOW) == [Line(NOW, f"{you}: stopping robot …")]
    panel.receive(STOPPED, stopped("robot", NOW + 20 * MS))
    assert panel.stops(NOW) == [Line(NOW, f"{you}: stopped after 30 ms", "good")]


def test_an_output_that_cannot_stop_or_never_answers_is_named() -> None:
    stop = Stop(1000, "P01 pressed F2", frozenset({"robot", "speech"}))
    stop = stop.reported(stopped("speech", 1000))
    assert stop.outcome(1000 + UNCONFIRMED) == ("stopping robot …", "plain")
    assert stop.outcome(1001 + UNCONFIRMED) == ("not confirmed: robot", "bad")
    failed = stop.reported(stopped("robot", 1000, "It did not stop in time."))
    assert failed.outcome(1000) == ("not confirmed: robot (It did not stop in time.)", "bad")


@pytest.mark.parametrize("role", ["operator", "observer"])
def test_everybody_sees_that_the_participant_pressed_f2_until_the_agent_acts_again(
    role: Role,
) -> None:
    panel = Panel(role)

    def activity() -> str:
        return status_view.activity(panel.commands.state, 60, NOW).plain

    opened = m.OutputOpened(output="speech", address="speech", can=("say",))
    panel.receive(OUTPUT, opened)
    panel.receive(COMMAND, m.SessionCommand(command="stop"))
    panel.receive(HALT, m.Halt(reason="stopped", asked=NOW))
    assert panel.stops(NOW) == [Line(NOW, "P01 pressed F2: stopping speech …")]
    assert "Stopping speech … · P01" in activity()
    panel.receive(STOPPED, stopped("speech", NOW))
    assert panel.stops(NOW) == [Line(NOW, "P01 pressed F2: stopped after 0 ms", "good")]
    assert "✓ Stopped · P01 pressed F2" in activity()
    panel.receive(ACTION, b.action("a1"))
    assert "pressed F2" not in activity()


# --- those who watch


OTHERS: list[tuple[Topic[Any], Any, str]] = [
    (DECISION, decision("accept"), "Approved feedback"),
    (DECISION, decision("edit", text="Good."), "Edited feedback: “Good.”"),
    (DECISION, decision("edit", valence="negative"), "Negative face, same words: fe…"),
    (DECISION, decision("edit", level=3), "Edited feedback: level 3"),
    (REMARK, m.Remark(text="Well held."), "Said “Well held.”"),
    (REMARK, m.Remark(gesture="lean_in"), "Gesture: lean in"),
    (MODE, m.ModeChanged(kind="difficulty", mode="manual"), "Difficulty: manual"),
    (COMMAND, command("level", value=5), "Level 5"),
    (COMMAND, command("skip"), "Skipped the prompt"),
    (COMMAND, command("skip", "rest"), "Ended the rest"),
    (COMMAND, command("end", "finished"), "Ended the session"),
    (COMMAND, command("skip", "step", value=1), "Skipped the question"),
    (COMMAND, command("mark", "missed"), "Marked: marker missed"),
]


@pytest.mark.parametrize(
    ("topic", "act", "done"),
    OTHERS,
    ids=lambda value: value if isinstance(value, str) else type(value).__name__,
)
def test_an_observer_sees_what_the_operator_does_and_when_it_is_done(
    topic: Topic[Any], act: Any, done: str
) -> None:
    panel = Panel("observer")
    act = replace(act, id="1", actor=b.ANNA, at=NOW)
    panel.receive(topic, act)
    ((text, tone),) = panel.lines
    assert (text.startswith("anna: "), text.endswith(" …"), tone) == (True, True, "plain")
    panel.receive(ANSWERED, answer_to(act, NOW))
    assert panel.lines == [(f"anna: {done}", "good")]


@pytest.mark.parametrize(("actor", "by"), [("therapist", "therapist: "), (b.ANNA, "you: ")])
def test_a_mark_that_is_removed_is_logged_as_removed(panel: Panel, actor: str, by: str) -> None:
    mark = command("mark", "missed", id="1", actor=actor)  # without a time stamp, as in the app
    panel.receive(COMMAND, mark)
    panel.receive(ANSWERED, answer_to(mark, NOW, why="removed"))
    assert panel.commands.log.lines == [Line(NOW, f"{by}Unmarked: marker missed", "good")]


def test_notes_and_events_that_the_session_sends_again_are_not_doubled() -> None:
    observer = Panel("observer")
    for _ in range(2):  # the connection is lost in between
        observer.commands.receive(b.welcome("observer"))
        observer.receive(NOTE_ADDED, m.NoteAdded(text="coughs", actor=b.ANNA, at=NOW))
        observer.receive(NOTE_ADDED, m.NoteAdded(label="phone rang", actor=b.ANNA, at=NOW))
    assert observer.lines == [("anna: Noted “coughs”", "good"), ("anna: Event: phone rang", "good")]
    own = Panel()
    own.commands.note("coughs", NOW)
    own.commands.receive(b.welcome())
    own.receive(NOTE_ADDED, own.peer.sent[-1][1])
    assert own.lines == [("Noting “coughs” …", "plain")]

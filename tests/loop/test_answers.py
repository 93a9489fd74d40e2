"""The session answers each act that carries an id once: done, refused or too late, and why."""

from collections.abc import Callable
from typing import Any

import pytest

from sar_tui.loop import topics as t
from sar_tui.loop.bus import Topic
from sar_tui.model import messages as m
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Mark
from sar_tui.outputs.node import OutputNode
from sar_tui.outputs.output import Output
from sar_tui.plugins import Catalogue
from tests.loop_driver import LoopDriver
from tests.outputs.fake_outputs import FakeOutput, Speaker

ANNA = "operator.anna"
DONE = ("done", "")


class Answers:
    """A session with an operator who awaits an answer to each act."""

    def __init__(
        self, theme: Theme, *outputs: Output, marks: tuple[Mark, ...] = (), **settings: Any
    ) -> None:
        nodes = [OutputNode(output, output.name, theme) for output in outputs]
        quiet = {"attempts": 3, "prompts_per_attempt": 2, "encouragement": False, "filler": "never"}
        self.driver = LoopDriver(
            Catalogue().task("keyboard"), theme, extra=nodes, **quiet | settings
        )
        self.driver.session.task.marks = marks
        joined = m.OperatorChanged(actor=ANNA, state="baton", operated=True, holder=ANNA)
        self.driver.session.bus.publish(t.PRESENCE, joined)
        self.driver.wait(10_000)

    def act(self, topic: Topic[Any], act: m.OperatorAct) -> tuple[str, str] | None:
        """Act now; return outcome and reason, or None if the answer is still to come."""
        self.driver.session.bus.publish(topic, act)
        return self.answer(act.id)

    def command(self, command: Any, reason: str = "", value: int | None = None) -> Any:
        number = len(self.driver.all(t.COMMAND))
        act = m.SessionCommand(
            id=f"{command}{number}", command=command, reason=reason, value=value, actor=ANNA
        )
        return self.act(t.COMMAND, act)

    def answer(self, id: str) -> tuple[str, str] | None:
        found = [each for each in self.driver.all(t.ANSWERED) if each.id == id]
        assert len(found) <= 1, "an act is answered once"
        assert all(each.actor == ANNA for each in found)
        return (found[0].outcome, found[0].why) if found else None


def decision(id: str, action: str, verdict: Any) -> m.Decision:
    return m.Decision(id=id, action=action, verdict=verdict, actor=ANNA)


def remark(id: str, text: str = "Well held.") -> m.Remark:
    return m.Remark(id=id, text=text, actor=ANNA)


# --- commands


@pytest.mark.parametrize(
    ("commands", "last"),
    [
        (["pause"], DONE),
        (["pause", "resume"], DONE),
        (["resume"], ("late", "The session is not paused.")),
        (["skip"], DONE),
        (["repeat"], DONE),
        (["pause", "repeat"], ("late", "No prompt is shown.")),
        (["pause", "skip"], ("late", "No prompt is shown.")),
        (["hold"], DONE),
        (["release"], DONE),
        (["level"], DONE),
        (["stop"], DONE),
        (["end"], DONE),
        (["end", "pause"], ("late", "The session is over.")),
    ],
    ids="-".join,
)
def test_a_command_is_answered(calm: Theme, commands: list[str], last: tuple[str, str]) -> None:
    session = Answers(calm)
    session.driver.start()
    answers = [session.command(command) for command in commands]
    assert answers[-1] == last
    assert answers[:-1] == [DONE] * (len(commands) - 1)


def test_a_pause_while_the_disk_fails_is_refused(calm: Theme) -> None:
    session = Answers(calm)
    session.driver.start()
    session.driver.disk(working=False)
    assert session.command("pause") == ("refused", "The session cannot write to the disk.")


def test_a_question_that_is_answered_meanwhile_is_not_skipped(calm: Theme) -> None:
    session = Answers(calm, questions=("exertion", "tiredness"), questions_every=1)
    session.driver.enter()
    session.driver.attempt()
    session.driver.wait(10_000)
    asked = session.driver.waiting.step
    assert asked
    assert session.command("skip", "step", asked.number) == DONE
    late = ("late", "The participant has just answered.")
    assert session.command("skip", "step", asked.number) == late


def test_a_mark_says_whether_it_was_removed(calm: Theme) -> None:
    session = Answers(calm, marks=(Mark("slip", "f9", "Slipped", counts=False),))
    assert session.command("mark", "slip") == ("refused", "There is no trial to mark.")
    session.driver.enter()
    session.driver.attempt()
    assert session.command("mark", "slip") == DONE
    assert session.command("mark", "slip") == ("done", "removed")
    assert session.command("mark", "nonsense")[0] == "refused"


# --- other acts


def test_modes_notes_and_settings_are_answered(calm: Theme) -> None:
    session = Answers(calm)
    mode = m.ModeChanged(id="m", kind="feedback", mode="approve", actor=ANNA)
    assert session.act(t.MODE, mode) == DONE
    assert session.act(t.NOTE_ADDED, m.NoteAdded(id="n", text="coughs", actor=ANNA)) == DONE
    goal = m.SettingChanged(id="s", name="threshold", value=700, actor=ANNA)
    assert session.act(t.SETTING, goal) == DONE
    wrong = session.act(t.SETTING, m.SettingChanged(id="w", name="seed", value=1, actor=ANNA))
    assert wrong
    assert wrong[0] == "refused"


@pytest.mark.parametrize("verdict", ["accept", "veto", "edit"])
def test_a_decision_is_answered_and_a_second_one_is_late(calm: Theme, verdict: str) -> None:
    session = Answers(calm, operator_feedback="approve")
    session.driver.enter()
    session.driver.attempt()
    id = session.driver.last(t.PENDING_APPROVAL).proposal.id
    assert session.act(t.DECISION, decision("1", id, verdict)) == DONE
    late = session.act(t.DECISION, decision("2", id, "accept"))
    assert late == ("late", "It was decided, or its time was over.")


# --- what outputs carry out


def test_a_remark_is_done_when_it_was_said(calm: Theme) -> None:
    session = Answers(calm, Speaker(1500))
    session.driver.start()
    assert session.act(t.REMARK, remark("1")) is None, "a response is awaited"
    session.driver.answer()
    session.driver.wait(1000)
    assert session.answer("1") is None
    session.driver.wait(1500)
    assert session.answer("1") == DONE


def test_without_outputs_a_remark_is_done_at_once(calm: Theme) -> None:
    assert Answers(calm).act(t.REMARK, remark("1")) == DONE


def test_a_remark_that_an_output_cannot_say_is_refused(calm: Theme) -> None:
    broken = FakeOutput("speech", frozenset({"say"}), breaks=("say",))
    session = Answers(calm, broken)
    session.act(t.REMARK, remark("1"))
    session.driver.wait(0)
    assert session.answer("1") == ("refused", "An output failed: speech.")


def test_an_output_that_never_reports_is_given_up(calm: Theme) -> None:
    silent = FakeOutput("robot", frozenset({"say"}))
    session = Answers(calm, silent)
    session.act(t.REMARK, remark("1"))
    session.driver.wait(120_000)
    answer = session.answer("1")
    assert answer
    assert answer[0] == "refused"


@pytest.mark.parametrize(
    ("end", "answer"),
    [
        (lambda session: session.command("stop"), ("refused", "The agent was stopped.")),
        (lambda session: session.command("end"), ("late", "The session had moved on.")),
        (
            lambda session: session.act(t.DECISION, decision("3", "o2", "veto")),
            ("refused", "It was cancelled."),
        ),
    ],
    ids=["stopped", "ended", "cancelled"],
)
def test_a_remark_that_waits_and_is_dropped_was_not_said(
    calm: Theme, end: Callable[[Answers], object], answer: tuple[str, str]
) -> None:
    session = Answers(calm, Speaker(500))
    session.driver.start()
    session.act(t.REMARK, remark("1"))
    session.act(t.REMARK, remark("2"))
    assert end(session) == DONE
    assert session.answer("2") == answer


@pytest.mark.parametrize(
    ("state", "answer"),
    [
        ("aborted", DONE),
        ("done", ("late", "It was over already.")),
        ("failed", ("refused", "An output failed: robot.")),
    ],
)
def test_a_cancellation_is_answered_when_the_output_is_still(
    calm: Theme, state: Any, answer: tuple[str, str]
) -> None:
    robot = FakeOutput("robot", frozenset({"gesture"}))
    session = Answers(calm, robot)
    for what, action, *_ in robot.asked:
        if what == "gesture":
            robot.report(action, "gesture", "done")
    session.driver.wait(10_000)
    session.act(t.REMARK, m.Remark(id="1", gesture="nod", source="gesture", actor=ANNA))
    assert session.act(t.DECISION, decision("2", "o1", "veto")) is None
    robot.report("o1", "gesture", state)
    session.driver.wait(0)
    assert session.answer("2") == answer
    assert session.answer("1") != (DONE if state == "aborted" else None)


# --- acts without an id


def test_an_act_without_an_id_is_not_answered(calm: Theme) -> None:
    session = Answers(calm, Speaker(500))
    session.driver.start()
    session.act(t.REMARK, remark(""))
    session.act(t.DECISION, decision("", "o1", "veto"))
    session.act(t.NOTE_ADDED, m.NoteAdded(text="coughs"))
    session.driver.operate("stop")
    session.driver.operate("end")
    assert session.driver.all(t.ANSWERED) == []

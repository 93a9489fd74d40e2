"""Practice on a recorded session: a trainee decides, and is compared with protocol and operator."""

from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from sar_tui.link.peer import Frame
from sar_tui.loop import topics as t
from sar_tui.loop.clock import VirtualClock
from sar_tui.model import messages as m
from sar_tui.model.units import MS, SECOND
from sar_tui.operator.practice import Practice, PracticeResult, sections
from sar_tui.operator.practice_app import recorded_practice
from sar_tui.operator.practice_log import note_practice, times_practised
from sar_tui.rules.protocol_file import parse
from sar_tui.runs.plan import make_plan
from sar_tui.runs.run import resume, start
from sar_tui.store import sessions
from sar_tui.store.database import connect
from sar_tui.store.messages import StoredMessage
from tests.played import catalogue, play, simulated, somebody

PROTOCOL = parse(
    b"""
name = "train"
version = 1

[[steps]]
at = "start"
do = "say greeting"

[[steps]]
at = "after attempt 1"
do = "approve feedback"

[[steps]]
at = "after attempt 2"
do = "veto feedback"

[[steps]]
at = "end"
do = "Thank them warmly."
"""
)
NAME = "operator.eve"


@pytest.fixture(scope="module", params=["careful", ""])
def recorded(request: Any, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str, str]:
    """A data folder with a session with an operator, and one without."""
    data = tmp_path_factory.mktemp("data")
    settings = {"attempts": 4, "prompts_per_attempt": 2, "operator_feedback": "approve"}
    return data, simulated(data, operator=request.param, **settings), request.param


def practice_on(recorded: tuple[Path, str, str], speed: float = 4) -> Practice:
    data, id, _ = recorded
    database = connect(data)
    row = sessions.find(database, data, id)
    return recorded_practice(database, data, catalogue(), row, NAME, PROTOCOL, speed)


class Trainee:
    """Decides on each proposal after a second; ticks what is due if wanted."""

    def __init__(self, practice: Practice, verdicts: list[str], *, ticks: bool) -> None:
        self.practice, self.verdicts, self.ticks = practice, verdicts, ticks
        self.frames: list[Frame] = []
        self.waits: list[bool] = []

    def play(self) -> PracticeResult:
        self.take(self.practice.begin())
        for _ in range(20_000):
            if self.practice.is_over:
                return self.practice.result()
            self.take(self.practice.advance(50 * MS))
        raise AssertionError("the practice does not end")

    def take(self, frames: list[Frame]) -> None:
        self.frames += frames
        for frame in frames:
            match frame.message:
                case m.ArbiterState(pending=[first, *_]) if self.verdicts:
                    self.decide(first.proposal.id, self.verdicts.pop(0))
                case m.ProtocolDue(id=id) if self.ticks:
                    self.act(t.PROTOCOL_TICKED, m.ProtocolTicked(due=id, outcome="done"))

    def decide(self, id: str, verdict: Any) -> None:
        self.frames += self.practice.act(t.PROPOSAL_SEEN, self.seen(id))
        before = self.practice.now
        self.frames += self.practice.advance(SECOND)
        self.waits.append(self.practice.now - before == SECOND)
        self.act(t.DECISION, m.Decision(action=id, verdict=verdict))

    def seen(self, id: str) -> m.ProposalSeen:
        return m.ProposalSeen(action=id, actor=NAME, at=self.practice.now)

    def act(self, topic: Any, act: Any) -> None:
        act = replace(act, actor=NAME, at=self.practice.now, id="ab")
        self.take(self.practice.act(topic, act))


def test_a_trainee_is_compared_with_the_protocol_and_the_recorded_operator(
    recorded: tuple[Path, str, str],
) -> None:
    trainee = Trainee(practice_on(recorded), ["accept", "accept", "veto"], ticks=False)
    result = trainee.play()
    assert result.is_complete
    assert all(trainee.waits), "time goes as it was while a proposal waits"
    kinds = [each.kind for each in result.proposals]
    is_operated = bool(recorded[2])
    assert set(kinds) == {"feedback"} if is_operated else "feedback" in kinds
    assert [each.yours for each in result.proposals][:4] == ["accepted", "accepted", "vetoed", ""]
    assert result.proposals[0].decision_ms == 1000
    assert (result.decided, result.timed_out) == (3, len(kinds) - 3)
    assert bool(result.as_recorded.of) == is_operated
    if is_operated:
        assert [each.protocol for each in result.proposals[:2]] == ["accepted", "accepted"]
        assert result.as_protocol.same >= 2
    assert result.adherence.due == 4
    assert result.adherence.omitted == 4
    texts = [part for each in sections(result) for part in each.parts if isinstance(part, str)]
    assert any("decided in time" in text for text in texts)


def test_nothing_of_the_recorded_operator_is_seen(recorded: tuple[Path, str, str]) -> None:
    trainee = Trainee(practice_on(recorded, 16), [], ticks=True)
    result = trainee.play()
    assert result.decided == 0
    acts = [each.message for each in trainee.frames if isinstance(each.message, m.OperatorAct)]
    assert {act.actor for act in acts} <= {NAME, "participant"}
    actions = [each.message for each in trainee.frames if each.topic is t.ACTION]
    assert actions
    assert all(act.kind != "remark" for act in actions)  # type: ignore[attr-defined]
    assert result.adherence.done == result.adherence.due == 4
    assert result.adherence.latency_s
    assert result.adherence.latency_s.most < 1
    times = [each.at for each in trainee.frames]
    assert times == sorted(times)


def test_the_session_waits_for_each_decision_and_goes_on_as_it_was(
    recorded: tuple[Path, str, str],
) -> None:
    practice = practice_on(recorded)
    began, recorded_ns = practice.now, practice._times[-1] - practice._times[0]
    result = Trainee(practice, [], ticks=True).play()
    if not recorded[2]:  # an operator's time is in the record
        assert practice.now - began > recorded_ns + (result.timed_out - 1) * 5 * SECOND


def test_what_the_trainee_vetoes_is_not_done(recorded: tuple[Path, str, str]) -> None:
    trainee = Trainee(practice_on(recorded), ["veto"], ticks=True)
    result = trainee.play()
    done = [each.message.id for each in trainee.frames if each.topic is t.ACTION]  # type: ignore[attr-defined]
    assert done
    assert result.proposals[0].id not in done


def test_commands_of_the_recorded_operator_are_not_shown(recorded: tuple[Path, str, str]) -> None:
    practice = practice_on(recorded)
    at = practice.now
    pauses = [m.SessionCommand(command="pause", actor=actor) for actor in ("operator.x", "B")]
    practice._records = [StoredMessage(n, 1, at, t.COMMAND, act) for n, act in enumerate(pauses)]
    practice._times = [at, at]
    assert [frame.message for frame in practice.advance(SECOND)] == [pauses[1]]


def test_the_recorded_session_is_not_changed(recorded: tuple[Path, str, str]) -> None:
    database = connect(recorded[0])
    before = [*database.execute("SELECT * FROM messages")]
    Trainee(practice_on(recorded), ["veto"] * 9, ticks=True).play()
    assert [*database.execute("SELECT * FROM messages")] == before


def test_acts_that_cannot_change_a_recorded_session_are_refused(
    recorded: tuple[Path, str, str],
) -> None:
    practice = practice_on(recorded)
    practice.begin()
    (answer,) = practice.act(t.COMMAND, m.SessionCommand(command="pause", id="a", actor=NAME))
    assert answer.message.outcome == "refused"  # type: ignore[attr-defined]
    (answer,) = practice.act(t.DECISION, m.Decision(action="?", verdict="veto", id="a"))
    assert answer.message.outcome == "late"  # type: ignore[attr-defined]


def test_practices_are_counted_by_operator_and_version(tmp_path: Path) -> None:
    assert times_practised(tmp_path, "eve", PROTOCOL) == 0
    note_practice(tmp_path, "eve", "s1", PROTOCOL)
    note_practice(tmp_path, "eve", "s2", PROTOCOL)
    note_practice(tmp_path, "ben", "s2", PROTOCOL)
    with (tmp_path / "wizard-practice.jsonl").open("a") as file:
        file.write("broken\n")
    assert times_practised(tmp_path, "eve", PROTOCOL) == 2
    assert times_practised(tmp_path, "eve", replace(PROTOCOL, version=2)) == 0


def practised_whole(data: Path, id: str) -> tuple[Trainee, PracticeResult]:
    trainee = Trainee(practice_on((data, id, "")), [], ticks=True)
    return trainee, trainee.play()


def test_the_time_between_the_runs_of_a_session_is_left_out(tmp_path: Path) -> None:
    plan = make_plan(catalogue(), "keyboard", ["P01"], {"attempts": 6, "prompts_per_attempt": 3})
    run = start(plan, tmp_path, catalogue(), clock := VirtualClock(), somebody)
    play(run, clock, 40)
    clock = VirtualClock(100_000 * SECOND)
    play(resume(run.id, tmp_path, catalogue(), clock, somebody), clock)
    trainee, result = practised_whole(tmp_path, run.id)
    assert result.is_complete
    times = [frame.at for frame in trainee.frames]
    assert times == sorted(times)
    assert times[-1] - times[0] < 300 * SECOND


def test_a_session_of_two_is_practised(tmp_path: Path) -> None:
    id = simulated(tmp_path, "pairs", "P01", "P02", attempts=2, operator_feedback="approve")
    trainee, result = practised_whole(tmp_path, id)
    assert result.is_complete
    asked = [frame.message for frame in trainee.frames if frame.topic is t.ARBITER_STATE]
    seats = {each.seat for state in asked for each in state.pending}  # type: ignore[attr-defined]
    assert seats == {"A", "B"}
    assert trainee.practice.welcome.participants == {"A": "P01", "B": "P02"}


def test_time_goes_as_it_was_while_a_reason_may_be_given(recorded: tuple[Path, str, str]) -> None:
    trainee = Trainee(practice_on(recorded), ["veto"], ticks=True)
    trainee.take(trainee.practice.begin())
    while trainee.verdicts:
        trainee.take(trainee.practice.advance(50 * MS))
    assert trainee.practice.rate == 1
    trainee.act(t.REASON, m.ReasonGiven(action="?", verdict="veto", digit=1, text="late"))
    assert trainee.practice.rate == 4

"""The whole report, on a session written by hand and on simulated ones."""

from pathlib import Path
from typing import Any

import pytest

from sar_tui.model import messages as m
from sar_tui.model.units import MS
from sar_tui.reports.distribution import Distribution
from sar_tui.reports.logged_messages import LoggedMessage, read
from sar_tui.reports.proposals import proposal_records
from sar_tui.reports.wizard import Note, WizardReport, report
from sar_tui.reports.wizard_words import sections
from sar_tui.rules.parameters import TaskParameters
from sar_tui.store import sessions
from sar_tui.store.database import StoreError, connect
from tests.played import simulated as simulate
from tests.reports.session_script import (
    ANNA,
    Script,
    action,
    decision,
    has,
    pending,
    proposal,
    seen,
)
from tests.store.by_hand import sql

SETTINGS = {"operator_feedback": "approve", "attempts": 8, "prompts_per_attempt": 4}
"""The last setting is the task's own; the report ignores it."""


def written_session() -> Script:
    """An operator accepts, edits and misses a proposal, makes remarks, notes and a change of level,
    and is lost.
    """
    parts: Any = {"valence": "negative", "text": "You were slow."}
    first, second, third, fourth = (proposal(f"a{n}", **parts) for n in (1, 2, 3, 4))
    milder = action(second, "edited", text="You were quick.", valence="neutral")
    eve = m.OperatorChanged(actor="observer.eve", role="observer", state="joined", operated=True)
    script = Script().join(0).log(0, eve)
    script.log(10_000, first, pending(first)).log(10_040, seen("a1", 10_030))
    script.log(11_002, decision("a1", ms=11_000), action(first))
    script.log(20_000, second, pending(second)).log(20_040, seen("a2", 20_030))
    script.log(22_034, decision("a2", "edit", 22_030), milder)
    script.log(25_003, m.Remark(text="Take your time.", actor=ANNA, at=25_000_000_000))
    script.log(26_000, m.Remark(gesture="nod", source="gesture", actor=ANNA, at=26_000_000_000))
    script.log(27_000, m.NoteAdded(text="Tired today.", actor=ANNA))
    script.log(28_000, m.NoteAdded(label="yawn", actor=ANNA))
    script.log(29_001, m.SessionCommand(command="level", value=2, actor=ANNA, at=29_000_000_000))
    script.log(30_000, third, pending(third)).log(30_040, seen("a3", 30_030))
    script.log(34_000, action(third, ground="deadline")).gone(40_000)
    return script.log(50_000, fourth, action(fourth, ground="no operator"))


def test_a_session_computed_by_hand() -> None:
    made, latencies = report("s1", SETTINGS, written_session())
    has(made, session="s1", operated=True, operators=[ANNA], observers=["observer.eve"])
    has(made, duration_s=50, operated_s=40, undecided_seen=1, notes=1, event_marks=1, pauses=[])
    (feedback,) = (row for row in made.proposals if row.kind == "feedback")
    has(feedback, mode="approve", time_s=50, time_share=1, unattended_s=10, n=4, share=1)
    names = ("accepted", "edited", "timed_out_done", "no_operator_done")
    assert feedback.fates == dict.fromkeys(names, 1)
    assert latencies.decision == [970, 2000]
    assert made.decision_ms == Distribution(
        n=2, median=1485, iqr=515, p5=1021.5, p25=1227.5, p75=1742.5, p95=1948.5, worst=2000
    )
    assert latencies.waiting == [1002, 2034, 4000], "only pending proposals wait"
    assert sorted(latencies.link) == [0, 1, 2, 3, 4, 10, 10, 10]
    assert made.initiated == {"phrase": 1, "gesture": 1, "level": 1}
    has(made.agreement, decided=2, accepted_share=0.5, valences_overridden=1)
    assert made.agreement.words_changed_median == 0.3333
    assert list(made.agreement_by_kind) == ["feedback"]
    assert made.counts == {"level": 1, "lost": 1}
    assert [(absence.at_s, absence.duration_s) for absence in made.absences] == [(40, 10)]
    assert made.written == [Note(1, 27, ANNA, "Tired today.", ""), Note(1, 28, ANNA, "", "yawn")]
    assert made.plan | {"operator_feedback": "approve", "operator_timeout": "act"} == made.plan


def test_answers_to_operators_are_counted_with_what_the_link_refused() -> None:
    def answered(outcome: m.ActOutcome, actor: str = ANNA) -> m.ActAnswered:
        return m.ActAnswered(id="1", actor=actor, outcome=outcome, at=0)

    def refused(what: str, count: int) -> m.PeerRequestRefused:
        return m.PeerRequestRefused(actor=ANNA, what=what, why="It comes too fast.", count=count)

    script = Script().join(0).log(1000, *map(answered, ("done", "done", "late", "refused")))
    script.log(2000, refused("operator/remark", 3), refused("a connection", 9))
    made, latencies = report("s1", SETTINGS, script.log(3000, answered("done", "therapist")))
    assert made.answers == {"done": 2, "late": 1, "refused": 4}
    said = "The session answered 7 acts of operators: done 2 (29%), not done 4 (57%), too late 1"
    texts = [text for section in sections(made, latencies, 80) for text in section.parts]
    assert any(said in text for text in texts if isinstance(text, str))


def test_the_shares_of_a_kind_that_changed_its_mode() -> None:
    script = Script().join(0).log(1000, proposal("a1"))
    script.log(5000, m.ModeChanged(kind="feedback", mode="veto", actor=ANNA))
    script.log(6000, proposal("a2"), proposal("a3")).log(20_000, m.NoteAdded(actor=ANNA))
    made, _ = report("s1", SETTINGS, script)
    veto, approve = (row for row in made.proposals if row.kind == "feedback")
    has(veto, mode="veto", time_share=0.75, n=2, share=0.6667)
    has(approve, mode="approve", time_share=0.25, n=1, share=0.3333)


def test_acts_at_the_participants_terminal_are_none_of_an_operator() -> None:
    level = m.SessionCommand(command="level", value=3, actor="therapist", at=5_000_000_000)
    goal = m.SettingChanged(name="goal_ms", value=900, at=6_000_000_000)
    notes = [m.NoteAdded(text="x", actor=actor) for actor in ("therapist", ANNA)]
    stop = m.SessionCommand(command="stop", at=8_000_000_000)
    script = Script().join(0).log(5000, level).log(6000, goal, goal).log(7000, *notes)
    made, latencies = report("s1", {}, script.log(8000, stop))
    assert made.therapist == {"level": 1, "goal_ms": 2, "note": 1}
    assert (made.initiated, latencies.link, made.counts) == ({}, [], {})
    made, _ = report("s1", {}, Script())
    assert (made.duration_s, made.operated) == (0, False)
    assert {row.time_share for row in made.proposals} <= {None}


class Simulated:
    """Simulated session with its report, messages and rows."""

    def __init__(self, data: Path, who: str, **settings: Any) -> None:
        values: Any = {"attempts": 10, "prompts_per_attempt": 4, **settings}
        self.id = simulate(data, "keyboard", "SIM", operator=who, **values)
        self.database = connect(data)
        self.messages: list[LoggedMessage] = read(self.database, self.id)
        self.parameters = TaskParameters(**settings)
        stored = sessions.find(self.database, data, self.id)["parameters"]
        self.report: WizardReport = report(self.id, stored, self.messages)[0]

    @property
    def actions(self) -> list[sessions.Row]:
        return sessions.rows(self.database, "actions", self.id)


ALL_APPROVED = {f"operator_{kind}": "approve" for kind in ("feedback", "gesture", "difficulty")}


@pytest.fixture(scope="module", params=["careful", "hasty", "absent"])
def simulated(request: Any, tmp_path_factory: pytest.TempPathFactory) -> Simulated:
    data = tmp_path_factory.mktemp("data")
    return Simulated(data, request.param, operator_encouragement="veto", **ALL_APPROVED)


def test_every_proposal_has_one_outcome(simulated: Simulated) -> None:
    for row in simulated.report.proposals:
        assert sum(row.fates.values()) == row.n
    unattended = sum(row.unattended_s for row in simulated.report.proposals)
    whole = simulated.report.operated_s == simulated.report.duration_s
    assert whole == (not simulated.report.absences) == (unattended == 0)
    assert len(simulated.report.absences) == simulated.report.counts.get("lost", 0)
    for kind in {row.kind for row in simulated.report.proposals if row.n}:
        shares = [row.share for row in simulated.report.proposals if row.kind == kind]
        assert sum(share or 0 for share in shares) == pytest.approx(1, abs=0.001)


def test_proposal_records_agree_with_the_actions_table(simulated: Simulated) -> None:
    found = proposal_records(simulated.messages, simulated.parameters)
    records = {record.id: record for record in found}
    others = ("remark", "difficulty")
    rows = {row["id"]: row for row in simulated.actions if row["kind"] not in others}
    assert {id for id in rows if id[0] == "a"} == {id for id in records if id[0] == "a"}
    for id, row in rows.items():
        if row["decision"] == "dropped":
            assert records[id].said is None, id
        elif row["final"]:
            assert records[id].said == row["final"]["text"], id
            assert (records[id].verdict == "edited") == (row["decision"] == "edited"), id


def test_decision_times_are_between_150_ms_and_the_deadline(simulated: Simulated) -> None:
    times = simulated.report.decision_ms
    assert times is not None
    assert times.p5 >= 150
    both = [row for row in simulated.actions if row["deadline_ns"] and row["shown_ns"]]
    assert times.worst <= max(row["deadline_ns"] - row["shown_ns"] for row in both) / MS
    assert simulated.report.agreement.decided >= times.n > 0


def test_without_an_operator_all_proposals_are_the_agents_and_what_cannot_be_read_is_named(
    tmp_path: Path,
) -> None:
    session = Simulated(tmp_path, "", attempts=2)
    has(session.report, operated=False, operators=[], operated_s=0, deviations=[])
    fates = {fate for row in session.report.proposals for fate in row.fates}
    assert fates <= {"agent", "late"}
    assert session.report.agreement.decided == 0
    keys = "(SELECT id FROM topics WHERE name='input/key')"
    sql(tmp_path, f"UPDATE messages SET message='{{}}' WHERE topic IN {keys}")
    with pytest.raises(StoreError, match="cannot be read by this version"):
        read(session.database, session.id)

"""Operators' decisions, words and requests are stored with actor, kind, reason and time."""

from pathlib import Path
from typing import Any

from sar_tui.loop.topics import (
    COMMAND,
    DECISION,
    NOTE_ADDED,
    PENDING_APPROVAL,
    PRESENCE,
    PROPOSAL_SEEN,
    REMARK,
)
from sar_tui.model import messages as m
from sar_tui.model.units import MS, SECOND
from sar_tui.store import sessions
from tests.store.test_recorder import Recorded

ANA = "operator.ana"


class Operated(Recorded):
    """A simulated session of three attempts with an operator.

    Args:
        verdicts: the decisions, by the number of the pending approval, from 1; no decision on the
            others.
    """

    def __init__(self, data: Path, verdicts: dict[int, dict[str, Any]], **parameters: Any) -> None:
        quiet = {"attempts": 3, "prompts_per_attempt": 2, "encouragement": False, "filler": "never"}
        super().__init__(data, **{**quiet, **parameters})
        self._verdicts = verdicts
        self._count = 0
        self.session.begin()
        self.session.bus.publish(
            PRESENCE, m.OperatorChanged(actor=ANA, state="joined", operated=True)
        )
        self.session.bus.subscribe(PENDING_APPROVAL, self._decide_later)

    def _decide_later(self, approval: m.PendingApproval) -> None:
        """Report the proposal as seen after 200 ms, and decide on it after 700 ms."""
        self._count += 1
        now, bus, clock = self.clock.now(), self.session.bus, self.clock
        id = approval.proposal.id
        clock.call_at(
            now + 200 * MS,
            lambda: bus.publish(
                PROPOSAL_SEEN, m.ProposalSeen(action=id, actor=ANA, at=clock.now())
            ),
        )
        if verdict := self._verdicts.get(self._count):
            reported = m.Decision(action=id, actor=ANA, at=now + 700 * MS, **verdict)
            clock.call_at(now + 700 * MS, lambda: bus.publish(DECISION, reported))

    def rows(self, kind: str) -> list[dict[str, Any]]:
        """Finish the session and return the stored actions of a kind."""
        self.finish()
        self.recorder.write()
        return [
            row for row in sessions.rows(self.reader, "actions", self.id) if row["kind"] == kind
        ]


def test_approved_edited_and_vetoed_actions_can_be_told_apart(data: Path) -> None:
    operated = Operated(
        data,
        {1: {"verdict": "accept"}, 2: {"verdict": "edit", "text": "Fine."}, 3: {"verdict": "veto"}},
        operator_feedback="approve",
        operator_ms_per_word=0,
    )
    rows = operated.rows("feedback")
    assert [
        (row["decision"], row["actor"], row["mode"], row["ground"], row["reason"]) for row in rows
    ] == [
        ("accepted", ANA, "approve", "operator", None),
        ("edited", ANA, "approve", "operator", None),
        ("rejected", ANA, "approve", "operator", "vetoed"),
    ]
    assert [row["final"] and row["final"]["text"] for row in rows] == [
        rows[0]["proposed"]["text"],
        "Fine.",
        None,
    ]
    assert rows[1]["proposed"]["text"] != "Fine."
    for row in rows:
        assert row["shown_ns"] - row["proposed_ns"] == 200 * MS
        assert row["decided_ns"] - row["proposed_ns"] == 700 * MS
        assert row["deadline_ns"] - row["proposed_ns"] == 4 * SECOND
    assert [row["started_ns"] for row in rows] == [
        rows[0]["decided_ns"],
        rows[1]["decided_ns"],
        None,
    ]


def test_a_proposal_that_expired_is_stored_with_its_deadline(data: Path) -> None:
    for timeout, expected in (
        ("act", ("accepted", "deadline", None)),
        ("drop", ("dropped", "deadline", "expired")),
    ):
        operated = Operated(
            data / timeout, {}, operator_feedback="approve", operator_timeout=timeout
        )
        first = operated.rows("feedback")[0]
        assert (first["decision"], first["ground"], first["reason"]) == expected
        assert (first["actor"], first["decided_ns"]) == ("agent", first["deadline_ns"])


def test_a_decision_without_an_operator_is_stored_as_such(data: Path) -> None:
    operated = Operated(data, {}, operator_feedback="approve")
    gone = m.OperatorChanged(actor=ANA, state="lost", operated=False)
    operated.session.bus.subscribe(
        PENDING_APPROVAL, lambda _: operated.session.bus.publish(PRESENCE, gone)
    )
    rows = operated.rows("feedback")
    assert [(row["decision"], row["actor"], row["ground"]) for row in rows] == [
        ("accepted", "agent", "no operator")
    ] * 3


def test_an_operators_own_words_and_notes_are_stored_with_their_times(data: Path) -> None:
    operated = Operated(data, {})
    bus = operated.session.bus
    bus.publish(REMARK, m.Remark(text="Well held.", actor=ANA, at=operated.clock.now()))
    bus.publish(NOTE_ADDED, m.NoteAdded(text="coughs", actor=ANA, at=12 * MS))
    bus.publish(NOTE_ADDED, m.NoteAdded(label="pain", actor=ANA, at=13 * MS))
    (own,) = operated.rows("remark")
    assert (own["id"], own["proposed"], own["proposed_ns"]) == ("o1", None, None)
    assert (own["decision"], own["actor"], own["mode"]) == ("initiated", ANA, "manual")
    assert own["final"]["text"] == "Well held."
    assert own["decided_ns"] <= own["started_ns"] <= own["ended_ns"]
    notes = operated.reader.execute(
        "SELECT at_ns, author, text, label FROM notes ORDER BY at_ns"
    ).fetchall()
    assert notes == [(12 * MS, ANA, "coughs", ""), (13 * MS, ANA, "", "pain")]


def test_level_changes_that_needed_approval_are_rows_too(data: Path) -> None:
    operated = Operated(
        data,
        {1: {"verdict": "veto"}, 2: {"verdict": "edit", "level": 4}},
        operator_difficulty="approve",
        operator_time_ms=2000,
        threshold=60_000,
        min_accuracy=0,
        attempts=4,
    )
    rows = operated.rows("difficulty")
    assert [(row["id"], row["decision"], row["ground"]) for row in rows] == [
        ("l1", "rejected", "operator"),
        ("l2", "edited", "operator"),
        ("l3", "accepted", "deadline"),
    ]
    assert [row["final"] for row in rows] == [None, {"level": 4}, {"level": 5}]
    levels = operated.reader.execute("SELECT level FROM attempts ORDER BY attempt").fetchall()
    assert levels == [(1,), (1,), (4,), (5,)]


def test_a_level_change_dropped_without_an_operator_is_a_row_too(data: Path) -> None:
    operated = Operated(
        data,
        {},
        operator_difficulty="approve",
        operator_lost="silent",
        threshold=60_000,
        min_accuracy=0,
    )
    gone = m.OperatorChanged(actor=ANA, state="left", operated=False)
    operated.session.bus.publish(PRESENCE, gone)
    rows = operated.rows("difficulty")
    assert [
        (row["id"], row["final"], row["decision"], row["actor"], row["ground"]) for row in rows
    ] == [
        ("l1", None, "rejected", "agent", "no operator"),
        ("l2", None, "rejected", "agent", "no operator"),
    ]


def test_the_first_time_a_proposal_was_seen_is_stored(data: Path) -> None:
    operated = Operated(data, {1: {"verdict": "accept"}}, operator_feedback="approve")
    bus, clock = operated.session.bus, operated.clock

    def see_again(approval: m.PendingApproval) -> None:
        late = m.ProposalSeen(
            action=approval.proposal.id, actor="observer.ben", at=clock.now() + 900 * MS
        )
        clock.call_at(clock.now() + 300 * MS, lambda: bus.publish(PROPOSAL_SEEN, late))

    bus.subscribe(PENDING_APPROVAL, see_again)
    first = operated.rows("feedback")[0]
    assert first["shown_ns"] - first["proposed_ns"] == 200 * MS


def test_an_operators_stop_differs_from_the_participants(data: Path) -> None:
    operated = Operated(data, {}, operator_feedback="approve", operator_time_ms=60_000)
    stop = m.SessionCommand(command="stop", actor=ANA)
    bus, clock = operated.session.bus, operated.clock
    bus.subscribe(
        PENDING_APPROVAL,
        lambda _: clock.call_at(clock.now() + 1, lambda: bus.publish(COMMAND, stop)),
    )
    rows = operated.rows("feedback")
    reported = [(row["decision"], row["actor"], row["reason"], row["ground"]) for row in rows]
    assert reported == [("dropped", ANA, "stopped", "operator")] * 3


def test_stored_rows_do_not_depend_on_how_writes_are_batched(data: Path) -> None:
    stored = []
    for folder, is_apart in (("apart", True), ("together", False)):
        operated = Operated(
            data / folder,
            {
                1: {"verdict": "edit", "text": "Fine."},
                2: {"verdict": "edit", "level": 3},
                4: {"verdict": "veto"},
            },
            operator_feedback="approve",
            operator_difficulty="approve",
            operator_time_ms=2000,
            threshold=60_000,
            min_accuracy=0,
        )
        bus = operated.session.bus
        if is_apart:
            bus.tap(lambda _, recorder=operated.recorder: recorder.write())
        bus.publish(REMARK, m.Remark(text="Well held.", actor=ANA, at=operated.clock.now()))
        operated.rows("feedback")
        tables = [
            sessions.rows(operated.reader, name, operated.id)
            for name in ("actions", "trials", "attempts")
        ]
        stored.append([sorted(str({**row, "session": ""}) for row in rows) for rows in tables])
    apart, together = stored
    assert len(apart[0]) > 8
    assert apart == together

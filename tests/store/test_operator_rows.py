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
from tests.store.by_hand import sql
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
        self.bus = self.session.bus
        self.session.begin()
        self.presence("joined", True)
        self.bus.subscribe(PENDING_APPROVAL, self._decide_later)

    def presence(self, state: Any, operated: bool) -> None:
        self.bus.publish(PRESENCE, m.OperatorChanged(actor=ANA, state=state, operated=operated))

    def remark(self) -> None:
        at = self.clock.now()
        self.bus.publish(REMARK, m.Remark(text="Well held.", actor=ANA, at=at))

    def see_later(self, id: str, ms: int, actor: str = ANA, late: int = 0) -> None:
        """Report a proposal as seen, some time from now."""

        def see() -> None:
            at = self.clock.now() + late
            self.bus.publish(PROPOSAL_SEEN, m.ProposalSeen(action=id, actor=actor, at=at))

        self.clock.call_at(self.clock.now() + ms * MS, see)

    def _decide_later(self, approval: m.PendingApproval) -> None:
        """Report the proposal as seen after 200 ms, and decide on it after 700 ms."""
        self._count += 1
        id, at = approval.proposal.id, self.clock.now() + 700 * MS
        self.see_later(id, 200)
        if verdict := self._verdicts.get(self._count):
            reported = m.Decision(action=id, actor=ANA, at=at, **verdict)
            self.clock.call_at(at, lambda: self.bus.publish(DECISION, reported))

    def rows(self, kind: str) -> list[dict[str, Any]]:
        """Finish the session and return the stored actions of a kind."""
        self.finish()
        self.recorder.write()
        return [row for row in self.actions if row["kind"] == kind]


def picked(rows: list[dict[str, Any]], *names: str) -> list[tuple[Any, ...]]:
    return [tuple(row[name] for name in names) for row in rows]


def test_approved_edited_and_vetoed_actions_can_be_told_apart(data: Path) -> None:
    verdicts = {
        1: {"verdict": "accept"},
        2: {"verdict": "edit", "text": "Fine."},
        3: {"verdict": "veto"},
    }
    operated = Operated(data, verdicts, operator_feedback="approve", operator_ms_per_word=0)
    rows = operated.rows("feedback")
    assert picked(rows, "decision", "actor", "mode", "ground", "reason") == [
        ("accepted", ANA, "approve", "operator", None),
        ("edited", ANA, "approve", "operator", None),
        ("rejected", ANA, "approve", "operator", "vetoed"),
    ]
    first, second = (row["proposed"]["text"] for row in rows[:2])
    assert [row["final"] and row["final"]["text"] for row in rows] == [first, "Fine.", None]
    assert second != "Fine."
    for row in rows:
        since = {
            name: row[f"{name}_ns"] - row["proposed_ns"]
            for name in ("shown", "decided", "deadline")
        }
        assert since == {"shown": 200 * MS, "decided": 700 * MS, "deadline": 4 * SECOND}
    assert [row["started_ns"] for row in rows] == [*(row["decided_ns"] for row in rows[:2]), None]


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


def test_an_operators_own_words_and_notes_are_stored_with_their_times(data: Path) -> None:
    operated = Operated(data, {})
    operated.remark()
    for at, note in ((12 * MS, {"text": "coughs"}), (13 * MS, {"label": "pain"})):
        operated.bus.publish(NOTE_ADDED, m.NoteAdded(actor=ANA, at=at, **note))
    (own,) = operated.rows("remark")
    assert picked([own], "id", "proposed", "proposed_ns", "decision", "actor", "mode") == [
        ("o1", None, None, "initiated", ANA, "manual")
    ]
    assert own["final"]["text"] == "Well held."
    assert own["decided_ns"] <= own["started_ns"] <= own["ended_ns"]
    notes = sql(data, "SELECT at_ns, author, text, label FROM notes ORDER BY at_ns")
    assert notes == [(12 * MS, ANA, "coughs", ""), (13 * MS, ANA, "", "pain")]


LEVELS_APPROVED = {"operator_difficulty": "approve", "threshold": 60_000, "min_accuracy": 0}
"""Settings by which each attempt raises the level, if the operator lets it."""


def test_level_changes_that_needed_approval_are_rows_too(data: Path) -> None:
    verdicts = {1: {"verdict": "veto"}, 2: {"verdict": "edit", "level": 4}}
    operated = Operated(data, verdicts, **LEVELS_APPROVED, operator_time_ms=2000, attempts=4)
    assert picked(operated.rows("difficulty"), "id", "decision", "ground", "final") == [
        ("l1", "rejected", "operator", None),
        ("l2", "edited", "operator", {"level": 4}),
        ("l3", "accepted", "deadline", {"level": 5}),
    ]
    levels = sql(data, "SELECT level FROM attempts ORDER BY attempt")
    assert levels == [(1,), (1,), (4,), (5,)]


def test_a_level_change_dropped_without_an_operator_is_a_row_too(data: Path) -> None:
    operated = Operated(data, {}, **LEVELS_APPROVED, operator_lost="silent")
    operated.presence("left", False)
    rows = picked(operated.rows("difficulty"), "id", "final", "decision", "actor", "ground")
    assert rows == [(id, None, "rejected", "agent", "no operator") for id in ("l1", "l2")]


def test_it_is_stored_when_a_proposal_was_first_seen_and_that_its_operator_was_lost(
    data: Path,
) -> None:
    operated = Operated(data, {1: {"verdict": "accept"}}, operator_feedback="approve")
    operated.bus.subscribe(
        PENDING_APPROVAL,
        lambda seen: operated.see_later(seen.proposal.id, 300, "observer.ben", 900 * MS),
    )
    operated.bus.subscribe(PENDING_APPROVAL, lambda _: operated.presence("lost", False))
    first, *others = operated.rows("feedback")
    assert first["shown_ns"] - first["proposed_ns"] == 200 * MS
    assert (
        picked(others, "decision", "actor", "ground") == [("accepted", "agent", "no operator")] * 2
    )


def test_an_operators_stop_differs_from_the_participants(data: Path) -> None:
    operated = Operated(data, {}, operator_feedback="approve", operator_time_ms=60_000)
    stop = m.SessionCommand(command="stop", actor=ANA)

    def stop_soon(_: object) -> None:
        operated.clock.call_at(
            operated.clock.now() + 1, lambda: operated.bus.publish(COMMAND, stop)
        )

    operated.bus.subscribe(PENDING_APPROVAL, stop_soon)
    rows = picked(operated.rows("feedback"), "decision", "actor", "reason", "ground")
    assert rows == [("dropped", ANA, "stopped", "operator")] * 3


def test_stored_rows_do_not_depend_on_how_writes_are_batched(data: Path) -> None:
    edits = {1: {"verdict": "edit", "text": "Fine."}, 2: {"verdict": "edit", "level": 3}}
    stored = []
    for folder in ("apart", "together"):
        operated = Operated(
            data / folder, {**edits, 4: {"verdict": "veto"}}, **LEVELS_APPROVED,
            operator_feedback="approve", operator_time_ms=2000,
        )  # fmt: skip
        if folder == "apart":
            operated.bus.tap(lambda _, recorder=operated.recorder: recorder.write())
        operated.remark()
        operated.rows("feedback")
        tables = ("actions", "trials", "attempts")
        rows = [sessions.rows(operated.reader, name, operated.id) for name in tables]
        stored.append([sorted(str({**row, "session": ""}) for row in each) for each in rows])
    apart, together = stored
    assert len(apart[0]) > 8
    assert apart == together

"""Given a session and a panel at two terminals, when the operator acts, then the participant gets just that."""

import json
from pathlib import Path

from tests.end_to_end.operator_terminal import Room, Row, plain
from tests.end_to_end.participant_terminal import rows

WORDS = "Lovely, and now a little slower."
NOTE = "rubs the left wrist"
SETTINGS = {
    "attempts": 3,
    "prompts_per_attempt": 1,
    "start_level": 3,
    "difficulty_policy": "fixed",
    "encouragement": "no",
    "filler": "never",
    "operator_feedback": "approve",
    "operator_time_ms": 60_000,
}


def test_operator_decisions_reach_the_participant_and_are_stored(data: Path) -> None:
    with Room(data) as room:
        participant, panel = room.both(**SETTINGS)
        usual = participant.answers
        participant.answers = lambda number, expected: (usual(number, expected)[0], "q")
        participant.answer(1)
        vetoed = panel.wait_for_offer()
        panel.does("veto")
        room.until(lambda: not room.offered(), "it is vetoed")

        participant.answers = usual
        participant.answer(1)
        edited = panel.wait_for_offer(vetoed["id"])
        panel.writes("edit", "Edit:", WORDS)
        room.until(lambda: participant.sees(WORDS), "the operator's words in the place of the agent's are seen")

        panel.does("pick-1")
        room.until(lambda: room.actions("remark"), "a phrase is said")
        phrase = room.actions("remark")[0]["final"]["text"]
        room.until(lambda: participant.sees(phrase), "the phrase is seen")
        panel.does("level-down")
        room.until(lambda: room.reported("event_handler/level"), "the level is lowered")
        panel.writes("note", "Note:", NOTE)
        room.until(lambda: rows(data, "SELECT 1 FROM notes"), "the note is kept")

        participant.answer(1)
        approved = panel.wait_for_offer(edited["id"])
        panel.does("approve")
        room.until(lambda: participant.sees(approved["text"]), "the approved words are seen")
        room.until(lambda: all(_is_kept(room, row) for row in (approved, edited)), "the rows are whole")
        seen = participant.has_seen()
        feedback = room.actions("feedback")

    assert not _in(vetoed["text"], seen), "what was vetoed was never seen, not for a frame"
    assert not _in(edited["text"], seen), "nor what was edited"
    assert _in(approved["text"], seen), "what was seen would be found"
    assert [(row["proposed"]["text"], row["final"] and row["final"]["text"]) for row in feedback] == [
        (vetoed["text"], None),
        (edited["text"], WORDS),
        (approved["text"], approved["text"]),
    ]
    messages = [(row["decision"], row["actor"], row["mode"], row["ground"], row["reason"]) for row in feedback]
    assert messages == [
        ("rejected", "operator.ana", "approve", "operator", "vetoed"),
        ("edited", "operator.ana", "approve", "operator", None),
        ("accepted", "operator.ana", "approve", "operator", None),
    ]
    for row in feedback:
        assert row["proposed_ns"] <= row["shown_ns"] < row["decided_ns"]
    assert [row["started_ns"] and row["started_ns"] >= row["decided_ns"] for row in feedback] == [None, True, True]

    (remark,) = [json.loads(row) for (row,) in rows(data, "SELECT final FROM actions WHERE kind='remark'")]
    assert (remark["text"], remark["decision"], remark["actor"]) == (phrase, "initiated", "operator.ana")
    assert rows(data, "SELECT level FROM attempts ORDER BY attempt") == [(3,), (3,), (2,)]
    ((act,),) = rows(data, "SELECT message FROM events WHERE topic='operator/act'")
    assert (json.loads(act)["command"], json.loads(act)["value"], json.loads(act)["actor"]) == (
        "level",
        2,
        "operator.ana",
    )
    ((at, author, text),) = rows(data, "SELECT at_ns, author, text FROM notes")
    assert (author, text) == ("operator.ana", NOTE)
    assert feedback[1]["started_ns"] < at < feedback[2]["proposed_ns"], "stamped with the session's own clock"


def _is_kept(room: Room, proposal: Row) -> bool:
    return any(row["id"] == proposal["id"] and row["started_ns"] for row in room.actions("feedback"))


def _in(text: str, lines: set[str]) -> bool:
    """Whether any four words of a text in a row stood on a line."""
    words = plain(text).split()
    return any(" ".join(words[at : at + 4]) in line for line in lines for at in range(len(words) - 3))

"""A session and an operator's panel in two terminals: decisions reach the participant and are
stored.
"""

import json
from pathlib import Path

import pytest

from tests.end_to_end.operator_terminal import Row, SessionTerminals, plain
from tests.end_to_end.participant_terminal import replays_identically, rows

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


@pytest.mark.slow
def test_operator_decisions_reach_the_participant_and_are_stored(data: Path) -> None:
    with SessionTerminals(data) as terminals:
        participant, panel = terminals.both(**SETTINGS)
        usual = participant.answers
        participant.answers = lambda number, expected: (usual(number, expected)[0], "q")
        participant.answer(1)
        vetoed = panel.wait_for_proposal()
        panel.does("veto")
        terminals.until(lambda: not terminals.pending_proposal(), "it is vetoed")
        terminals.until(
            lambda: plain("Vetoed feedback · link") in panel.sees(), "the veto is answered"
        )

        participant.answers = usual
        participant.answer(1)
        edited = panel.wait_for_proposal(vetoed["id"])
        panel.writes("edit", "Edit:", WORDS)
        terminals.until(
            lambda: participant.sees(WORDS),
            "the operator's words in the place of the agent's are seen",
        )

        panel.does("pick-1")
        terminals.until(lambda: terminals.actions("remark"), "a phrase is said")
        phrase = terminals.actions("remark")[0]["final"]["text"]
        terminals.until(lambda: participant.sees(phrase), "the phrase is seen")
        panel.does("level-down")
        terminals.until(lambda: terminals.reported("event_handler/level"), "the level is lowered")
        panel.writes("note", "Note:", NOTE)
        terminals.until(lambda: rows(data, "SELECT 1 FROM notes"), "the note is kept")
        terminals.until(
            lambda: plain(f"Noted “{NOTE}” · link") in panel.sees(), "the note is answered"
        )

        participant.answer(1)
        approved = panel.wait_for_proposal(edited["id"])
        panel.does("approve")
        terminals.until(lambda: participant.sees(approved["text"]), "the approved words are seen")
        terminals.until(
            lambda: all(_is_stored(terminals, row) for row in (approved, edited)),
            "the rows are whole",
        )
        seen = participant.has_seen()
        feedback = terminals.actions("feedback")

    assert not _shares_four_words(vetoed["text"], seen), (
        "what was vetoed was never seen, not for a frame"
    )
    assert not _shares_four_words(edited["text"], seen), "nor what was edited"
    assert _shares_four_words(approved["text"], seen), "what was seen would be found"
    assert [
        (row["proposed"]["text"], row["final"] and row["final"]["text"]) for row in feedback
    ] == [(vetoed["text"], None), (edited["text"], WORDS), (approved["text"], approved["text"])]
    messages = [
        (row["decision"], row["actor"], row["mode"], row["ground"], row["reason"])
        for row in feedback
    ]
    assert messages == [
        ("rejected", "operator.ana", "approve", "operator", "vetoed"),
        ("edited", "operator.ana", "approve", "operator", None),
        ("accepted", "operator.ana", "approve", "operator", None),
    ]
    for row in feedback:
        assert row["proposed_ns"] <= row["shown_ns"] < row["decided_ns"]
    assert [row["started_ns"] and row["started_ns"] >= row["decided_ns"] for row in feedback] == [
        None,
        True,
        True,
    ]

    (remark,) = [
        json.loads(row) for (row,) in rows(data, "SELECT final FROM actions WHERE kind='remark'")
    ]
    assert (remark["text"], remark["decision"], remark["actor"]) == (
        phrase,
        "initiated",
        "operator.ana",
    )
    assert rows(data, "SELECT level FROM attempts ORDER BY attempt") == [(3,), (3,), (2,)]
    ((act,),) = rows(data, "SELECT message FROM events WHERE topic='operator/act'")
    assert (json.loads(act)["command"], json.loads(act)["value"], json.loads(act)["actor"]) == (
        "level",
        2,
        "operator.ana",
    )
    ((at, author, text),) = rows(data, "SELECT at_ns, author, text FROM notes")
    assert (author, text) == ("operator.ana", NOTE)
    assert feedback[1]["started_ns"] < at < feedback[2]["proposed_ns"], (
        "stamped with the session's own clock"
    )
    answers = rows(data, "SELECT message FROM events WHERE topic='operator/answered'")
    assert [json.loads(message)["outcome"] for (message,) in answers] == ["done"] * 6
    assert replays_identically(data)


def _is_stored(terminals: SessionTerminals, proposal: Row) -> bool:
    return any(
        row["id"] == proposal["id"] and row["started_ns"] for row in terminals.actions("feedback")
    )


def _shares_four_words(text: str, lines: set[str]) -> bool:
    """Return True if any four consecutive words of a text are on one line."""
    words = plain(text).split()
    return any(
        " ".join(words[at : at + 4]) in line for line in lines for at in range(len(words) - 3)
    )

"""Answers to questions between attempts, in words."""

from collections.abc import Iterator, Sequence
from typing import Any

_STATUSES = {"declined": "would rather not say", "skipped": "skipped by an operator"}


def lines(rows: Sequence[dict[str, Any]], practice: int) -> list[str]:
    """Return a line for each question that was asked; several participants are told apart by their
    seats.

    Args:
        rows: of the table ``answers``, as `store.sessions.rows` returns them.
        practice: the number of attempts before the first that counts, as attempts are counted with
            them.
    """
    several = len({row["seat"] for row in rows}) > 1
    return [_line(row, several, practice) for row in rows if row["status"] != "done"]


def _line(row: dict[str, Any], several: bool, practice: int) -> str:
    when = (
        f"After attempt {row['attempt'] + practice}"
        if row["attempt"]
        else "Before the first attempt"
    )
    who = f", seat {row['seat']}" if several else ""
    return f"{when}{who}: {row['text']} {_STATUSES.get(row['status']) or ', '.join(_answer(row))}"


def _answer(row: dict[str, Any]) -> Iterator[str]:
    """Yield the parts of an answer: a number with its word, an option, several, or a text in
    quotation marks.
    """
    answer = row["answer"]
    if isinstance(answer, list):
        yield from map(str, answer)
    elif isinstance(answer, str):
        yield f'"{answer}"' if row["kind"] == "text" else answer
    elif isinstance(answer, int | float):
        labels = row["labels"]
        is_labelled = row["kind"] == "likert" and 0 < answer <= len(labels)
        yield f"{answer:g} ({labels[int(answer) - 1]})" if is_labelled else f"{answer:g}"

"""Answers to questions between attempts, in words."""

from collections.abc import Sequence

from sar_tui.store.records import Record

_STATUSES = {"declined": "would rather not say", "skipped": "skipped by an operator"}


def lines(answers: Sequence[Record], practice: int) -> list[str]:
    """Return a line for each question that was asked; several participants are told apart by their
    seats.

    Args:
        answers: records of the kind ``answer``.
        practice: the number of attempts before the first that counts, as attempts are counted with
            them.
    """
    several = len({answer.seat for answer in answers}) > 1
    asked = [answer for answer in answers if answer.content["status"] != "done"]
    return [_line(answer, several, practice) for answer in asked]


def _line(answer: Record, several: bool, practice: int) -> str:
    content = answer.content
    attempt = int(content["attempt"])
    when = f"After attempt {attempt + practice}" if attempt else "Before the first attempt"
    who = f", seat {answer.seat}" if several else ""
    said = _STATUSES.get(str(content["status"])) or _said(answer)
    return f"{when}{who}: {content['question']} {said}"


def _said(answer: Record) -> str:
    """Return a number with its word, an option, several, or a text in quotation marks."""
    content = answer.content
    chosen = str(content.get("chosen", ""))
    if "words" in content:
        return f'"{content["words"]}"'
    if "value" in content:
        return f"{content['value']:g}{f' ({chosen})' if chosen else ''}"
    return chosen

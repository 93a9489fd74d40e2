"""Pain and tiredness in words: of a session, and what the therapist should know of a
participant.
"""

from collections.abc import Mapping, Sequence

import msgspec

from sar_tui.model.language import Language
from sar_tui.rules.wellbeing import SEVERE, PainLimits, TellReason
from sar_tui.store.adverse_events import AdverseEvent
from sar_tui.store.wellbeing import IN_PAUSE, NOT_SAID, Row, limits_in, ratings

_ENGLISH = Language()
_NAMES = {"pain": "pain", "fatigue": "tiredness"}
_IN_PAUSES = {"pain": "in pain", "fatigue": "tired"}
_MOMENTS = {"before": "before the session", "pause": "in a pause", "after": "after the session"}
_ADVISED = {"stopped": " They stopped.", "went on": " They trained all the same."}
_TOLD: dict[TellReason, str] = {
    "stop": "Pain was above the limit when it was last told. Tell the therapist.",
    "stopped": "The participant was advised not to train, and stopped.",
    "went on": "The participant was advised not to train, and trained all the same.",
    "new pain": "Pain is new: some in each of the last four sessions, and none before. Tell the "
    "therapist.",
    "worse pain": "Pain is worse: more in each of the last four sessions than before them. Tell "
    "the therapist.",
    "tired": "Very tired ({severe} or more of 10) after each of the last two sessions. Tell the "
    "therapist.",
}


def marks(rows: Sequence[Row]) -> str:
    """Return the worst pain and tiredness of a session in a few characters, for a list; empty if
    there is none.

    Pain that was said in a pause is shown even if no number is known.
    """
    found = []
    for question, name in (("pain", "pain"), ("fatigue", "tired")):
        numbers = [
            int(row["answer"])
            for row in rows
            if row["question"] == question and row["answer"].isdecimal()
        ]
        is_said = any(row["question"] == question and row["moment"] == "pause" for row in rows)
        if max(numbers, default=0) or is_said:
            found.append(f"{name} {max(numbers, default=0) or ''}".strip())
    return ", ".join(found)


def sentences(rows: Sequence[Row], seat: str, limits: PainLimits) -> list[str]:
    """Return what a participant said in a session, a sentence for each symptom, and if it was a
    reason to stop.
    """
    mine = [row for row in rows if row["seat"] == seat]
    found = [text for question in _NAMES if (text := _symptom(mine, question))]
    if ratings(mine, seat, limits).is_reason_to_stop:
        found.append("That was a reason to stop and to tell the therapist.")
    for moment, named in _MOMENTS.items():
        advised = [
            row["answer"] for row in mine if (row["moment"], row["question"]) == (moment, "advice")
        ]
        if advised:
            found.append(f"Advised {named} not to train.{_ADVISED.get(advised[-1], '')}")
    return found


def session_lines(session: Row, rows: Sequence[Row], events: Sequence[AdverseEvent]) -> list[str]:
    """Return a line for each participant who said something in a listed session, and for each
    adverse event in it.
    """
    lines = []
    for seat, code in (("A", session["participant"]), ("B", session["partner"])):
        if code and (said := sentences(rows, seat, limits_in(session["parameters"]))):
            lines.append(f"{f'{code}: ' if session['partner'] else ''}{' '.join(said)}")
    return lines + [event_line(event, names_person=bool(session["partner"])) for event in events]


class Visit(msgspec.Struct, frozen=True):
    """Sentences on what a participant said in a session, and when first. ``session``: empty if it
    did not begin.
    """

    at: str
    session: str
    said: list[str]


def by_visit(rows: Sequence[Row], limits: Mapping[str, PainLimits]) -> list[Visit]:
    """Return the answers of one participant by session, oldest first; without a session, those of a
    day together.

    ``limits``: of the sessions, by session.
    """
    grouped: dict[str, list[Row]] = {}
    for row in rows:
        grouped.setdefault(row["session"] or row["at"][:10], []).append(row)

    def visit(own: Sequence[Row]) -> Visit:
        session = own[0]["session"] or ""
        return Visit(
            own[0]["at"], session, sentences(own, own[0]["seat"], limits.get(session, PainLimits()))
        )

    return [visit(own) for own in grouped.values()]


def event_line(event: AdverseEvent, *, names_person: bool = False) -> str:
    """Return an adverse event in words, with its id."""
    who = f" of {event.participant}" if names_person else ""
    return f"! Adverse event {event.event}{who}, {_course(event, _ENGLISH)}"


def dated_event(event: AdverseEvent, tr: Language = _ENGLISH) -> str:
    """Return an adverse event in words, with its onset."""
    return f"{tr('Adverse event')} {event.onset}, {_course(event, tr)}"


def _course(event: AdverseEvent, tr: Language) -> str:
    """Return the severity of an event, what happened, what was done and how it ended."""
    said = [f"{tr(event.severity)}: {_ended(event.what)}"]
    if event.action:
        said.append(f"{tr('Action')}: {_ended(event.action)}")
    said.append(
        f"{tr('Outcome')}: {_ended(event.outcome)}"
        if event.outcome
        else tr("Outcome not yet recorded.")
    )
    return " ".join(said)


def _ended(text: str) -> str:
    """Return a text with a full stop, unless it has an end of its own."""
    return text if text[-1] in ".!?" else f"{text}."


def advice(reasons: Sequence[TellReason], tr: Language = _ENGLISH) -> list[str]:
    """Return a sentence for each thing that the therapist should be told."""
    return [tr(_TOLD[reason], severe=str(SEVERE)) for reason in reasons]


def _symptom(rows: Sequence[Row], question: str) -> str:
    parts = []
    for moment in ("before", "after"):
        given = [
            row["answer"] for row in rows if (row["moment"], row["question"]) == (moment, question)
        ]
        where = [
            row["answer"] for row in rows if (row["moment"], row["question"]) == (moment, "place")
        ]
        if given:
            has_place = question == "pain" and given[-1] != "0" and where and where[-1] != NOT_SAID
            place = f" ({where[-1]})" if has_place else ""
            parts.append(
                f"{'would rather not say' if given[-1] == NOT_SAID else given[-1]} {moment}{place}"
            )
    pauses = [
        row["answer"] for row in rows if (row["moment"], row["question"]) == ("pause", question)
    ]
    if pauses:
        count, numbers = pauses.count(IN_PAUSE), ", then ".join(filter(str.isdecimal, pauses))
        times = "in a pause" if count < 2 else f"in {count} pauses"
        parts.append(f'"{_IN_PAUSES[question]}" {times}' + (f" ({numbers})" if numbers else ""))
    return f"{_NAMES[question].capitalize()}: {', '.join(parts)}." if parts else ""

"""Pain and tiredness in words: of a session, and what the therapist should know of a
participant.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from sar_tui.model.language import ENGLISH, Language
from sar_tui.records.kind import NOT_SAID
from sar_tui.rules.wellbeing import SEVERE, PainLimits, TellReason
from sar_tui.store.records import Record
from sar_tui.store.wellbeing import PAIN, RATED, TIREDNESS, TOLD, limits_in, ratings

_SHORT = {PAIN: "pain", TIREDNESS: "tired"}
_TITLES = {PAIN: "Pain", TIREDNESS: "Tiredness"}
_RATINGS = {"before": "{rating} before", "after": "{rating} after"}
_UNSAID = {"before": "would rather not say before", "after": "would rather not say after"}
_IN_A_PAUSE = {PAIN: '"in pain" in a pause', TIREDNESS: '"tired" in a pause'}
_IN_PAUSES = {PAIN: '"in pain" in {count} pauses', TIREDNESS: '"tired" in {count} pauses'}
_ADVICE = {
    "before": "Advised before the session not to train.",
    "pause": "Advised in a pause not to train.",
    "after": "Advised after the session not to train.",
}
_FOLLOWED = {"stopped": "They stopped.", "went on": "They trained all the same."}
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


def marks(told: Sequence[Record], tr: Language = ENGLISH) -> str:
    """Return the worst pain and tiredness of a session in a few characters, for a list; empty if
    there is none.

    Pain that was told in a pause is shown even if no number is known.
    """
    found = []
    for kind, name in _SHORT.items():
        mine = [record for record in told if record.kind == kind]
        rating = worst(mine, kind)
        if rating or any(record.moment == "pause" for record in mine):
            found.append(f"{tr(name)} {rating}/10" if rating else tr(name))
    return ", ".join(found)


def worst(told: Sequence[Record], kind: str) -> int | None:
    """Return the worst rating of pain or tiredness; None if no number is known."""
    ratings = (_rating(record) for record in told if record.kind == kind)
    return max((rating for rating in ratings if rating is not None), default=None)


def _rating(record: Record) -> int | None:
    rating = record.content.get("rating")
    return rating if isinstance(rating, int) else None


def sentences(
    told: Sequence[Record], seat: str, limits: PainLimits, tr: Language = ENGLISH
) -> list[str]:
    """Return what a participant said in a session, a sentence for each symptom, and if it was a
    reason to stop.
    """
    mine = [record for record in told if record.seat == seat]
    found = [text for kind in _SHORT if (text := _symptom(mine, kind, tr))]
    if ratings(mine, seat, limits).is_reason_to_stop:
        found.append(tr("That was a reason to stop and to tell the therapist."))
    for moment, text in _ADVICE.items():
        advised = [
            record.content["advice"]
            for record in mine
            if record.moment == moment and "advice" in record.content
        ]
        if advised:
            found.append(tr(text))
            if followed := _FOLLOWED.get(str(advised[-1])):
                found.append(tr(followed))
    return found


def session_lines(
    session: Mapping[str, Any],
    told: Sequence[Record],
    events: Sequence[Record],
    tr: Language = ENGLISH,
) -> list[str]:
    """Return a line for each participant who said something in a listed session, and for each
    adverse event in it.
    """
    lines = []
    for seat, code in (("A", session["participant"]), ("B", session["partner"])):
        if code and (said := sentences(told, seat, limits_in(session["parameters"]), tr)):
            lines.append(f"{f'{code}: ' if session['partner'] else ''}{' '.join(said)}")
    names_person = bool(session["partner"])
    return lines + [_event_line(event, tr, names_person=names_person) for event in events]


def _event_line(event: Record, tr: Language, *, names_person: bool) -> str:
    """Return an adverse event in words, with its id."""
    named = (
        tr("Adverse event {id} of {who}", id=event.id, who=event.participant)
        if names_person
        else tr("Adverse event {id}", id=event.id)
    )
    return f"! {named}, {_course(event, tr)}"


def dated_event(event: Record, tr: Language = ENGLISH) -> str:
    """Return an adverse event in words, with its onset."""
    return f"{tr('Adverse event')} {event.at}, {_course(event, tr)}"


def _course(event: Record, tr: Language) -> str:
    """Return the severity of an event, what happened, what was done and how it ended."""
    known = {name: str(value) for name, value in event.content.items()}
    said = [f"{tr(known['severity'])}: {_ended(known['what'])}"]
    if "action" in known:
        said.append(f"{tr('Action')}: {_ended(known['action'])}")
    said.append(
        f"{tr('Outcome')}: {_ended(known['outcome'])}"
        if "outcome" in known
        else tr("Outcome not yet recorded.")
    )
    return " ".join(said)


def _ended(text: str) -> str:
    """Return a text with a full stop, unless it has an end of its own."""
    return text if text[-1] in ".!?" else f"{text}."


def advice(reasons: Sequence[TellReason], tr: Language = ENGLISH) -> list[str]:
    """Return a sentence for each thing that the therapist should be told."""
    return [tr(_TOLD[reason], severe=str(SEVERE)) for reason in reasons]


def _symptom(told: Sequence[Record], kind: str, tr: Language) -> str:
    """Return what was said of a symptom, by moment; empty if nothing was."""
    mine = [record for record in told if record.kind == kind]
    last = {record.moment: record for record in mine}
    given = [last[moment] for moment in ("before", "after") if moment in last]
    parts = [f"{_said(record, tr)}{_place(record, tr)}" for record in given]
    pauses = [record for record in mine if record.moment == "pause"]
    if pauses:
        count = sum(record.content["answer"] == TOLD for record in pauses)
        numbers = [str(rating) for record in pauses if (rating := _rating(record)) is not None]
        times = tr(_IN_A_PAUSE[kind]) if count < 2 else tr(_IN_PAUSES[kind], count=count)
        rated = f" ({' → '.join(numbers)})" if numbers else ""
        parts.append(f"{times}{rated}")
    return f"{tr(_TITLES[kind])}: {', '.join(parts)}." if parts else ""


def _said(record: Record, tr: Language) -> str:
    """Return a rating before or after the session in words."""
    if record.content["answer"] != RATED:
        return tr(_UNSAID[record.moment])
    return tr(_RATINGS[record.moment], rating=str(_rating(record)))


def _place(record: Record, tr: Language) -> str:
    place = str(record.content.get("place", NOT_SAID))
    return f" ({tr(place)})" if place != NOT_SAID and _rating(record) else ""

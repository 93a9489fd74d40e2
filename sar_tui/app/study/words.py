"""The texts on what is due in a study."""

import sqlite3
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from datetime import date, datetime

from sar_tui.app.home.words import day_words, short_day, weekday_words
from sar_tui.model.language import Language, Sentence, error_text, in_language
from sar_tui.store.database import StoreError
from sar_tui.study import ledger
from sar_tui.study.ledger import Differed
from sar_tui.study.plan import PlanError, Study
from sar_tui.study.schedule import Next
from sar_tui.study.secret import key_file
from sar_tui.study.status import PersonRow, VisitCell, as_of, grid

_DEVIATIONS = {
    "missed": "visit missed",
    "early": "early",
    "late": "late",
    "out of order": "out of order",
    "repeated": "repeated",
    "ended early": "ended early",
    "level changed by hand": "level changed by hand",
}


def sentence(plan: Study, rows: Sequence[PersonRow], today: date, tr: Language) -> str:
    """Return the sentence at the head of the screen: "3 people are due today. 1 is late."."""
    if not rows:
        return tr("Nobody is enrolled yet.")
    playing = [row.participant for row in rows if row.is_playing]
    nexts = [(row, cell) for row in rows if (cell := row.next_visit(plan))]
    if not nexts and not playing:
        return tr("Nobody has anything more to do.")
    due = sum(cell.state == "due" and not cell.playing for _, cell in nexts)
    late = sum(cell.state == "late" and not cell.playing for _, cell in nexts)
    said = [tr("{who} is in a session now.", who=", ".join(playing))] if playing else []
    if due:
        text = "1 person is due today." if due == 1 else "{count} people are due today."
        said.append(tr(text, count=due))
    if late:
        text = "1 visit is late." if late == 1 else "{count} visits are late."
        said.append(tr(text, count=late))
    if not said:
        said.append(tr("Nobody is due today."))
        coming = min(
            ((cell.first, row.participant) for row, cell in nexts if cell.first), default=None
        )
        if coming:
            day = day_words(coming[0], today, tr)
            said.append(tr("The next one is {who}, from {day}.", who=coming[1], day=day))
    return " ".join(said)


def cell_words(cell: VisitCell, today: date, tr: Language) -> str:
    """Return the state of a visit: "due by 5 Dec"."""
    return _of_today(cell.sentence(lambda day: _short(day, today, tr)), tr)


def _of_today(state: str, tr: Language) -> str:
    """Return the state of a visit with "due today" in place of "due by today"."""
    said = in_language(state, tr)
    return said.replace(tr("due by {day}", day=tr("today")), tr("due today"))


def _short(day: date, today: date, tr: Language) -> str:
    return tr("today") if day == today else short_day(day, tr)


def dated(error: Exception, tr: Language) -> str:
    """Return what an error says, with its days as people say them."""
    said = error_text(error)
    if not isinstance(said, Sentence):
        return tr(said)
    slots = {
        name: weekday_words(value, tr) if isinstance(value, date) else value
        for name, value in said.slots.items()
    }
    return in_language(Sentence(said.english, **slots), tr)


def about(who: str, found: Next, today: date, tr: Language) -> str:
    """Return what is to be known of a block before it begins."""
    said = [tr("The visit {visit} was missed.", visit=visit.name) for visit in found.passed]
    if found.day.first and found.day.last:
        first, last = (day_words(day, today, tr) for day in (found.day.first, found.day.last))
        visit = found.item.visit.name
        said.append(
            tr("The visit “{visit}” of {who} is {day}.", visit=visit, who=who, day=first)
            if first == last
            else tr(
                "The visit “{visit}” of {who} is from {first} to {last}.",
                visit=visit,
                who=who,
                first=first,
                last=last,
            )
        )
    if found.resume:
        said.append(tr("A session was cut off: it goes on where it was."))
    elif found.repeats:
        said.append(tr("A session was cut off: the block begins again."))
    return " ".join(said)


def deviations(noted: Sequence[Differed], tr: Language) -> str:
    """Return the deviations of a person in a line, those that are alike once; empty without one."""
    counts: Counter[str] = Counter()
    for each in noted:
        what = tr(_DEVIATIONS.get(each.what, "other"))
        said = f"{each.visit}: {what}" if each.visit else what
        counts[f"{said} ({each.reason})" if each.reason else said] += 1
    listed = ", ".join(f"{said} × {count}" if count > 1 else said for said, count in counts.items())
    return tr("Differs from the plan: {listed}.", listed=listed) if listed else ""


def key_words(who: str, visit: int, block: int, what: str, found: Next, tr: Language) -> str:
    """Return what Enter does.

    Args:
        who: the person.
        visit, block: numbers of them.
        what: name of the condition, in a blind study its code; or of the form.
        found: the block.
        tr: the language.
    """
    slots = {"visit": visit, "block": block, "what": what, "who": who}
    if found.item.block.form:
        return tr("Press Enter to fill in visit {visit}, block {block} ({what}) of {who}.", **slots)
    if found.resume:
        return tr("Press Enter to resume visit {visit}, block {block} ({what}) of {who}.", **slots)
    return tr("Press Enter to start visit {visit}, block {block} ({what}) of {who}.", **slots)


def due_in_studies(
    database: sqlite3.Connection, names: Sequence[str], who: str, today: date, tr: Language
) -> str:
    """Return what is due for a participant in these studies: a line for each in which something is,
    the newest first.
    """
    now, found = present(today), []
    for name in reversed(names):
        with suppress(StoreError, PlanError):  # the screen of the study tells it
            frozen = ledger.find(database, name)
            people = ledger.people(database, frozen, who)
            rows = grid(frozen, people, key_file(name), as_of(frozen, people, now))
            found += [card_words(frozen.plan, row, today, tr) for row in rows]
    return "\n".join(filter(None, found))


def present(today: date) -> datetime:
    """Return the time of day on the day of the app."""
    return datetime.combine(today, datetime.now().time()).astimezone()


def card_words(plan: Study, row: PersonRow, today: date, tr: Language) -> str:
    """Return what is due for a person in a line; empty if nothing more comes."""
    cell = row.next_visit(plan)
    if not cell or not row.next:
        return ""
    state = _of_today(cell.when(lambda day: _short(day, today, tr)), tr)
    return tr(
        "Study {study}: visit {visit}, block {block}, {state}. F7",
        study=plan.name,
        visit=row.next.visit,
        block=row.next.block,
        state=state,
    )

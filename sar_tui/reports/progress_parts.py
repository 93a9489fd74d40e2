"""The parts of the progress screen, as rows of text that fit a width and a height."""

import textwrap
from collections.abc import Iterator, Sequence
from itertools import product

from sar_tui.model.language import Language
from sar_tui.progress.change import BASELINE, FAMILIARISATION, baseline
from sar_tui.progress.scores import InstrumentChange
from sar_tui.records.kind import STATUS, kinds
from sar_tui.reports import dose_words, progress_words
from sar_tui.reports.charts import ABOVE, BELOW, EVENT, MARKED
from sar_tui.reports.progress import LineProgress, Progress, SessionProgress
from sar_tui.reports.progress_charts import needs_look
from sar_tui.reports.progress_glossary import GLOSSARY
from sar_tui.reports.progress_timeline import TextRow, charted, qualities, timeline
from sar_tui.reports.wellbeing import advice, dated_event
from sar_tui.store.records import Record

CURSOR = "▸"
OF_RESULTS = ("result", "correct", "quality")
"""Figures that are shown with the chart of mean results."""
LISTS = ("sessions", "days", "records")
"""Figures that have a part of their own."""
_MONTHS = 3


def figures(found: Progress, line: LineProgress | None) -> list[str]:
    """Return the names of the figures of a line, in the order in which they are read."""
    if line is None:
        return [*(["days"] if found.days else []), "records"]
    known = charted(line)
    has_quality = any(each.qualities for each in line.sessions)
    has = {
        "level": "level" in known,
        "result": "result" in known,
        "correct": "result" in known,
        "quality": "result" in known and has_quality,
        "pain": any(each.pain is not None for each in line.sessions),
        "tired": any(each.tiredness is not None for each in line.sessions),
        "look": any(map(needs_look, line.sessions)),
        "days": bool(found.days),
    }
    shown = ("verdict", "level", *OF_RESULTS, "dose", "pain", "tired", "look", *LISTS)
    return [name for name in shown if has.get(name, True)]


def picture(
    line: LineProgress,
    size: tuple[int, int],
    figure: str,
    chosen: int,
    tr: Language,
    marked: str | None = None,
    *,
    is_shaded: bool = False,
) -> list[TextRow]:
    """Return the sessions over their dates.

    Args:
        line: the sessions.
        size: columns and rows.
        figure: the chosen one. Results are charted instead of the level at goal if it is one of
            theirs.
        chosen: number of the chosen session.
        tr: the language.
        marked: id of the session to compare it with.
        is_shaded: True if colours are shown behind characters.
    """
    shown = "result" if figure in OF_RESULTS else "level"
    number = _number(line, marked)
    drawn = timeline(
        line, *size, tr, shown=shown, chosen=chosen, marked=number, is_shaded=is_shaded
    )
    return drawn[: size[1]]


def listed(
    name: str,
    found: Progress,
    line: LineProgress | None,
    size: tuple[int, int],
    tr: Language,
    *,
    chosen: int = 0,
    marked: str | None = None,
    record: int = 0,
    is_chosen: bool = False,
) -> list[TextRow]:
    """Return the sessions, the days or the records as a list under its title.

    Args:
        name: one of `LISTS`.
        found, line: of the person.
        size: columns and rows.
        tr: the language.
        chosen: number of the chosen session.
        marked: id of the session to compare it with.
        record: number of the chosen record.
        is_chosen: True if the list itself is chosen: only then a record is.
    """
    width, height = size[0], size[1] - 1
    title, part = tr(GLOSSARY[name].title), ""
    if name == "sessions" and line:
        rows = sessions_part(line, (width, height), chosen, found.today, tr, marked)
        count = len(line.sessions)
        part = _part_shown(count, height - 1, count - 1 - chosen, tr)
    elif name == "days":
        rows = days_part(found, (width, height), tr)
    elif is_chosen or line is None:
        rows = records_part(found, (width, height), record if is_chosen else None, tr)
    else:
        rows = records_summary(found, (width, height), tr)
    return [
        TextRow(f"{title}{part}", name, len(title)),
        *(
            TextRow(row.ljust(width), is_chosen=True) if row.startswith(CURSOR) else TextRow(row)
            for row in rows
        ),
    ]


def _part_shown(count: int, rows: int, chosen: int, tr: Language) -> str:
    """Return which rows of a list are shown; empty if all are."""
    shown = window(count, max(1, rows), chosen)
    if len(shown) >= count:
        return ""
    first, last = str(shown[0] + 1), str(shown[-1] + 1)
    return f"  {tr('{first} to {last} of {count}', first=first, last=last, count=str(count))}"


def of_person(
    name: str, found: Progress, line: LineProgress | None, chosen: int, tr: Language
) -> list[str]:
    """Return what a figure says of this person, in sentences; none for a list."""
    said: list[str] = []
    if line is None:
        return said
    match name:
        case "verdict" | "noise" | "practice":
            said = progress_words.sentences(line, tr)
        case "level" | "band":
            session = line.sessions[chosen]
            if known := progress_words.at_goal(line, session, tr):
                said = [f"{progress_words.day(session.began)}: {known}."]
        case "result" | "correct" | "quality":
            said = [*_ends(line, tr), progress_words.spread(line, tr)]
        case "dose":
            said = [dose_words.recent_text(found.recent, tr)] if found.days else []
        case "pain" | "tired":
            ranged = progress_words.felt_range(line, tr)
            said = [*([f"{ranged}."] if ranged else []), *advice(found.tell, tr)]
        case "look":
            said = [_why_look(found, each, tr) for each in line.sessions if needs_look(each)]
    return [text for text in said if text]


def _why_look(found: Progress, session: SessionProgress, tr: Language) -> str:
    """Return why a session needs a look."""
    said = progress_words.felt(session, tr) if session.felt.is_reason_to_stop else []
    events = [dated_event(event, tr) for event in found.events if event.id in session.events]
    return (
        f"{progress_words.day(session.began)}: {'; '.join([', '.join(said), *events]).strip('; ')}"
    )


_SIDES = {"easier": ABOVE, "harder": BELOW, "": "·"}
"""Signs of the charts for sessions whose level at goal is not known."""
_COLUMNS = (
    ("date", "at goal", "mean ± SD", "correct", "goals", "pain", "tired"),
    ("date", "at goal", "mean ± SD", "goals", "pain"),
)
_FEW_COLUMNS = {"level": ("date", "level", "minutes", "pain")}
_OTHER_FEW_COLUMNS = ("date", "mean", "minutes", "pain")
"""Columns of the table of sessions, by the room that there is; the last ones by the measure."""


def sessions_part(
    line: LineProgress,
    size: tuple[int, int],
    chosen: int,
    today: str,
    tr: Language,
    marked: str | None = None,
) -> list[str]:
    """Return the sessions, newest first, as a table with a cursor, with as many columns as there is
    room for; ``marked`` is the id of the one to compare with.
    """
    width, height = size
    last = len(line.sessions) - 1
    shown = [last - number for number in window(last + 1, max(1, height - 1), last - chosen)]
    few = _FEW_COLUMNS.get(line.measure, _OTHER_FEW_COLUMNS)
    has_levels = line.measure != "result"
    wide = [[name for name in each if has_levels or name != "at goal"] for each in _COLUMNS]
    for columns, gap in product((*wide, few), ("  ", " ")):
        table = _table(line, columns, gap, shown, chosen, today, tr, marked)
        if max(map(len, table)) <= width:
            break
    return [row[:width].rstrip() for row in table]


def _table(
    line: LineProgress,
    columns: Sequence[str],
    gap: str,
    shown: Sequence[int],
    chosen: int,
    today: str,
    tr: Language,
    marked: str | None,
) -> list[str]:
    at_goal = tr("at goal")
    if not line.places:
        at_goal = f"{at_goal} ({tr(line.axis.unit or line.axis.name)})"
    rows = [[at_goal if head == "at goal" else tr(head) for head in columns]]
    rows += [_cells(line, line.sessions[number], columns, today, tr) for number in shown]
    widths = [max(len(row[column]) for row in rows) for column in range(len(columns))]
    lines = []
    for number, row in zip((None, *shown), rows, strict=True):
        sign = CURSOR if number == chosen else " "
        if number is not None and line.sessions[number].session == marked:
            sign = MARKED
        cells = [f"{cell:>{size}}" for cell, size in zip(row, widths, strict=True)]
        lines.append(f"{sign} {gap.join(cells)}")
    return lines


def days_part(found: Progress, size: tuple[int, int], tr: Language) -> list[str]:
    """Return a mark for each day of the last months, and the last weeks in a sentence."""
    width, height = size
    if not found.days:
        return [tr("No live session yet.")]
    gap = "   "
    lines = [
        row
        for line in dose_words.calendar_lines(found, _MONTHS, tr)
        for row in ([line] if len(line) <= width else joined(line.split(gap), width, gap))
    ]
    lines += [
        "",
        *wrapped([dose_words.recent_text(found.recent, tr, found.today)], width),
    ]
    return lines[:height]


def session_text(
    line: LineProgress,
    session: SessionProgress,
    today: str,
    tr: Language,
    width: int,
    figure: str = "",
) -> str:
    """Return a session in a row: its date, level at goal, dose, and what was said of pain and
    tiredness; and how it ended, unless it was completed.

    If there is no room for all, the dose goes first where pain or tiredness is the chosen figure;
    else what stands below the chart.
    """
    if line.places and session.at_goal:
        reached = tr("level {level}", level=progress_words.level_band(line, session, tr))
    else:
        reached = progress_words.at_goal(line, session, tr)
    if not reached and session.mean is not None and line.measure == "result":
        reached = progress_words.result(line, session.mean, tr)
    is_complete = session.status == "completed"
    begin = [
        f"{progress_words.short_day(session.began, today, tr)} {session.began[11:16]}",
        reached or tr(progress_words.SIDES[session.side]),
        "" if is_complete else progress_words.status(session.status, tr),
    ]
    minutes = tr("{minutes} min", minutes=tr.figures(f"{session.time_on_task_s / 60:.1f}"))
    dose = [
        tr("{done}/{planned} attempts", done=session.attempts, planned=session.planned),
        tr("{repetitions} repetitions", repetitions=session.trials),
        minutes,
    ]
    felt = progress_words.felt(session, tr)
    said = [*filter(None, begin), *dose, *felt]
    least_first = [*reversed(dose), *reversed(felt)]
    if figure not in ("pain", "tired"):
        least_first = [minutes, *reversed(felt), *reversed(dose[:-1])]
    for part in least_first:
        if len(" · ".join(said)) > width:
            said.remove(part)
    return " · ".join(said)


def _ends(line: LineProgress, tr: Language) -> list[str]:
    """Return the first and the last known value of each measure of how the sessions were done, and
    its MDC95.
    """
    said, is_noise_known = [], False
    for name, values, form in qualities(line, tr):
        known = [value for value in values if value is not None]
        if not known:
            continue
        first, last = (tr.figures(form.format(value)) for value in (known[0], known[-1]))
        if noise := baseline(known):
            is_noise_known = True
            size = tr("MDC95 {size}", size=tr.figures(form.format(noise.mdc95)))
            said.append(f"{name} {first} → {last} ({size})")
        else:
            said.append(f"{name} {first} → {last}" if len(line.sessions) > 1 else f"{name} {last}")
    if not said:
        return []
    if len(line.sessions) == 1:
        return [tr("In the only session: {values}.", values=", ".join(said))]
    told = tr("First → last session: {values}.", values=", ".join(said))
    if is_noise_known:
        return [told]
    needed = str(FAMILIARISATION + BASELINE)
    unknown = tr(
        "How much of these changes is noise is not yet known: it needs {number} sessions.",
        number=needed,
    )
    return [f"{told} {unknown}"]


def _number(line: LineProgress, session: str | None) -> int | None:
    """Return the number of a session on a line, given its id; None if it is not there."""
    return next(
        (number for number, each in enumerate(line.sessions) if each.session == session), None
    )


def _cells(
    line: LineProgress, session: SessionProgress, columns: Sequence[str], today: str, tr: Language
) -> list[str]:
    unknown = tr(progress_words.SIDES[session.side])
    level = session.at_goal.level if session.at_goal else None
    cells = {
        "date": progress_words.short_day(session.began, today, tr),
        "levels": f"{session.first_level}→{session.last_level}",
        "mean ± SD": tr.figures(progress_words.mean(line, session)),
        "correct": f"{session.right / session.trials:.0%}" if session.trials else "",
        "goals": "" if session.reached is None else f"{session.reached}/{session.attempts}",
        "at goal": progress_words.level_band(line, session, tr) or unknown,
        "level": _SIDES[session.side] if level is None else tr.figures(f"{level:.1f}"),
        "mean": "" if session.mean is None else progress_words.result(line, session.mean, tr),
        "minutes": tr.figures(f"{session.time_on_task_s / 60:.1f}"),
        "pain": f"{'·' if session.pain is None else session.pain}{EVENT if needs_look(session) else ' '}",
        "tired": "·" if session.tiredness is None else str(session.tiredness),
    }
    return [cells[name] for name in columns]


def window(count: int, rows: int, chosen: int) -> range:
    """Return the numbers of the rows to show, with the chosen one among them."""
    first = max(0, min(chosen - rows // 2, count - rows))
    return range(first, min(count, first + rows))


def wrapped(sentences: Sequence[str], width: int, indent: str = "") -> list[str]:
    """Return sentences on lines, each sentence beginning a line."""
    return [
        line
        for sentence in sentences
        for line in textwrap.wrap(
            sentence, max(20, width), initial_indent=indent, subsequent_indent=indent
        )
    ]


def joined(parts: Sequence[str], width: int, between: str = " · ") -> list[str]:
    """Return parts on lines, each part on one line."""
    lines: list[str] = []
    for part in parts:
        if lines and len(longer := f"{lines[-1]}{between}{part}") <= width:
            lines[-1] = longer
        else:
            lines.append(part)
    return lines


_FEWEST_LISTED = 2
_MOST_SCORES = 6
"""Scores of an instrument on a line."""
_FOR_KINDS = 50
"""Columns from which the kinds of records have a column of their own."""


def records_summary(found: Progress, size: tuple[int, int], tr: Language) -> list[str]:
    """Return the scores of each instrument with their change on a line, and below them the other
    records, newest first.
    """
    width, height = size
    if not found.records:
        return records_part(found, size, None, tr)
    names = [each.instrument.name for each in found.instruments]
    scores = [_scores(each, tr) for each in found.instruments]
    columns = [names, scores]
    if width >= _FOR_KINDS:
        columns.append([_when(each, found.today, tr) for each in found.instruments])
    lines = _aligned(list(zip(*columns, strict=True)))
    others = [each for each in found.records if each.kind not in names]
    _, rows = _record_rows(found, others, width, tr)
    lines += [*([""] if lines and others else []), *_aligned(rows[::-1])]
    return [_cut(line, width) if len(line) > width else line for line in lines[:height]]


def _scores(found: InstrumentChange, tr: Language) -> str:
    """Return scores and their change, "34 → 39 → 44  +10"; of many, the first and the last ones."""
    scores = [tr.figures(f"{each.score:g}") for each in found.scores]
    if len(scores) > _MOST_SCORES:
        scores = [scores[0], "…", *scores[2 - _MOST_SCORES :]]
    shown = " → ".join(scores)
    return shown if found.change is None else f"{shown}  {tr.figures(f'{found.change:+g}')}"


def _when(found: InstrumentChange, today: str, tr: Language) -> str:
    """Return the dates of the first and the last score."""
    first, last = found.scores[0].date, found.scores[-1].date
    low, high = (progress_words.short_day(day, today, tr) for day in (first, last))
    return low if first == last else tr("{low} to {high}", low=low, high=high)


def _aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return rows of cells as lines, with the cells of a column below each other."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(f"{cell:<{size}}" for cell, size in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]


def records_part(
    found: Progress, size: tuple[int, int], chosen: int | None, tr: Language
) -> list[str]:
    """Return the records, newest first, and the chosen one in full."""
    width, height = size
    if not found.records:
        none = tr("Nothing is recorded yet. A records an event, or a score of another test.")
        return wrapped([none], width)[:height]
    heads, rows = _record_rows(found, found.records, width, tr)
    rows.reverse()
    if chosen is None:
        return _listed(heads, rows, [], size, None)
    in_full = wrapped([in_words(found, found.records[chosen], tr)], width)
    return _listed(heads, rows, in_full, size, len(rows) - 1 - chosen)


def _record_rows(
    found: Progress, listed: Sequence[Record], width: int, tr: Language
) -> tuple[Sequence[str], list[Sequence[str]]]:
    """Return the heads and the rows of a list of records; in a narrow one the kind stands before
    the contents.
    """
    dates = [progress_words.short_day(each.at, found.today, tr) for each in listed]
    wide = max(map(len, dates), default=0)
    dates = [f"{each:>{wide}}" for each in dates]
    if width >= _FOR_KINDS:
        heads = [tr("date"), tr("kind"), tr("record")]
        texts = [[each.kind, _cut(contents(each, tr), width // 2)] for each in listed]
    else:
        heads, cut = [tr("date"), tr("record")], width - wide - 5
        texts = [[_cut(f"{each.kind}: {contents(each, tr)}", cut)] for each in listed]
    return heads, [[at, *row] for at, row in zip(dates, texts, strict=True)]


def contents(record: Record, tr: Language) -> str:
    """Return the values of a record in its order, without their names."""
    return ", ".join(value for _, value in _named_values(record, tr))


def _named_values(record: Record, tr: Language) -> Iterator[tuple[str, str]]:
    """Yield the titles of a record's fields with its values; of a form, its scores, or that it was
    left open. Typed texts stay as they are.
    """
    kind = kinds().get(record.kind)
    declared = {field.name: field for field in kind.fields} if kind else {}
    content = record.content
    if kind and kind.form:
        told = [score.name for score in kind.scores if score.name in content] or [STATUS]
        content = {name: content[name] for name in told if name in content}
    for name, value in content.items():
        field = declared.get(name)
        title = tr(field.title) if field else name
        if isinstance(value, str):
            yield title, tr(value) if field and field.type == "choice" else value
        else:
            yield title, tr.figures(f"{value:g}")


def in_words(found: Progress, record: Record, tr: Language) -> str:
    """Return a record in sentences: an event with its outcome, a score beside what is published."""
    if record in found.events:
        return dated_event(record, tr)
    for each in found.instruments:
        if each.instrument.name == record.kind:
            return progress_words.instrument_change(each, tr)
    named = (f"{title}: {value}" for title, value in _named_values(record, tr))
    return f"{record.kind}, {record.at}. {'; '.join(named)}."


def _listed(
    heads: Sequence[str],
    rows: Sequence[Sequence[str]],
    below: Sequence[str],
    size: tuple[int, int],
    chosen: int | None,
) -> list[str]:
    """Return a table with a cursor on the chosen row, above other lines, as far as there is
    room.
    """
    width, height = size
    room = height - 1 - (len(below) + 1 if below else 0)
    shown = window(len(rows), max(_FEWEST_LISTED, room), chosen or 0)
    table = [heads, *(rows[number] for number in shown)]
    lines = []
    for number, cells in zip((None, *shown), _aligned(table), strict=True):
        sign = CURSOR if number is not None and number == chosen else " "
        lines.append(f"{sign} {cells}"[:width].rstrip())
    return [*lines, *(["", *below] if below else [])][:height]


def _cut(text: str, width: int) -> str:
    plain = " ".join(text.split())
    return plain if len(plain) <= width else f"{plain[: width - 1]}…"

"""The parts of the progress screen, as rows of text that fit a width and a height."""

import re
import textwrap
from collections.abc import Iterator, Sequence
from itertools import product

from sar_tui.model.language import Language
from sar_tui.progress.change import BASELINE, FAMILIARISATION, baseline
from sar_tui.records.kind import kinds
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
_FOR_TWO_CHARTS = 30
"""Rows from which both charts are shown, one below the other."""
_FEWEST_OF_A_TIMELINE = 16
"""Rows below which sentences are left out beneath a timeline."""
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
) -> list[TextRow]:
    """Return the sessions over their dates, and with enough room what can be said of the line.

    Args:
        line: the sessions.
        size: columns and rows.
        figure: the chosen one. Results are charted instead of the level at goal if it is one of
            theirs; with enough room, both are.
        chosen: number of the chosen session.
        tr: the language.
        marked: id of the session to compare it with.
    """
    width, height = size
    said = wrapped(progress_words.sentences(line, tr), min(width, 72))
    if height - len(said) - 1 < _FEWEST_OF_A_TIMELINE:
        said = []
    room = height - len(said) - 1 if said else height
    shown: Sequence[str] = ("result",) if figure in OF_RESULTS else ()
    if room >= _FOR_TWO_CHARTS:
        shown = ("level", "result")
    drawn = timeline(
        line, width, room, tr, shown=shown, chosen=chosen, marked=_number(line, marked)
    )
    below = [TextRow(""), *map(TextRow, said)] if said else []
    return [*drawn, *below][:height]


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
        rows = sessions_part(line, (width, height), chosen, tr, marked)
        part = _part_shown(len(line.sessions), height - 1, chosen, tr)
    elif name == "days":
        rows = days_part(found, (width, height), tr)
    else:
        rows = records_part(found, (width, height), record if is_chosen else None, tr)
        if not is_chosen:
            part = _part_shown(len(found.records), height - 1, len(found.records), tr)
    return [TextRow(f"{title}{part}", name, len(title)), *map(TextRow, rows)]


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
    ("date", "levels", "mean ± SD", "correct", "goals", "at goal", "pain", "tired"),
    ("date", "mean ± SD", "goals", "at goal", "pain"),
)
_FEW_COLUMNS = {"level": ("date", "level", "minutes", "pain")}
_OTHER_FEW_COLUMNS = ("date", "mean", "minutes", "pain")
"""Columns of the table of sessions, by the room that there is; the last ones by the measure."""


def sessions_part(
    line: LineProgress, size: tuple[int, int], chosen: int, tr: Language, marked: str | None = None
) -> list[str]:
    """Return the sessions as a table with a cursor, with as many columns as there is room for;
    ``marked`` is the id of the one to compare with.
    """
    width, height = size
    shown = window(len(line.sessions), max(1, height - 1), chosen)
    few = _FEW_COLUMNS.get(line.measure, _OTHER_FEW_COLUMNS)
    has_levels = line.measure != "result"
    wide = [[name for name in each if has_levels or name != "at goal"] for each in _COLUMNS]
    for columns, gap in product((*wide, few), ("  ", " ")):
        table = _table(line, columns, gap, shown, chosen, tr, marked)
        if max(map(len, table)) <= width:
            break
    return [row[:width].rstrip() for row in table]


def _table(
    line: LineProgress,
    columns: Sequence[str],
    gap: str,
    shown: range,
    chosen: int,
    tr: Language,
    marked: str | None,
) -> list[str]:
    at_goal = f"{tr('at goal')} ({tr(line.axis.unit or line.axis.name)})"
    rows = [[at_goal if head == "at goal" else tr(head) for head in columns]]
    rows += [_cells(line, line.sessions[number], columns, tr) for number in shown]
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
    """Return a mark for each day of the last months, and the last days in figures."""
    width, height = size
    if not found.days:
        return [tr("No live session yet.")]
    lines = [
        *dose_words.calendar_lines(found, _MONTHS, tr),
        "",
        *wrapped([dose_words.recent_text(found.recent, tr)], width),
        "",
    ]
    room = max(1, height - len(lines) - 1)
    return [*lines, *dose_words.days_table(found.days[-room:], tr)][:height]


def session_text(line: LineProgress, session: SessionProgress, tr: Language) -> list[str]:
    """Return a session on two lines: its date, end and dose; what was said of pain and
    tiredness.
    """
    parts = [
        f"{progress_words.day(session.began)} {session.began[11:16]}",
        progress_words.status(session.status, tr),
        tr("{done}/{planned} attempts", done=session.attempts, planned=session.planned),
        tr("{repetitions} repetitions", repetitions=session.trials),
        tr("{minutes} min", minutes=f"{session.time_on_task_s / 60:.1f}"),
    ]
    return [" · ".join(parts), " · ".join(progress_words.felt(session, tr))]


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
    line: LineProgress, session: SessionProgress, columns: Sequence[str], tr: Language
) -> list[str]:
    unknown = tr(progress_words.SIDES[session.side])
    level = session.at_goal.level if session.at_goal else None
    cells = {
        "date": progress_words.day(session.began),
        "levels": f"{session.first_level}→{session.last_level}",
        "mean ± SD": tr.figures(progress_words.mean(line, session)),
        "correct": f"{session.right / session.trials:.0%}" if session.trials else "",
        "goals": "" if session.reached is None else f"{session.reached}/{session.attempts}",
        "at goal": progress_words.band(line, session, tr) or unknown,
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


def balanced(text: str, width: int) -> str:
    """Return a text on as few lines as fit a width, all of about the same length, with no line
    between a number and its unit.
    """
    kept = re.sub(r"(?<=\d) (?=[^\W\d])", "\N{NO-BREAK SPACE}", text)
    lines = textwrap.wrap(kept, width)
    for narrower in range(len(kept) // max(1, len(lines)), width):
        if len(tried := textwrap.wrap(kept, narrower)) <= len(lines):
            lines = tried
            break
    return "\n".join(lines).replace("\N{NO-BREAK SPACE}", " ")


def wrapped(sentences: Sequence[str], width: int, indent: str = "") -> list[str]:
    """Return sentences on lines, each sentence beginning a line."""
    return [
        line
        for sentence in sentences
        for line in textwrap.wrap(
            sentence, max(20, width), initial_indent=indent, subsequent_indent=indent
        )
    ]


_FEWEST_LISTED = 2
_FOR_KINDS = 50
"""Columns from which the kinds of records have a column of their own."""


def records_part(
    found: Progress, size: tuple[int, int], chosen: int | None, tr: Language
) -> list[str]:
    """Return the records by date, and the chosen one in full."""
    width, height = size
    if not found.records:
        none = tr("Nothing is recorded yet. A records an event, or a score of another test.")
        return wrapped([none], width)[:height]
    heads, rows = _record_rows(found.records, width, tr)
    if chosen is None:
        return _listed(heads, rows, [], size, None)
    in_full = wrapped([in_words(found, found.records[chosen], tr)], width)
    return _listed(heads, rows, in_full, size, chosen)


def _record_rows(
    found: Sequence[Record], width: int, tr: Language
) -> tuple[Sequence[str], list[Sequence[str]]]:
    """Return the heads and the rows of a list of records; in a narrow one the kind stands before
    the contents.
    """
    if width >= _FOR_KINDS:
        heads = (tr("date"), tr("kind"), tr("record"))
        return heads, [(each.at, each.kind, _cut(contents(each, tr), width // 2)) for each in found]
    cut = width - len("2026-03-02") - 5
    texts = (f"{each.kind}: {contents(each, tr)}" for each in found)
    rows = [(each.day, _cut(text, cut)) for each, text in zip(found, texts, strict=True)]
    return (tr("date"), tr("record")), list(rows)


def contents(record: Record, tr: Language) -> str:
    """Return the values of a record in its order, without their names."""
    return ", ".join(value for _, value in _named_values(record, tr))


def _named_values(record: Record, tr: Language) -> Iterator[tuple[str, str]]:
    """Yield the titles of a record's fields with its values. Typed texts stay as they are."""
    kind = kinds().get(record.kind)
    declared = {field.name: field for field in kind.fields} if kind else {}
    for name, value in record.content.items():
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
    """Return a table with a cursor on the chosen row, above other lines, as far as there is room.
    Without a chosen row, the last ones are shown.
    """
    width, height = size
    room = height - 1 - (len(below) + 1 if below else 0)
    shown = window(len(rows), max(_FEWEST_LISTED, room), len(rows) if chosen is None else chosen)
    table = [heads, *(rows[number] for number in shown)]
    widths = [max(len(row[column]) for row in table) for column in range(len(heads))]
    lines = []
    for number, row in zip((None, *shown), table, strict=True):
        cells = "  ".join(f"{cell:<{size}}" for cell, size in zip(row, widths, strict=True))
        sign = CURSOR if number is not None and number == chosen else " "
        lines.append(f"{sign} {cells}"[:width].rstrip())
    return [*lines, *(["", *below] if below else [])][:height]


def _cut(text: str, width: int) -> str:
    plain = " ".join(text.split())
    return plain if len(plain) <= width else f"{plain[: width - 1]}…"

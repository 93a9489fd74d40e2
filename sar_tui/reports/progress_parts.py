"""The parts of the progress screen, as lines of text that fit a width and a height."""

import textwrap
from collections.abc import Sequence

from sar_tui.model.language import Language
from sar_tui.progress.change import BASELINE, FAMILIARISATION, baseline
from sar_tui.reports import dose_words, progress_words
from sar_tui.reports.charts import MARKED
from sar_tui.reports.progress import LineProgress, Progress, SessionProgress
from sar_tui.reports.progress_charts import (
    has_levels,
    has_results,
    level_figure,
    qualities,
    result_figure,
)
from sar_tui.reports.wellbeing import advice, dated_event
from sar_tui.store.records import Record

CURSOR = "▸"
_FEWEST_OF_A_CHART = 10
"""Rows below which the text has to be shortened instead of the chart."""
_MOST_OF_A_CHART = 24
_FOR_EACH_OF_TWO = 18
"""Rows for each of two charts, one below the other."""
_TALL = 26
"""Rows from which each sentence has a line of its own."""
_MONTHS = 3


def level_part(
    line: LineProgress,
    size: tuple[int, int],
    chosen: int,
    tr: Language,
    marked: str | None = None,
    advice: Sequence[str] = (),
) -> list[str]:
    """Return the level at goal as a chart where it is known, and what can be said of the line.

    The results are charted below where there is room for both, or where no level is known.

    Args:
        line: the sessions.
        size: columns and rows.
        chosen: number of the chosen session.
        tr: the language.
        marked: id of the session to compare it with.
        advice: sentences that come first, such as on pain.
    """
    width, height = size
    said = [*advice, *progress_words.sentences(line, tr)]
    text = wrapped(said if height >= _TALL else [" ".join(said)], width)
    room = height - len(text) - 1
    charts = [
        draw
        for has, draw in ((has_levels, level_figure), (has_results, result_figure))
        if has(line)
    ]
    if not charts:
        return text[:height]
    lines: list[str] = []
    shown = charts[: max(1, room // _FOR_EACH_OF_TWO)]
    for draw in shown:
        rows = _chart_height(room // len(shown) - (len(shown) > 1))
        lines += [*draw(line, width, rows, tr, chosen, _number(line, marked)), ""]
    return [*lines, *text][:height]


def results_part(
    line: LineProgress, size: tuple[int, int], chosen: int, tr: Language, marked: str | None = None
) -> list[str]:
    """Return the mean results as a chart, and accuracy, smoothness and the SD within and between
    sessions.
    """
    width, height = size
    below = wrapped([*_ends(line, tr), progress_words.spread(line, tr)], width)
    if not has_results(line):
        return below[:height]
    rows = _chart_height(height - len(below) - 1)
    return [*result_figure(line, width, rows, tr, chosen, _number(line, marked)), "", *below][
        :height
    ]


def sessions_part(
    line: LineProgress, size: tuple[int, int], chosen: int, tr: Language, marked: str | None = None
) -> list[str]:
    """Return the sessions as a table with a cursor; ``marked`` is the id of the one to compare
    with.
    """
    width, height = size
    at_goal = f"at goal ({line.axis.unit or line.axis.name})"
    heads = ("date", "levels", "mean ± SD", "correct", "goals", at_goal, "pain", "tired")
    shown = window(len(line.sessions), max(1, height - 1), chosen)
    rows = [[tr(head) for head in heads]]
    rows += [_cells(line, line.sessions[number], tr) for number in shown]
    widths = [max(len(row[column]) for row in rows) for column in range(len(heads))]
    gap = " " * (2 if sum(widths) + 2 * len(widths) <= width else 1)
    lines = []
    for number, row in zip((None, *shown), rows, strict=True):
        sign = CURSOR if number == chosen else " "
        if number is not None and line.sessions[number].session == marked:
            sign = MARKED
        cells = [f"{cell:>{size}}" for cell, size in zip(row, widths, strict=True)]
        lines.append(f"{sign} {gap.join(cells)}"[:width].rstrip())
    return lines


def dose_part(found: Progress, size: tuple[int, int], tr: Language) -> list[str]:
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
        tr(session.status),
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


def _cells(line: LineProgress, session: SessionProgress, tr: Language) -> list[str]:
    return [
        progress_words.day(session.began),
        f"{session.first_level}→{session.last_level}",
        tr.figures(progress_words.mean(line, session)),
        f"{session.right / session.trials:.0%}" if session.trials else "",
        "" if session.reached is None else f"{session.reached}/{session.attempts}",
        progress_words.band(line, session, tr) or tr(progress_words.SIDES[session.side]),
        "·" if session.pain is None else str(session.pain),
        "·" if session.tiredness is None else str(session.tiredness),
    ]


def window(count: int, rows: int, chosen: int) -> range:
    """Return the numbers of the rows to show, with the chosen one among them."""
    first = max(0, min(chosen - rows // 2, count - rows))
    return range(first, min(count, first + rows))


def _chart_height(room: int) -> int:
    return max(_FEWEST_OF_A_CHART, min(_MOST_OF_A_CHART, room))


def wrapped(sentences: Sequence[str], width: int, indent: str = "") -> list[str]:
    """Return sentences on lines, each sentence beginning a line."""
    return [
        line
        for sentence in sentences
        for line in textwrap.wrap(
            sentence, max(20, width), initial_indent=indent, subsequent_indent=indent
        )
    ]


_FEWEST_LISTED = 3


def records_part(found: Progress, size: tuple[int, int], chosen: int, tr: Language) -> list[str]:
    """Return what the therapist should be told of pain, the records by date, and the chosen one in
    full.
    """
    width, height = size
    told = wrapped([f"! {text}" for text in advice(found.tell, tr)], width)
    told += [""] if told else []
    if not found.records:
        none = tr("Nothing is recorded yet. A records an event, or a score of another test.")
        return [*told, *wrapped([none], width)][:height]
    heads = (tr("date"), tr("kind"), tr("record"))
    rows = [(each.at, each.kind, _cut(contents(each, tr), width // 2)) for each in found.records]
    in_full = wrapped([in_words(found, found.records[chosen], tr)], width)
    return _listed(told, heads, rows, in_full, size, chosen)


def contents(record: Record, tr: Language) -> str:
    """Return the values of a record in its order, without their names."""
    return ", ".join(
        tr(value) if isinstance(value, str) else f"{value:g}" for value in record.content.values()
    )


def in_words(found: Progress, record: Record, tr: Language) -> str:
    """Return a record in sentences: an event with its outcome, a score beside what is published."""
    if record in found.events:
        return dated_event(record, tr)
    for each in found.instruments:
        if each.instrument.name == record.kind:
            return progress_words.instrument_change(each, tr)
    named = (f"{name}: {value}" for name, value in record.content.items())
    return f"{record.kind}, {record.at}. {'; '.join(named)}."


def _listed(
    above: Sequence[str],
    heads: Sequence[str],
    rows: Sequence[Sequence[str]],
    below: Sequence[str],
    size: tuple[int, int],
    chosen: int,
) -> list[str]:
    """Return a table with a cursor on the chosen row, between other lines, as far as there is
    room.
    """
    width, height = size
    shown = window(len(rows), max(_FEWEST_LISTED, height - len(above) - len(below) - 2), chosen)
    table = [heads, *(rows[number] for number in shown)]
    widths = [max(len(row[column]) for row in table) for column in range(len(heads))]
    lines = list(above)
    for number, row in zip((None, *shown), table, strict=True):
        cells = "  ".join(f"{cell:<{size}}" for cell, size in zip(row, widths, strict=True))
        lines.append(f"{CURSOR if number == chosen else ' '} {cells}"[:width].rstrip())
    return [*lines, "", *below][:height]


def _cut(text: str, width: int) -> str:
    plain = " ".join(text.split())
    return plain if len(plain) <= width else f"{plain[: width - 1]}…"

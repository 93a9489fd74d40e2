"""Progress as a page to print: one self-contained HTML file with drawn charts and their text
alternatives.
"""

from collections.abc import Callable, Iterator, Sequence
from html import escape

from sar_tui.loop.task import Task
from sar_tui.model.language import Language
from sar_tui.reports import dose_words, progress_charts, progress_words
from sar_tui.reports.charts import Spec
from sar_tui.reports.progress import LineProgress, Progress
from sar_tui.reports.progress_charts import needs_look, sessions_of_a_mark, span_of
from sar_tui.reports.progress_glossary import GLOSSARY, explained
from sar_tui.reports.progress_headline import headline
from sar_tui.reports.sections import document, figure, table
from sar_tui.reports.wellbeing import dated_event
from sar_tui.store.records import Record

_LISTED = 60
"""Sessions in the table of a line; the charts have all."""
_MONTHS = 12
"""Months of the calendar."""


def page(found: Progress, find_task: Callable[[str], type[Task] | None], code: str) -> str:
    """Return the page in a language.

    Raises:
        ChartsMissing: the extra ``report`` is not installed.
    """
    own = progress_words.words(code, None)
    title = f"{found.participant} · {own('Progress')}"
    body = [f"<h1>{escape(title)}</h1>"]
    warnings = [
        f"<p><strong>{escape(text)}</strong></p>" for text in progress_words.warnings(found, own)
    ]
    if not found.lines:
        body += [f"<p>{escape(own('There are no finished attempts yet.'))}</p>", *warnings]
    for line in reversed(found.lines):
        tr = progress_words.words(code, find_task(line.task))
        body.append(f"<h2>{escape(progress_words.heading(line, tr))}</h2>")
        body.append(f"<p><strong>{escape(headline(found, line, tr).text)}</strong></p>")
        body += [*warnings, *_line(line, found.events, tr)]
        warnings = []
    if found.instruments:
        body.append(f"<h2>{escape(own('Other instruments'))}</h2>")
        body += [
            f"<p>{escape(progress_words.instrument_change(each, own))}</p>"
            for each in found.instruments
        ]
    body += _dose(found, own)
    body += _glossary(own) if found.lines else []
    foot = own(
        "A training measure of this program; no diagnosis, and no published important difference "
        "(MCID) applies."
    )
    return document(title, body, language=code, foot=foot)


def _line(line: LineProgress, events: Sequence[Record], tr: Language) -> Iterator[str]:
    if spec := progress_charts.level_picture(line, tr):
        yield figure(
            spec,
            tr(
                "Level at goal of each session with its 95 % range. Grey: no more than noise and "
                "practice."
            ),
            _range(line, tr),
        )
    minutes = f"{sum(each.time_on_task_s for each in line.sessions) / 60:.0f}"
    yield figure(
        progress_charts.minutes_picture(line, tr),
        tr("Minutes on task in each session."),
        tr("{minutes} min", minutes=minutes),
    )
    if spec := progress_charts.felt_picture(line, tr):
        yield _felt(spec, line, events, tr)
    yield f"<p>{escape(' '.join(progress_words.sentences(line, tr)))}</p>"
    if (most := sessions_of_a_mark(len(line.sessions))) > 1:
        rule = tr(
            "In the charts a mark stands for up to {most} sessions, one after the other: for their "
            "mean; of pain and tiredness, for the worst.",
            most=str(most),
        )
        yield f"<p>{escape(rule)}</p>"
    if spec := progress_charts.result_picture(line, tr):
        caption = tr("Mean result of each session, with the SD between its attempts.")
        yield figure(
            spec, caption if line.goal is None else f"{caption} {tr('Dashed: the goal.')}", ""
        )
    for name, chart in progress_charts.quality_pictures(line, tr).items():
        yield figure(
            chart,
            tr("Mean of each session: {name}.", name=progress_words.quality(line, name, tr)),
            "",
        )
    yield _table(line, tr)


def _felt(spec: Spec, line: LineProgress, events: Sequence[Record], tr: Language) -> str:
    caption = tr("The worst pain (dots) and tiredness (squares, dashed) of each session, 0 to 10.")
    began_in = {event for each in line.sessions for event in each.events}
    told = [dated_event(event, tr) for event in events if event.id in began_in]
    more = [text for text in (progress_words.felt_range(line, tr), *told) if text]
    if any(map(needs_look, line.sessions)):
        caption = f"{caption} {tr('!: pain above the limits, or an adverse event.')}"
    return figure(spec, caption, " ".join(more))


def _range(line: LineProgress, tr: Language) -> str:
    """Return the first and the last known level at goal, as the text alternative of their chart."""
    known = [each for each in line.sessions if each.at_goal]
    told = [
        f"{progress_words.day(each.began)}: {progress_words.at_goal(line, each, tr)}"
        for each in known
    ]
    return ". ".join(dict.fromkeys((told[0], told[-1])))


def _table(line: LineProgress, tr: Language) -> str:
    unit = tr(line.axis.unit or line.axis.name)
    columns = ("date", "levels", "mean", "SD", "correct", "reached", "level at goal")
    heads = [*(tr(name) for name in columns), f"{unit}, 95 %"]
    rows = []
    for each in line.sessions[-_LISTED:]:
        cells = (
            progress_words.day(each.began),
            f"{each.first_level} → {each.last_level}",
            "" if each.mean is None else progress_words.result(line, each.mean, tr),
            "" if each.sd is None else progress_words.result(line, each.sd, tr),
            f"{each.right / each.trials:.0%}" if each.trials else "",
            "" if each.reached is None else f"{each.reached}/{each.attempts}",
            f"{each.at_goal.level:.1f}" if each.at_goal and each.at_goal.level else "–",
            progress_words.band(line, each, tr) or "–",
        )
        rows.append([tr.figures(cell) for cell in cells])
    return table(heads, rows)


def _dose(found: Progress, tr: Language) -> Iterator[str]:
    days = found.days
    if not days:
        return
    yield f"<h2>{escape(tr('Dose'))}</h2>"
    yield f"<p>{escape(dose_words.recent_text(found.recent, tr))}</p>"
    if spec := progress_charts.attempts_picture(days, tr):
        done = tr(
            "{done} of {planned} attempts.",
            done=str(sum(d.done for d in days)),
            planned=str(sum(d.planned for d in days)),
        )
        caption = {
            "day": tr("Attempts of each day. Line: planned."),
            "week": tr("Attempts of each week. Line: planned."),
            "month": tr("Attempts of each month. Line: planned."),
        }[span_of(days)]
        yield figure(spec, caption, done)
    if spec := progress_charts.dose_picture(days, tr):
        total = tr(
            "{repetitions} repetitions on {days}.",
            repetitions=str(sum(day.repetitions for day in days)),
            days=dose_words.days_text(len(days), tr),
        )
        caption = {
            "day": tr("Repetitions of each day."),
            "week": tr("Repetitions of each week."),
            "month": tr("Repetitions of each month."),
        }[span_of(days)]
        yield figure(spec, caption, total)
    lines = dose_words.calendar_lines(found, _MONTHS, tr)
    calendar, legend = "\n".join(lines[: lines.index("")]), "   ".join(lines[lines.index("") + 1 :])
    yield f"<pre>{escape(calendar)}</pre><p>{escape(legend)}</p>"


def _glossary(tr: Language) -> Iterator[str]:
    yield f"<h2>{escape(tr('What the figures mean'))}</h2><dl>"
    for name, entry in GLOSSARY.items():
        said = "<br>".join(escape(text) for text in explained(name, tr))
        yield f"<dt>{escape(tr(entry.title))}</dt><dd>{said}</dd>"
    yield "</dl>"

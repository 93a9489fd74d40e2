"""Progress in words: sentences for the screen, the printed page, and a person's record."""

import inspect
from collections.abc import Sequence
from pathlib import Path

from sar_tui.loop.task import Task
from sar_tui.model.language import ENGLISH, Language, language
from sar_tui.model.measure import Measure
from sar_tui.model.results_for_people import metric_for_people, short_goal
from sar_tui.progress.change import BASELINE, FAMILIARISATION
from sar_tui.progress.lines import Side
from sar_tui.progress.scores import InstrumentChange
from sar_tui.records.kind import Kind, Published
from sar_tui.reports.progress import AtGoal, Comparison, LineProgress, Progress, SessionProgress
from sar_tui.reports.wellbeing import advice, dated_event
from sar_tui.rules.declaration import COMMON

_FOLDER = Path(__file__).parent


def words(code: str, kind: type[Task] | None) -> Language:
    """Return the language of a report, with the titles of settings and the translations of a
    task.
    """
    return language(code, COMMON, _FOLDER, *([Path(inspect.getfile(kind)).parent] if kind else []))


def day(stamp: str) -> str:
    """Return the date of a session's stamp."""
    return stamp[:10]


MONTHS = "Jan Feb Mar Apr May Jun Jul Aug Sep Oct Nov Dec"


def short_day(stamp: str, today: str, tr: Language) -> str:
    """Return the date of a stamp, with its year if it is not that of today: "20 Mar", "20 Mar
    2025".
    """
    month = tr(MONTHS).split()[int(stamp[5:7]) - 1]
    shown = f"{int(stamp[8:10])} {month}"
    return shown if stamp[:4] == today[:4] else f"{shown} {stamp[:4]}"


def month(stamp: str, tr: Language) -> str:
    """Return the month of a stamp: "Mar 2026"."""
    return f"{tr(MONTHS).split()[int(stamp[5:7]) - 1]} {stamp[:4]}"


def figure(line: LineProgress, value: float, tr: Language) -> str:
    """Return a value of the line's measure as people read it: "10.4 keys", "0.950 s"."""
    if line.measure == "level":
        shown = line.axis.show(value)
        return tr.figures(
            shown.replace(line.axis.unit, tr(line.axis.unit)) if line.axis.unit else shown
        )
    return tr.figures(_difference(line, measured_value(line, value)))


def measured_value(line: LineProgress, value: float) -> float:
    """Return a value of the line's measure, more of which is better, as it was measured: times have
    their sign.
    """
    return -value if line.measure == "result" and line.metric.better == "lower" else value


def mean(line: LineProgress, session: SessionProgress) -> str:
    """Return the mean of a session's results and the SD between its attempts: "0.95 ± 0.06 s";
    empty without any.
    """
    if session.mean is None:
        return ""
    metric, factor = metric_for_people(line.metric)
    spread = "" if session.sd is None else f" ± {session.sd * factor:.{metric.decimals}f}"
    return f"{session.mean * factor:.{metric.decimals}f}{spread} {metric.unit}".rstrip()


def result(line: LineProgress, value: float, tr: Language) -> str:
    """Return a result as people read it: "0.95 s"."""
    metric, factor = metric_for_people(line.metric)
    return tr.figures(metric.show(value * factor))


def _difference(line: LineProgress, value: float) -> str:
    """Return an SD, a change or the result that it is compared with; a time has one decimal more
    than a result.
    """
    metric, factor = metric_for_people(line.metric)
    return f"{value * factor:z.{metric.decimals + (factor != 1)}f} {metric.unit}".rstrip()


def between_sd(line: LineProgress, tr: Language) -> str:
    """Return the SD between the means of the sessions; empty if it is not known."""
    return "" if line.between_sd is None else tr.figures(_difference(line, line.between_sd))


def at_goal(line: LineProgress, session: SessionProgress, tr: Language) -> str:
    """Return a session's level at goal with its band; empty if it is not known."""
    found = session.at_goal
    if found is None:
        return ""
    shown, limits = (
        figure(line, found.difficulty, tr),
        tr("95 % range {limits}", limits=_limits(line, found, tr)),
    )
    if found.level is None or line.axis.name == "level":
        return f"{shown} ({limits})"
    level = tr("level {level}", level=f"{found.level:.1f}")
    return f"{level} ({shown}, {limits})"


def band(line: LineProgress, session: SessionProgress, tr: Language) -> str:
    """Return a session's level at goal and its band on the axis of difficulty: "10.4 (9.6 to
    11.2)".
    """
    found = session.at_goal
    return f"{_number(line, found.difficulty, tr)} ({_limits(line, found, tr)})" if found else ""


def level_band(line: LineProgress, session: SessionProgress, tr: Language) -> str:
    """Return a session's level at goal with its band in levels, "9.3 (8.8 to 10.1)"; on the axis of
    difficulty if levels have no place there; empty if it is not known.
    """
    found = session.at_goal
    if found is None or not line.places:
        return band(line, session, tr)

    def shown(level: float | None, difficulty: float) -> str:
        if level is not None:
            return tr.figures(f"{level:.1f}")
        return "<1" if difficulty < line.places[0] else f">{len(line.places)}"

    limits = tr(
        "{low} to {high}",
        low=shown(found.level_low, found.low),
        high=shown(found.level_high, found.high),
    )
    return f"{shown(found.level, found.difficulty)} ({limits})"


def _limits(line: LineProgress, found: AtGoal, tr: Language) -> str:
    return tr(
        "{low} to {high}", low=_number(line, found.low, tr), high=_number(line, found.high, tr)
    )


def _number(line: LineProgress, difficulty: float, tr: Language) -> str:
    return tr.figures(line.axis.show(difficulty).removesuffix(line.axis.unit).strip())


def sentences(line: LineProgress, tr: Language) -> list[str]:
    """Return what can be said of a line, in the order in which it is read; nothing of a task
    without a result.
    """
    if line.metric.is_none:
        return []
    said = [_now(line, tr)]
    if line.measure:
        said += [_practice(line, tr), _noise(line, tr), _verdict(line, tr)]
    return [sentence for sentence in said if sentence]


_NOW = {
    "easier": "In the last session every result was better than the goal: harder levels can be "
    "tried.",
    "harder": "In the last session no result reached the goal: easier levels can be tried.",
    "": "The level at goal is not known yet: these results do not tell how they grow with the "
    "level. More sessions may.",
}
"""Sentences on the last session, by the side that its level at goal lies on if it is not known."""


def _now(line: LineProgress, tr: Language) -> str:
    last = line.sessions[-1]
    if line.measure == "result" and last.mean is not None:
        return tr(
            "All attempts were at level {level}. The last mean: {value}.",
            level=str(last.last_level),
            value=result(line, last.mean, tr),
        )
    if last.at_goal and not last.side:
        return tr("Level at goal in the last session: {level}.", level=at_goal(line, last, tr))
    return tr(_NOW[last.side])


_QUALITIES = {
    "sparc": "smoothness (SPARC)",
    "time_to_peak_share": "time to peak (share)",
    "tremor_index": "tremor index",
    "movement_units": "movement units",
}
"""Names of measures; others are shown as they are stored."""


def quality(line: LineProgress, name: str, tr: Language) -> str:
    """Return the name of a measure for people, with its unit if the task declares one."""
    if measure := _declared(line, name):
        return measure.label(tr)
    return tr(_QUALITIES.get(name, name.replace("_", " ")))


def quality_form(line: LineProgress, name: str) -> str:
    """Return the format of a measure's values: the decimals that the task declares, else three
    digits.
    """
    measure = _declared(line, name)
    return f"{{:.{measure.decimals}f}}" if measure else "{:.3g}"


def measured(session: SessionProgress, measure: Measure, tr: Language) -> str:
    """Return a session's mean of a measure, without its unit; empty if it has none."""
    value = session.qualities.get(measure.name)
    return "" if value is None else tr.figures(f"{value:.{measure.decimals}f}")


def _declared(line: LineProgress, name: str) -> Measure | None:
    return next((each for each in line.measured if each.name == name), None)


def spread(line: LineProgress, tr: Language) -> str:
    """Return the SD within the last session and between the sessions' means; empty if neither is
    known.
    """
    within = line.sessions[-1].sd
    said = []
    if within is not None:
        said.append(
            tr(
                "SD within the last session, between its attempts: {sd}.",
                sd=tr.figures(_difference(line, within)),
            )
        )
    if line.between_sd is not None:
        said.append(tr("SD between the means of the sessions: {sd}.", sd=between_sd(line, tr)))
    return " ".join(said)


_STATUSES = {
    "completed": "completed",
    "running": "under way",
    "aborted": "ended early",
    "discarded": "started by mistake",
    "refused": "not agreed to",
}


def status(name: str, tr: Language) -> str:
    """Return the status of a session in words."""
    return tr(_STATUSES.get(name, name))


SIDES = {"": "", "easier": "all too easy", "harder": "all too hard"}
"""Short words for the side of a session whose level at goal is not known."""


def felt(session: SessionProgress, tr: Language) -> list[str]:
    """Return what was said of pain and of tiredness: "pain 2 before, 4 after"."""
    given = session.felt
    pain = _ratings(given.pain_before, given.pain_pause, given.pain_after, tr)
    tired = _ratings(given.fatigue_before, None, given.fatigue_after, tr)
    if given.told_pain and given.pain_pause is None:
        pain.append(tr("said in a pause"))
    named = [(tr("pain"), pain), (tr("tiredness"), tired)]
    said = [f"{name} {', '.join(parts)}" for name, parts in named if parts]
    return [*said, tr("a reason to stop")] if given.is_reason_to_stop else said


def felt_range(line: LineProgress, tr: Language) -> str:
    """Return the first and the last rating of pain and of tiredness in words, and the highest if it
    was between.
    """
    said = []
    for name, given in (
        (tr("pain"), [each.pain for each in line.sessions]),
        (tr("tiredness"), [each.tiredness for each in line.sessions]),
    ):
        known = [rating for rating in given if rating is not None]
        if known:
            highest = max(known)
            between = (
                f" ({tr('highest {rating}', rating=str(highest))})"
                if highest > max(known[0], known[-1])
                else ""
            )
            said.append(f"{name} {known[0]} → {known[-1]}{between}")
    return ", ".join(said)


def _ratings(before: int | None, pause: int | None, after: int | None, tr: Language) -> list[str]:
    moments = (
        (before, tr("{rating} before")),
        (pause, tr("{rating} in a pause")),
        (after, tr("{rating} after")),
    )
    return [text.format(rating=rating) for rating, text in moments if rating is not None]


def _practice(line: LineProgress, tr: Language) -> str:
    found = line.baseline
    if found is None or found.practice <= 0:
        return ""
    first, later = figure(line, found.mean - found.practice, tr), figure(line, found.mean, tr)
    if first == later:
        return ""
    return tr(
        "Practice: from {first} in the first session to {mean} in the next {number}. A gain like "
        "this comes with repeating any test; it is not recovery.",
        first=first,
        mean=later,
        number=str(BASELINE),
    )


def _noise(line: LineProgress, tr: Language) -> str:
    found = line.baseline
    if found is None:
        return tr(
            "Smallest change that is more than noise (MDC95): not yet known. It needs {number} "
            "sessions with a known value.",
            number=str(FAMILIARISATION + BASELINE),
        )
    ends = sorted(
        (found.mean - found.mdc95, found.mean + found.mdc95 + found.rise),
        key=lambda value: measured_value(line, value),
    )
    return tr(
        "Baseline: {mean}. Sessions from {low} to {high} are no more than noise and practice "
        "(MDC95).",
        mean=figure(line, found.mean, tr),
        low=figure(line, ends[0], tr),
        high=figure(line, ends[1], tr),
    )


_VERDICTS = {
    "more": "{session} is better than that: a change that noise and practice do not explain.",
    "less": "{session} is worse than that: a change that noise does not explain.",
    "noise": "{session} is within that: no change can be shown.",
    "not yet known": "Whether there is a change is not yet known.",
}


def _verdict(line: LineProgress, tr: Language) -> str:
    if line.baseline is None:
        return ""
    session = tr("The last session")
    if line.judged != line.sessions[-1].session:
        began = next(each.began for each in line.sessions if each.session == line.judged)
        session = tr("The last session with a known value, of {day},", day=day(began))
    return tr(_VERDICTS[line.verdict], session=session)


_SHORT_VERDICTS = {
    "more": "real improvement",
    "less": "real decline",
    "noise": "no change can be shown",
    "not yet known": "change not yet known",
}
_SHORT_SIDES = {
    "easier": "Last session all too easy",
    "harder": "Last session all too hard",
    "": "Level at goal not yet known",
}


def standing(line: LineProgress, tr: Language) -> str:
    """Return the verdict in a few words, with the value that it is on: "Level 4.5: no change can be
    shown".

    If the last session has no known value it says so first, and names the day of the one that has.
    """
    last = line.sessions[-1]
    unknown = tr(_SHORT_SIDES[last.side])
    judged = next((each for each in line.sessions if each.session == line.judged), None)
    if judged is None:
        return unknown
    verdict = tr(_SHORT_VERDICTS[line.verdict])
    if judged is last:
        return f"{_standing_value(line, judged, tr)}: {verdict}"
    return f"{unknown}. {day(judged.began)}: {_standing_value(line, judged, tr)}, {verdict}"


def _standing_value(line: LineProgress, session: SessionProgress, tr: Language) -> str:
    """Return a session's level at goal, or its mean result where the level never changed."""
    if session.at_goal is None:
        assert session.mean is not None
        value = result(line, session.mean, tr)
        return tr("Mean {value} at level {level}", value=value, level=str(session.last_level))
    if session.at_goal.level is None:
        return tr("{value} at goal", value=figure(line, session.at_goal.difficulty, tr))
    return tr("Level {level}", level=tr.figures(f"{session.at_goal.level:.1f}"))


def goal(line: LineProgress, tr: Language) -> str:
    """Return the goal of a line, with as many decimals as it has: "0.85 s"; empty if it differs
    between levels.
    """
    return "" if line.goal is None else tr.figures(short_goal(line.metric, line.goal))


def heading(line: LineProgress, tr: Language) -> str:
    """Return the heading of a line: the task, the study and its condition, the seat of a pair, the
    goal, and settings that are not the default.
    """
    parts = [tr(line.title)]
    if line.study:
        parts.append(tr("study {study}", study=line.study))
    if line.seat != "A":
        parts.append(tr("seat {seat}", seat=line.seat))
    if line.goal is not None:
        parts.append(tr("goal {goal}", goal=goal(line, tr)))
    if line.mode != "live":
        parts.append(tr(line.mode))
    parts += [
        f"{tr(line.titles.get(name, name))} {_setting(value, tr)}"
        for name, value in line.settings.items()
        if name != "threshold" or line.goal is None
    ]
    return " · ".join(parts)


def _setting(value: object, tr: Language) -> str:
    return " ".join(map(str, value)) if isinstance(value, list) else tr(str(value))


def note(participant: str, line: LineProgress, tr: Language) -> str:
    """Return a paragraph on a line, to paste into a person's record."""
    sessions = line.sessions
    first, last = day(sessions[0].began), day(sessions[-1].began)
    trials, right = sum(each.trials for each in sessions), sum(each.right for each in sessions)
    said_of = felt_range(line, tr)
    said = [
        f"{participant}, {heading(line, tr)}: "
        + (
            tr("1 session on {day}", day=first)
            if len(sessions) == 1
            else tr(
                "{sessions} sessions from {first} to {last}",
                sessions=str(len(sessions)),
                first=first,
                last=last,
            )
        )
        + tr(
            "; {done} of {planned} attempts done, {trials} repetitions, {minutes} min on task, "
            "{right} right.",
            done=str(sum(each.attempts for each in sessions)),
            planned=str(sum(each.planned for each in sessions)),
            trials=str(trials),
            minutes=f"{sum(each.time_on_task_s for each in sessions) / 60:.0f}",
            right=f"{right / trials:.0%}" if trials else "–",
        ),
        *sentences(line, tr),
        *(
            [tr("Worst of each session, 0 to 10, from first to last: {felt}.", felt=said_of)]
            if said_of
            else []
        ),
        tr(
            "A training measure of this program; no diagnosis, and no published important "
            "difference (MCID) applies."
        ),
    ]
    return " ".join(said)


def after_notes(found: Progress, tr: Language) -> list[str]:
    """Return the paragraphs that follow those on the lines: adverse events, and other
    instruments.
    """
    events = " ".join(dated_event(event, tr) for event in found.events)
    return [
        *([events] if events else []),
        *(instrument_change(each, tr) for each in found.instruments),
    ]


def warnings(found: Progress, tr: Language) -> list[str]:
    """Return what the therapist should know of pain and tiredness, and the adverse events with
    their onset.
    """
    return [*advice(found.tell, tr), *(dated_event(event, tr) for event in found.events)]


# --- other instruments


def published(value: Published, kind: Kind, tr: Language = ENGLISH) -> str:
    """Return a published change with its people, its method, the time between the two tests, and
    its source: "MDC95 6.6 points, 22 people, chronic stroke; method: upper 95 % limit of
    agreement; interval: 2 weeks (van der Lee 2001; abstract read)".
    """
    return f"{_published_size(value, kind, tr)} {_source(value, tr)}"


def _published_size(value: Published, kind: Kind, tr: Language) -> str:
    low, high = f"{value.low:g}", f"{value.high:g}"
    size = tr.figures(low) if low == high else tr("{low} to {high}", low=low, high=high)
    unit = kind.score.unit if kind.score else ""
    return tr(
        "{size}, {people}; method: {method}; interval: {interval}",
        size=f"{value.kind} {size} {tr(unit)}".rstrip(),
        people=tr(value.of),
        method=tr(value.method),
        interval=tr(value.interval),
    )


def _source(value: Published, tr: Language) -> str:
    reads = {"": "", "abstract": tr("abstract read"), "whole paper": tr("whole paper read")}
    told = filter(None, (value.source, reads[value.read]))
    return f"({'; '.join(told)})"  # no decimal comma in a DOI


def instrument_change(found: InstrumentChange, tr: Language) -> str:
    """Return the scores of an instrument in words, and how their change compares with published
    ones.
    """
    first, last = found.scores[0], found.scores[-1]
    name = f"{found.instrument.name} ({tr(found.instrument.title)})"
    if found.change is None:
        return f"{name}: {first.score:g}, {first.date}."
    said = [
        tr(
            "{name}: {first} on {began}, {last} on {ended}; change {change}.",
            name=name,
            first=f"{first.score:g}",
            began=first.date,
            last=f"{last.score:g}",
            ended=last.date,
            change=f"{found.change:+g}",
        )
    ]
    for each in found.reached:
        size = _published_size(each.published, found.instrument, tr)
        compared = (
            tr("Reaches {value}", value=size) if each.reached else tr("Below {value}", value=size)
        )
        said.append(f"{compared} {_source(each.published, tr)}.")
    if not found.reached:
        said.append(tr("No change of it that could be compared is published."))
    return " ".join(said)


_REASONS: dict[Side, str] = {
    "easier": "every result was better than the goal",
    "harder": "no result reached the goal",
    "": "the results do not tell how they grow with the level",
}
_REMEDIES: dict[Side, str] = {
    "easier": "Harder levels would make it known.",
    "harder": "Easier levels would make it known.",
    "": "More attempts, at several levels, would make it known.",
}


_DIFFERENCES = {
    "more": "That is better; from {low} to {high} would be no more than noise (MDC95).",
    "less": "That is worse; from {low} to {high} would be no more than noise (MDC95).",
    "noise": "That is no more than noise, which goes from {low} to {high} (MDC95).",
}


def compared(line: LineProgress | None, found: Comparison, tr: Language) -> str:
    """Return the comparison of two sessions in words. ``line`` is theirs, if they share one."""
    if line is None or not found.comparable:
        return tr(
            "These sessions had other settings, or another task: their results cannot be compared."
        )
    if found.earlier.value is None or found.later.value is None:
        return " ".join(
            [*_unknown(found, tr), *_results(line, found, tr), *_remedies(line, found, tr)]
        )
    change = tr(
        "From {earlier} to {later}.",
        earlier=figure(line, found.earlier.value, tr),
        later=figure(line, found.later.value, tr),
    )
    if found.mdc95 is None:
        return f"{change} {tr('How much is noise is not yet known: it needs more sessions.')}"
    ends = found.earlier.value - found.mdc95, found.earlier.value + found.mdc95
    low, high = sorted(ends, key=lambda value: measured_value(line, value))
    limits = {"low": figure(line, low, tr), "high": figure(line, high, tr)}
    verdict = tr(_DIFFERENCES[found.verdict], **limits)
    return f"{change} {verdict}"


def _unknown(found: Comparison, tr: Language) -> list[str]:
    """Return why the level at goal of one session, or of both, is not known."""
    days: dict[Side, list[str]] = {}
    for each in (found.earlier, found.later):
        if each.value is None:
            days.setdefault(each.side, []).append(day(each.began))
    if found.earlier.value is None and found.later.value is None and len(days) == 1:
        return [
            tr(
                "The level at goal of neither is known: {reason}.",
                reason=tr(_REASONS[found.later.side]),
            )
        ]
    return [
        tr(
            "The level at goal of {date} is not known: {reason}.",
            date=day,
            reason=tr(_REASONS[side]),
        )
        for side, (day, *_) in days.items()
    ]


def _results(line: LineProgress, found: Comparison, tr: Language) -> list[str]:
    """Return how the results differ at the levels that were played in both sessions."""
    if found.earlier_mean is None or found.later_mean is None:
        return [tr("No level was played in both, so their results cannot be compared either.")]
    levels = _levels(found.shared_levels, tr)
    said = (
        tr("Mean at level {level}:", level=levels)
        if len(found.shared_levels) == 1
        else tr("Mean at levels {levels}, played in both:", levels=levels)
    )
    means = tr(
        "{earlier}, then {later}; how much of that is noise is not known.",
        earlier=result(line, found.earlier_mean, tr),
        later=result(line, found.later_mean, tr),
    )
    return [f"{said} {means}"]


def _levels(levels: Sequence[int], tr: Language) -> str:
    """Return levels in words: "1, 2", "1 to 8"."""
    first, last = levels[0], levels[-1]
    if len(levels) > 2 and last - first == len(levels) - 1:
        return tr("{low} to {high}", low=str(first), high=str(last))
    return ", ".join(map(str, levels))


def _remedies(line: LineProgress, found: Comparison, tr: Language) -> list[str]:
    """Return what would make the levels at goal known in later sessions: the last unknown one
    tells.
    """
    last = found.later if found.later.value is None else found.earlier
    if last.side == "easier" and line.places and last.last_level == len(line.places):
        return [tr("There is no harder level: a harder goal would begin a new chart.")]
    return [tr(_REMEDIES[last.side])]

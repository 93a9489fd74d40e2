"""Two sessions of a participant compared in words: how they differ, or why that cannot be said and
what would help.
"""

from collections.abc import Sequence

from sar_tui.model.language import Language
from sar_tui.progress.lines import Side
from sar_tui.reports.progress import Comparison, LineProgress
from sar_tui.reports.progress_words import day, figure, measured_value, result

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
    verdict = {
        "more": tr(
            "That is better; from {low} to {high} would be no more than noise (MDC95).", **limits
        ),
        "less": tr(
            "That is worse; from {low} to {high} would be no more than noise (MDC95).", **limits
        ),
        "noise": tr(
            "That is no more than noise, which goes from {low} to {high} (MDC95).", **limits
        ),
    }[found.verdict]
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

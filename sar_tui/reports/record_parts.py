"""The parts of the progress screen that list what is entered by hand: adverse events and scores of
instruments.
"""

from collections.abc import Sequence

from sar_tui.model.language import Language
from sar_tui.progress.instruments import Score
from sar_tui.reports import progress_words
from sar_tui.reports.progress import Progress
from sar_tui.reports.progress_parts import CURSOR, window, wrapped
from sar_tui.reports.wellbeing import advice, dated_event

_FEWEST_LISTED = 3


def events_part(found: Progress, size: tuple[int, int], chosen: int, tr: Language) -> list[str]:
    """Return what the therapist should be told of pain, the adverse events by onset, and the chosen
    one in full.
    """
    width, height = size
    told = wrapped([f"! {text}" for text in advice(found.tell, tr)], width)
    told += [""] if told else []
    if not found.events:
        return [*told, *wrapped([tr("No adverse event is recorded. A records one.")], width)][
            :height
        ]
    heads = (tr("onset"), tr("severity"), tr("what happened"), tr("outcome"))
    rows = [
        (
            each.onset,
            tr(each.severity),
            _cut(each.what, width // 3),
            _cut(each.outcome or "–", width // 4),
        )
        for each in found.events
    ]
    in_full = wrapped([dated_event(found.events[chosen], tr)], width)
    return _listed(told, heads, rows, in_full, size, chosen)


def instruments_part(
    found: Progress, size: tuple[int, int], chosen: int, tr: Language
) -> list[str]:
    """Return the scores of other instruments by date, and what is published of the chosen one's
    changes.
    """
    width, height = size
    known = scores(found)
    if not known:
        return wrapped([tr("No score of another instrument yet. A enters one.")], width)[:height]
    instruments = {each.instrument.name: each for each in found.instruments}
    heads = (tr("date"), tr("instrument"), tr("score"), tr("remark"))
    rows = []
    for each in known:
        instrument = instruments[each.instrument].instrument
        of = f" {instrument.unit}".rstrip()
        rows.append(
            (each.date, each.instrument, f"{each.score:g}{of}", _cut(each.note, width // 2))
        )
    in_full = wrapped(
        [progress_words.instrument_change(instruments[known[chosen].instrument], tr)], width
    )
    return _listed([], heads, rows, in_full, size, chosen)


def scores(found: Progress) -> list[Score]:
    """Return the scores of all instruments by date."""
    return sorted(
        (score for each in found.instruments for score in each.scores), key=lambda score: score.date
    )


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

"""Rows of messages that are written together: the last version of a trial is stored."""

from sar_tui.loop.bus import Record, Topic
from sar_tui.loop.topics import ALL, MARKED, TRIAL
from sar_tui.model import messages as m
from sar_tui.store.messages import Numbers
from sar_tui.store.rows import rows_of

NUMBERS = Numbers(1, dict.fromkeys(ALL, 2))


def record(
    seq: int, topic: Topic[m.TrialMarked] | Topic[m.TrialEnded], message: m.Message
) -> Record:
    return Record(seq, seq, topic, message)


def marked(seat: str = "A", mark: str = "leaned") -> m.TrialMarked:
    return m.TrialMarked(seat=seat, attempt=1, trial=2, mark=mark, correct=True)


def test_a_mark_that_came_before_its_trials_row_is_in_it_already_and_one_that_came_after_is_not() -> (
    None
):
    timing = m.Timing(
        onset_source="flush",
        handler_delay_ms=None,
        loop_lag_ms=0,
        false_starts=0,
        presentation=1,
        foreperiod_ms=900,
        flags=(),
    )
    missed = m.TrialEnded(
        attempt=1,
        trial=2,
        stimulus="f",
        response=None,
        correct=False,
        onset=1,
        response_at=None,
        reaction_time_ms=None,
        value=None,
        timing=timing,
        details={},
    )
    rows = rows_of(
        "s",
        1,
        [record(1, MARKED, marked()), record(2, MARKED, marked("B")), record(3, TRIAL, missed)],
        NUMBERS,
    )
    assert rows["marks"] == [(True, "leaned", "s", 1, 2, "B")]
    rows = rows_of("s", 1, [record(1, TRIAL, missed), record(2, MARKED, marked(mark=""))], NUMBERS)
    assert rows["marks"] == [(True, None, "s", 1, 2, "A")]

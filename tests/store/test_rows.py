"""Rows of messages that are written together: the last version of a trial is stored."""

from sar_tui.loop.bus import Record
from sar_tui.loop.topics import ALL, MARKED, TRIAL
from sar_tui.model import messages as m
from sar_tui.store.messages import Numbers
from sar_tui.store.rows import rows_of

NUMBERS = Numbers(1, dict.fromkeys(ALL, 2))


def marked(seat: str = "A", mark: str = "leaned") -> m.TrialMarked:
    return m.TrialMarked(seat=seat, attempt=1, trial=2, mark=mark, correct=True)


def test_a_mark_before_its_trials_row_is_in_it_and_one_after_is_stored_apart() -> None:
    timing = m.Timing("flush", None, 0, 0, 1, 900, ())
    missed = m.TrialEnded(
        attempt=1, trial=2, stimulus="f", response=None, correct=False, onset=1, response_at=None,
        reaction_time_ms=None, value=None, timing=timing, details={},
    )  # fmt: skip
    before, other, ended = (MARKED, marked()), (MARKED, marked("B")), (TRIAL, missed)
    after = (MARKED, marked(mark=""))
    for given, marks in (
        ((before, other, ended), [(True, "leaned", "s", 1, 2, "B")]),
        ((ended, after), [(True, None, "s", 1, 2, "A")]),
    ):
        records = [
            Record(seq, seq, topic, message) for seq, (topic, message) in enumerate(given, 1)
        ]
        assert rows_of("s", 1, records, NUMBERS)["marks"] == marks

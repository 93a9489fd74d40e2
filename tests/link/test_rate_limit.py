"""How fast a peer may be, and how often it is told of."""

from sar_tui.framework.clock import MS, SECOND
from sar_tui.link.rate_limit import ReportThrottle, TokenBucket


def test_a_burst_passes_and_then_only_what_the_rate_allows() -> None:
    bucket = TokenBucket(rate=10, burst=5)
    assert sum(bucket.take(0) for _ in range(100)) == 5
    assert sum(bucket.take(at * MS) for at in range(1, 1001)) == 10


def test_a_quiet_spell_saves_up_no_more_than_a_burst() -> None:
    bucket = TokenBucket(rate=10, burst=5)
    bucket.take(0)
    assert sum(bucket.take(3600 * SECOND) for _ in range(100)) == 5


def test_what_happens_again_and_again_is_told_at_once_and_then_once_a_second_with_its_count() -> None:
    tally: ReportThrottle[str] = ReportThrottle()
    assert tally.add("flood", 0) == 1
    assert [tally.add("flood", at * MS) for at in range(1, 500)] == [0] * 499
    assert tally.due(999 * MS) == []
    assert tally.due(SECOND) == [("flood", 499)]
    assert tally.due(5 * SECOND) == []
    assert tally.add("flood", 6 * SECOND) == 1


def test_each_thing_is_counted_by_itself() -> None:
    tally: ReportThrottle[str] = ReportThrottle()
    assert tally.add("one", 0) == 1
    assert tally.add("another", 1) == 1


def test_more_things_than_there_is_room_for_are_not_told_until_others_are_forgotten() -> None:
    tally: ReportThrottle[int] = ReportThrottle(max_keys=3)
    assert [tally.add(thing, 0) for thing in range(1000)] == [1, 1, 1] + [0] * 997
    assert tally.due(SECOND) == []
    assert tally.add(999, SECOND) == 1

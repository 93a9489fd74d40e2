"""Token bucket and report throttle."""

from sar_tui.link.admission import ReportThrottle, TokenBucket
from sar_tui.model.units import MS, SECOND


def test_bucket_passes_a_burst_then_the_rate() -> None:
    bucket = TokenBucket(rate=10, burst=5)
    assert sum(bucket.take(0) for _ in range(100)) == 5
    assert sum(bucket.take(at * MS) for at in range(1, 1001)) == 10


def test_bucket_saves_no_more_than_a_burst() -> None:
    bucket = TokenBucket(rate=10, burst=5)
    bucket.take(0)
    assert sum(bucket.take(3600 * SECOND) for _ in range(100)) == 5


def test_repeated_event_is_reported_at_once_then_once_a_second_with_count() -> None:
    throttle: ReportThrottle[str] = ReportThrottle()
    assert throttle.add("flood", 0) == 1
    assert [throttle.add("flood", at * MS) for at in range(1, 500)] == [0] * 499
    assert throttle.due(999 * MS) == []
    assert throttle.due(SECOND) == [("flood", 499)]
    assert throttle.due(5 * SECOND) == []
    assert throttle.add("flood", 6 * SECOND) == 1


def test_events_are_counted_separately() -> None:
    throttle: ReportThrottle[str] = ReportThrottle()
    assert throttle.add("one", 0) == 1
    assert throttle.add("another", 1) == 1


def test_events_beyond_the_maximum_wait_until_others_are_forgotten() -> None:
    throttle: ReportThrottle[int] = ReportThrottle(max_keys=3)
    assert [throttle.add(thing, 0) for thing in range(1000)] == [1, 1, 1] + [0] * 997
    assert throttle.due(SECOND) == []
    assert throttle.add(999, SECOND) == 1

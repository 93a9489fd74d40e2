"""Rules on pain and tiredness: stop now, and tell the therapist."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.rules.wellbeing import HIGHEST, PainLimits, SessionRatings, stop_now, tell_therapist

RATINGS = st.one_of(st.none(), st.integers(0, HIGHEST))


@pytest.mark.parametrize(
    ("before", "now", "reason"),
    [
        (None, None, None),
        (None, 5, None),
        (None, 6, "too much pain"),
        (0, 1, None),
        (0, 2, "rising pain"),
        (3, 5, "rising pain"),
        (4, 5, None),
        (6, 10, "too much pain"),
        (8, 7, "too much pain"),
        (5, 0, None),
        (5, None, None),
    ],
)
def test_pain_above_five_or_two_more_than_before_is_a_reason_to_stop(
    before: int | None, now: int | None, reason: str | None
) -> None:
    assert stop_now(before, now, PainLimits()) == reason


def test_the_therapist_sets_the_limits() -> None:
    assert stop_now(None, 8, PainLimits(highest=8)) is None
    assert stop_now(None, 1, PainLimits(highest=0)) == "too much pain"
    assert stop_now(2, 4, PainLimits(rise=3)) is None
    assert SessionRatings(pain_before=2, pain_after=4).is_reason_to_stop
    assert not SessionRatings(
        pain_before=2, pain_after=4, limits=PainLimits(rise=3)
    ).is_reason_to_stop


@given(RATINGS, st.integers(0, HIGHEST - 1))
def test_more_pain_is_never_less_of_a_reason_to_stop(before: int | None, now: int) -> None:
    limits = PainLimits()
    assert stop_now(before, now, limits) is None or stop_now(before, now + 1, limits) is not None


def pains(*ratings: int | None) -> list[SessionRatings]:
    """Return sessions after which this pain was told."""
    return [SessionRatings(pain_after=rating) for rating in ratings]


@pytest.mark.parametrize(
    ("ratings", "reasons"),
    [
        ((), ()),
        ((0, 2, 3, 2), ()),
        ((0, 2, 3, 2, 1), ("new pain",)),
        ((0, 2, 3, 0, 1), ()),
        ((2, 3, 4, 3, 5), ("worse pain",)),
        ((2, 3, 4, 2, 5), ()),
        ((0, 2, None, 3, 2, None, 1), ("new pain",)),
        ((3, 3, 3, 3, 3, 3), ()),
    ],
)
def test_pain_that_is_new_or_worse_over_four_sessions_is_told(
    ratings: tuple[int | None, ...], reasons: tuple[str, ...]
) -> None:
    assert tell_therapist(pains(*ratings)) == reasons


def test_the_first_four_sessions_are_compared_with_the_first_rating() -> None:
    first = SessionRatings(pain_before=0, pain_after=2)
    assert tell_therapist([first, *pains(1, 1, 2)]) == ("new pain",)
    assert tell_therapist([SessionRatings(pain_before=2, pain_after=2), *pains(2, 2, 2)]) == ()
    assert tell_therapist(pains(1, 1, 1, 1)) == (), "nothing is known of the time before"


def test_pain_that_was_a_reason_to_stop_when_last_rated_is_told() -> None:
    rising = SessionRatings(pain_before=1, pain_pause=4, pain_after=2)
    assert tell_therapist([rising]) == ("stop",)
    assert tell_therapist([rising, SessionRatings()]) == ("stop",), "the last session did not ask"
    assert tell_therapist([rising, *pains(2)]) == ()


def test_what_came_of_the_advice_not_to_train_is_told() -> None:
    for advice in ("stopped", "went on"):
        assert tell_therapist([SessionRatings(pain_before=9, advice=advice)]) == ("stop", advice)  # type: ignore[arg-type]
    assert tell_therapist([SessionRatings(pain_before=9, advice="shown")]) == ("stop",)


def test_pain_before_sessions_that_never_began_is_no_session_with_pain() -> None:
    never = SessionRatings(pain_before=3, began=False)
    assert tell_therapist([*pains(0, 2, 3), never, never]) == ()


def test_pain_told_in_a_pause_counts_as_pain() -> None:
    told = SessionRatings(told_pain=True)
    assert told.pain == 1
    assert SessionRatings(pain_before=2, pain_pause=6, pain_after=3, told_pain=True).pain == 6
    assert tell_therapist([*pains(0), told, told, told, told]) == ("new pain",)


@pytest.mark.parametrize(
    ("tired", "is_told"), [((7,), False), ((8, 7), True), ((7, 6), False), ((2, 9, 10), True)]
)
def test_severe_tiredness_after_two_sessions_running_is_told(
    tired: tuple[int, ...], is_told: bool
) -> None:
    assert (
        tell_therapist([SessionRatings(fatigue_after=each) for each in tired]) == ("tired",)
    ) is is_told

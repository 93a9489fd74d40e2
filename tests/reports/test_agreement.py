"""Agreement of operators: examples computed by hand, and properties."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.reports.agreement import agreement, kappa, word_distance
from sar_tui.reports.proposals import ProposalRecord
from tests.reports.session_script import has

VALENCES = st.sampled_from(["positive", "neutral", "negative"])
WORDS = st.lists(st.sampled_from(["well", "done", "slow", "again"]), max_size=6).map(" ".join)


def decided(
    verdict: Any, text: str = "Well done.", said: str | None = None, *valences: Any
) -> ProposalRecord:
    before, after = valences or (None, None)
    return ProposalRecord(
        "a1", 1, "feedback", "approve", 0, text, before, verdict=verdict, said=said,
        said_valence=after,
    )  # fmt: skip


def test_kappa_of_tables_computed_by_hand() -> None:
    """Observed (20 + 15) / 50 = 0.7; by chance 25/50 · 30/50 + 25/50 · 20/50 = 0.5; (0.7 − 0.5) /
    0.5 = 0.4.
    """
    pairs = [("yes", "yes")] * 20 + [("yes", "no")] * 5 + [("no", "yes")] * 10 + [("no", "no")] * 15
    assert kappa(pairs) == 0.4
    assert kappa([("positive", "negative"), ("negative", "positive")]) == -1
    assert kappa([]) is None
    assert kappa([("positive", "positive")] * 7) is None, "not defined without variation"


@given(st.lists(st.tuples(VALENCES, VALENCES), min_size=1, max_size=30))
def test_kappa_is_symmetric_and_one_in_full_agreement_only(pairs: list[tuple[str, str]]) -> None:
    found = kappa(pairs)
    assert found == kappa([(other, one) for one, other in pairs])
    if found is not None:
        assert -1 <= found <= 1
        assert (found == 1) == all(one == other for one, other in pairs)


@pytest.mark.parametrize(
    ("before", "after", "share"),
    [
        ("You were slow.", "You were slow.", 0),
        ("You were slow.", "You were quick.", 1 / 3),
        ("You were slow.", "You were a little slow.", 2 / 5),
        ("You were slow.", "", 1),
        ("", "Well done.", 1),
        ("", "", 0),
        ("one two three", "three one two", 2 / 3),
    ],
)
def test_the_share_of_words_that_an_edit_changed(before: str, after: str, share: float) -> None:
    assert word_distance(before, after) == pytest.approx(share)


@given(WORDS, WORDS, WORDS)
def test_word_distance_is_a_metric(one: str, two: str, three: str) -> None:
    def steps(before: str, after: str) -> float:
        return word_distance(before, after) * max(len(before.split()), len(after.split()))

    assert 0 <= word_distance(one, two) <= 1
    assert (word_distance(one, two) == 0) == (one.split() == two.split())
    assert word_distance(one, two) == word_distance(two, one)
    assert steps(one, three) <= steps(one, two) + steps(two, three) + 1e-9


def test_a_session_computed_by_hand() -> None:
    praise, blame = ("Well done.", "Well done."), ("Too slow.", "Too slow.")
    found = agreement(
        [
            decided("accepted", *praise, "positive", "positive"),
            decided("accepted", *praise, "positive", "positive"),
            decided("accepted", *blame, "negative", "negative"),
            decided("edited", "Too slow.", "A bit slow.", "negative", "neutral"),
            decided("edited", "one two three four", "one two three five", "positive", "positive"),
            decided("edited", *praise, "positive", "neutral"),
            decided("vetoed", "Too slow.", None, "negative", None),
            decided(None, *blame, "negative", "negative"),
        ]
    )
    has(found, decided=7, accepted=3, edited=3, vetoed=1, valences=6, valences_overridden=2)
    has(found, edits_of_words=2, words_changed_median=0.4583, words_changed_most=0.6667)
    assert found.accepted_share == 0.4286, "3 of 7"
    negative, positive = {"negative": 1, "neutral": 1}, {"neutral": 1, "positive": 3}
    assert found.valence_table == {"negative": negative, "positive": positive}
    # (4/6 − (4·3 + 2·1)/36) / (1 − 14/36) = (24 − 14) / (36 − 14)
    assert found.valence_kappa == 0.4545
    none = {"accepted_share": None, "words_changed_median": None, "valence_kappa": None}
    has(agreement([decided(None)]), decided=0, **none)

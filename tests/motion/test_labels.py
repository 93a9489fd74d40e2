"""Labels of reaches are edited such that reaches never overlap, and nothing is lost."""

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.motion.labels import SHORTEST_S, Correction, Label, confirmed, mistake


def correction(*edges: tuple[float, float]) -> Correction:
    """Return labels of reaches in a recording of 60 s."""
    labels = [Label(start_s=a, end_s=b, confidence=0.9, excursion_deg=40.0) for a, b in edges]
    return Correction(labels, 0.0, 60.0)


def test_a_reach_is_accepted_or_dropped_and_dropping_is_taken_back() -> None:
    edited = correction((2, 4), (10, 13))
    before = edited.labels[1]
    assert not edited.is_changed
    assert edited.accept(0) == 0
    assert edited.drop(1) == 1
    assert [label.state for label in edited.labels] == ["accepted", "dropped"]
    assert [label.state for label in confirmed(edited.labels)] == ["accepted"]
    assert edited.is_changed
    assert edited.drop(1) == 1
    assert edited.labels[1] == before
    edited.drop(0)
    edited.drop(0)
    assert edited.labels[0].state == "accepted", "as it was before"
    edited.saved()
    assert not edited.is_changed


def test_an_edge_moves_as_far_as_there_is_room() -> None:
    edited = correction((2, 4), (4.5, 7))
    assert edited.move(0, "end", 0.3) == 0
    moved = edited.labels[0]
    assert (moved.start_s, moved.end_s, moved.state) == (2, 4.3, "moved")
    assert moved.excursion_deg is None, "it is measured again"
    edited.move(0, "end", 5.0)
    assert edited.labels[0].end_s == 4.5
    assert edited.move(0, "end", 0.1) is None
    edited.move(0, "start", -9.0)
    assert edited.labels[0].start_s == 0.0
    edited.move(0, "start", 99.0)
    assert edited.labels[0].reach_time_s == pytest.approx(SHORTEST_S)
    edited.drop(1)
    assert edited.move(1, "end", 0.1) is None, "it is dropped"


def test_a_reach_is_added_where_there_is_room() -> None:
    edited = correction((2, 4), (10, 13))
    assert edited.insert(3.0) is None
    assert edited.insert(7.0) == 1
    assert (edited.labels[1].start_s, edited.labels[1].end_s) == (5.5, 8.5)
    assert (edited.labels[1].state, edited.labels[1].confidence) == ("added", None)
    assert edited.insert(4.1) == 1, "shorter than usual, between two others"
    assert (edited.labels[1].start_s, edited.labels[1].end_s) == (4, 5.5)
    assert edited.insert(60.0) is not None, "at the end of the recording"
    assert edited.labels[-1].end_s == 60.0


def test_a_dropped_reach_does_not_come_back_over_an_added_one() -> None:
    edited = correction((2, 5))
    edited.drop(0)
    added = edited.insert(3.0)
    assert added is not None
    (dropped,) = (at for at, label in enumerate(edited.labels) if not label.counts)
    assert edited.drop(dropped) is None
    assert edited.accept(dropped) is None
    assert edited.at(3.0) == added


def test_the_next_reach_is_one_after_another_or_the_next_unsure_one() -> None:
    edited = correction((2, 4), (10, 13), (20, 22))
    edited.labels[2] = msgspec.structs.replace(edited.labels[2], confidence=0.5)
    assert edited.next(1, after=0, at_s=3.0) == 1
    assert edited.next(1, after=None, at_s=5.0) == 1
    assert edited.next(-1, after=None, at_s=5.0) == 0
    assert edited.next(1, after=0, at_s=3.0, only_unsure=True) == 2
    assert edited.next(1, after=2, at_s=21.0) is None
    assert edited.next(-1, after=0, at_s=3.0) is None


@pytest.mark.parametrize(
    ("labels", "says"),
    [
        ([Label(start_s=1, end_s=2), Label(start_s=2, end_s=3)], ""),
        ([Label(start_s=1, end_s=1)], "does not end after its start"),
        ([Label(start_s=5, end_s=6), Label(start_s=1, end_s=2)], "not in order"),
        ([Label(start_s=1, end_s=3), Label(start_s=2, end_s=4)], "overlap"),
        ([Label(start_s=1, end_s=3, state="dropped")], "before it was dropped"),
    ],
)
def test_labels_that_cannot_be_are_named(labels: list[Label], says: str) -> None:
    assert says in mistake(labels)
    assert bool(mistake(labels)) == bool(says)


_EDITS = st.one_of(
    st.tuples(st.sampled_from(["accept", "drop"]), st.integers(0, 9)),
    st.tuples(
        st.just("move"),
        st.integers(0, 9),
        st.sampled_from(["start", "end"]),
        st.floats(-5, 5, allow_nan=False),
    ),
    st.tuples(st.just("insert"), st.floats(0, 60)),
)


@given(st.lists(_EDITS, max_size=30))
def test_whatever_is_edited_the_labels_can_be_saved(edits: list[tuple[object, ...]]) -> None:
    edited = correction((2, 4), (4, 7), (30, 33))
    for name, *arguments in edits:
        before = list(edited.labels)
        if name != "insert":
            arguments[0] = int(str(arguments[0])) % len(edited.labels)
        index = getattr(edited, str(name))(*arguments)
        assert (index is None) == (before == edited.labels) or name in ("accept", "move")
        assert not mistake(edited.labels)
        assert all(0.0 <= label.start_s < label.end_s <= 60.0 for label in edited.labels)

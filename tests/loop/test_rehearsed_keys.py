"""The keys that a simulated participant presses if a task does not say more."""

import pytest

from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.trial_types import Performance, Stimulus
from tests.staircase_task import Contrast


@pytest.mark.parametrize(
    ("expected", "slips", "keys"),
    [("f", False, ["f"]), ("f", True, ["wrong"]), ("", False, []), ("", True, ["wrong"])],
)
def test_the_expected_key_is_pressed_and_none_where_none_is_expected(
    expected: str, slips: bool, keys: list[str]
) -> None:
    task = Contrast(Contrast.Parameters())
    acts = task.rehearse(
        Stimulus("a", expected, "Now"), Performance(400.0, slips=slips), RandomStreams(1)
    )
    assert acts == [(400.0, key) for key in keys]

"""A session with one switch is planned for tasks that need one key."""

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.rules.declaration import ParameterError
from sar_tui.runs.plan import make_plan


@pytest.mark.parametrize("task", ["keyboard", "flanker", "srtt", "posner"])
def test_a_task_with_several_keys_is_refused(catalogue: Catalogue, task: str) -> None:
    with pytest.raises(ParameterError, match="several keys"):
        make_plan(catalogue, task, ["P01"], {"switch": "one"}, mode="simulated")


@pytest.mark.parametrize("task", ["gonogo", "tapping", "nback", "reaching"])
def test_a_task_with_one_key_is_planned(catalogue: Catalogue, task: str) -> None:
    plan = make_plan(catalogue, task, ["P01"], {"switch": "two"}, mode="simulated")
    assert plan.parameters.switch == "two"

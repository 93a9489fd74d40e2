"""Nothing is frozen before everything that can refuse a person was looked at, and `check` tells what
is frozen already.
"""

from pathlib import Path

import pytest

from tests.program import Call
from tests.store.by_hand import value
from tests.study.plans import TWO_GROUPS, written

FACTORS = TWO_GROUPS.replace("[outcome]", '[allocation.strata]\nage = ["young", "old"]\n[outcome]')


@pytest.fixture
def key(tmp_path: Path) -> Path:
    return tmp_path / "praise.key"


def test_a_plan_is_not_frozen_for_a_person_who_is_refused(
    call: Call, data: Path, tmp_path: Path, key: Path
) -> None:
    file = written(tmp_path, FACTORS)
    how = ("study enrol PX9 --plan", file, "--key", key)
    call(*how, "--factor", "age=young").refused("PX9")
    call(*how, "--new").refused("The factor age is missing")
    call(*how, "--new", "--factor", "age=young", "--replaces", "P02").refused("P02 is not in")
    call(*how, "--new", "--factor", "age=young", "--study", "other").refused("not of other")
    assert value(data, "SELECT count(*) FROM studies") == 0
    assert not key.exists()
    call(*how, "--new", "--factor", "age=young").shows("PX9 is number 1")
    assert value(data, "SELECT count(*) FROM studies") == 1


def test_check_says_that_a_changed_plan_is_frozen(call: Call, tmp_path: Path, key: Path) -> None:
    file = written(tmp_path)
    assert "frozen" not in call("study check", file).out
    assert call("study freeze", file, "--key", key).code == 0
    assert "frozen" not in call("study check", file).out
    file.write_text(TWO_GROUPS.replace("attempts = 2", "attempts = 4"))
    call("study check", file).shows("Version 1 of the study praise was frozen", "study amend")

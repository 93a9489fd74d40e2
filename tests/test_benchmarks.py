"""Tests that every part of the benchmarks can be measured. Their figures are not looked at:
machines are noisy.
"""

import json
import subprocess
import sys

import pytest

from benchmarks import label_reaches
from benchmarks.parts import PARTS
from benchmarks.real_recordings import BY_RULE

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs a pseudo-terminal")


@pytest.mark.slow
@pytest.mark.parametrize("part", PARTS)
def test_a_part_of_the_benchmarks_is_measured(part: str) -> None:
    command = [sys.executable, "-m", "benchmarks", part, "--quick", "--trials", "5"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=1200, check=False)
    assert done.returncode in (0, 1), done.stderr
    assert not done.stderr
    assert "not measured" not in done.stdout


def test_the_labels_of_reaches_are_those_of_their_rule() -> None:
    assert label_reaches.labelled() == json.loads(BY_RULE.read_text())

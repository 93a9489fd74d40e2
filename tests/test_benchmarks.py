"""Tests that every part of the benchmarks can be measured. Their figures are not looked at:
machines are noisy.
"""

import subprocess
import sys

import pytest

from benchmarks.parts import PARTS

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs a pseudo-terminal")


@pytest.mark.slow
@pytest.mark.parametrize("part", PARTS)
def test_a_part_of_the_benchmarks_is_measured(part: str) -> None:
    command = [sys.executable, "-m", "benchmarks", part, "--quick", "--trials", "5"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=1200, check=False)
    assert done.returncode in (0, 1), done.stderr
    assert not done.stderr
    assert "not measured" not in done.stdout

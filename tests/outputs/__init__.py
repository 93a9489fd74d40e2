"""Tests of outputs; one that fails in a check that all of them share tells as much as any other."""

import pytest

pytest.register_assert_rewrite("tests.outputs.contract")

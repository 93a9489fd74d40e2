"""Tests of outputs. Assertions in their shared checks are rewritten, too."""

import pytest

pytest.register_assert_rewrite("tests.outputs.contract")

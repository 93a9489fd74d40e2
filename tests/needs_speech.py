"""Whether the speech engine is there. Without it the tests that listen to it are skipped, unless they are required."""

import ctypes.util
import os
import sys

import pytest

_IS_MISSING = sys.platform == "linux" and ctypes.util.find_library("espeak-ng") is None
needs_speech = pytest.mark.skipif(
    _IS_MISSING and os.environ.get("SAR_TUI_TEST_SPEECH") != "required",
    reason="there is no speech engine: install espeak-ng",
)

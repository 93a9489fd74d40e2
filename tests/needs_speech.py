"""Mark for tests of the speech engine: skipped without it, unless
``SAR_TUI_TEST_SPEECH=required``.
"""

import ctypes.util
import os
import sys

import pytest

_IS_MISSING = sys.platform == "linux" and ctypes.util.find_library("espeak-ng") is None
needs_speech = pytest.mark.skipif(
    _IS_MISSING and os.environ.get("SAR_TUI_TEST_SPEECH") != "required",
    reason="no speech engine is installed; on Debian and Ubuntu: sudo apt install espeak-ng",
)

"""Marks for tests that Octave or R judges: skipped without it, unless
``SAR_TUI_TEST_STATISTICS=required``.
"""

import os
import shutil

import pytest

_IS_REQUIRED = os.environ.get("SAR_TUI_TEST_STATISTICS") == "required"
needs_octave = pytest.mark.skipif(
    shutil.which("octave-cli") is None and not _IS_REQUIRED,
    reason="Octave is not installed; on Debian and Ubuntu: sudo apt install octave",
)
needs_r = pytest.mark.skipif(
    shutil.which("Rscript") is None and not _IS_REQUIRED,
    reason="R is not installed; on Debian and Ubuntu: sudo apt install r-base-core",
)

"""Mark for tests that look through a browser: skipped without one, unless
``SAR_TUI_TEST_BROWSER=required``.
"""

import os
import shutil

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or "chromium"
needs_browser = pytest.mark.skipif(
    shutil.which(CHROMIUM) is None and os.environ.get("SAR_TUI_TEST_BROWSER") != "required",
    reason="no browser is installed; on Debian and Ubuntu: sudo apt install chromium",
)

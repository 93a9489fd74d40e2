"""Whether there is a browser. Without it the tests that look through one are skipped, unless they are required."""

import os
import shutil

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or "chromium"
needs_browser = pytest.mark.skipif(
    shutil.which(CHROMIUM) is None and os.environ.get("SAR_TUI_TEST_BROWSER") != "required",
    reason="there is no browser: install chromium",
)

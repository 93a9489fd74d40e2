"""Plug-ins as if packages offered them."""

from collections.abc import Sequence
from typing import Any

import pytest

from sar_tui import plugin_loader


def offer(monkeypatch: pytest.MonkeyPatch, group: str, entries: Sequence[Any]) -> None:
    """Have one group of entry points hold these, and the others none."""
    monkeypatch.setattr(
        plugin_loader, "entry_points", lambda asked: entries if asked == group else ()
    )

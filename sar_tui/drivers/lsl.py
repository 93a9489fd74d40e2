"""The Lab Streaming Layer (LSL): its library, kept quiet, and its clock."""

import contextlib
import os
from pathlib import Path
from typing import Any

from sar_tui.drivers.installation import pip_install_extra
from sar_tui.loop.clock import host_now
from sar_tui.model.units import SECOND

_READINGS = 50
_QUIET = "[log]\nlevel = -3\n"
"""Lets LSL write nothing to the terminal, where its lines would cover the session's screen."""
_configured = False


class NoLibrary(Exception):
    """LSL cannot be loaded. The message says why, and how to install it."""


def clock_offset_ns(pylsl: Any) -> int:
    """Return LSL's clock minus the session's, in ns: the reading of many that took least time."""
    readings = []
    for _ in range(_READINGS):
        before = host_now()
        theirs = float(pylsl.local_clock())
        after = host_now()
        readings.append((after - before, round(theirs * SECOND) - (before + after) // 2))
    return min(readings)[1]


def library() -> Any:
    """Import LSL, so that it stays quiet unless the user's own configuration says otherwise. Raises
    NoLibrary.
    """
    global _configured  # noqa: PLW0603 - LSL reads its configuration once in a process
    try:
        import pylsl
    except (
        ImportError,
        OSError,
        RuntimeError,
    ) as error:  # its library written in C is missing or too old
        raise NoLibrary(
            f"LSL cannot be loaded ({str(error).splitlines()[0]}). {no_package()}"
        ) from error
    if not _configured:
        _configured = True
        own = _own_configuration()
        if "[log]" not in own:
            # pylsl raises it for an older library of the system, which stays noisy but works
            with contextlib.suppress(NotImplementedError):
                pylsl.set_config_content(f"{own}\n{_QUIET}")
    return pylsl


def _own_configuration() -> str:
    """Return the configuration that LSL would read: the first of its usual files; empty if there is
    none.
    """
    named = os.environ.get("LSLAPICFG")
    usual = ("lsl_api.cfg", Path("~/lsl_api/lsl_api.cfg").expanduser(), "/etc/lsl_api/lsl_api.cfg")
    for path in [named] if named else usual:
        try:
            return Path(path).read_text(encoding="utf-8", errors="replace")
        except OSError:
            continue
    return ""


def no_package() -> str:
    """Return the sentence that says how to install what is missing."""
    return f"LSL needs a package that is not installed here: {pip_install_extra('lsl')}"

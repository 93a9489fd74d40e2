"""What an output tells, read with care: it may be anybody's code, and the log has to be able to hold it."""

from typing import Any, get_args

from sar_tui.framework.clock import SECOND
from sar_tui.framework.messages import ActionPart, PartState
from sar_tui.outputs.output import Report

LONGEST_DETAIL = 500
"""So many characters of a detail are kept."""
AHEAD = SECOND
"""How far ahead of the session's clock a report's time may be."""


def heard(report: Any, since: int, now: int) -> Report | None:
    """A report as it can be kept; None if it cannot be understood.

    Args:
        report: what the output told.
        since, now: the time it tells of lies between these (ns).
    """
    try:
        said = Report(report.action, report.part, report.state, int(report.at), words(report.detail))
        known = said.part in get_args(ActionPart) and said.state in get_args(PartState)
    except Exception:
        return None
    return said if known and since <= said.at <= now + AHEAD else None


def words(said: object) -> str:
    """What was said, as text that can be written anywhere; not all of it, where it is long."""
    try:
        text = str(said)
    except Exception:
        text = f"a {type(said).__name__} that cannot be read"
    return text[:LONGEST_DETAIL].encode("utf-8", "replace").decode()


def told_by(error: Exception) -> str:
    """An exception, in a sentence's words."""
    return words(f"{type(error).__name__}: {words(error)}")

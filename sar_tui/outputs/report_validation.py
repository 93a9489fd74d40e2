"""Checks reports of outputs, which may be third-party code, before they are logged."""

from typing import Any, get_args

from sar_tui.model.messages import ActionPart, PartState
from sar_tui.model.units import SECOND
from sar_tui.outputs.output import Report

LONGEST_DETAIL = 500
"""Longer details are cut to this many characters."""
AHEAD = SECOND
"""Largest time by which a report may be ahead of the session's clock."""


def valid_report(report: Any, since: int, now: int) -> Report | None:
    """Return a report that can be stored; None if it is invalid.

    Args:
        report: the output's report.
        since, now: the range of valid times (ns).
    """
    try:
        value = Report(
            report.action, report.part, report.state, int(report.at), as_text(report.detail)
        )
        known = value.part in get_args(ActionPart) and value.state in get_args(PartState)
    except Exception:
        return None
    return value if known and since <= value.at <= now + AHEAD else None


def as_text(value: object) -> str:
    """Return a value as text that any file can hold, shortened if it is long."""
    try:
        text = str(value)
    except Exception:
        text = f"a {type(value).__name__} that cannot be read"
    return text[:LONGEST_DETAIL].encode("utf-8", "replace").decode()


def describe(error: BaseException) -> str:
    """Describe an exception for use in a sentence."""
    return as_text(f"{type(error).__name__}: {as_text(error)}")

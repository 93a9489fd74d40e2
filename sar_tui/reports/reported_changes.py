"""Changes that the feedback of a session reported, each beside its MDC95, as lines of text."""

from collections.abc import Iterable, Mapping
from typing import Any


def lines(actions: Iterable[Mapping[str, Any]]) -> list[str]:
    """Return a line for each feedback that was said and reported a change, in order.

    Args:
        actions: rows of a session, as `store.sessions.rows` returns them.
    """
    said = [row["final"] for row in actions if row["kind"] == "feedback" and row["final"]]
    return [
        f"After attempt {final['attempt']}, feedback reported: {evidence}."
        for final in said
        if (evidence := final.get("evidence"))
    ]

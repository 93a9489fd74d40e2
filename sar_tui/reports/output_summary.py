"""Summary of a session's outputs: actions done and failed."""

import sqlite3
from collections import Counter
from typing import Any

import msgspec

from sar_tui.outputs.node import CLOSE
from sar_tui.store.database import read_json

_OVER = ("done", "aborted", "failed")
_REPORTS = """SELECT topic, message FROM events
           WHERE session=? AND topic IN ('output/opened', 'output/report', 'framework/fault')
           ORDER BY seq"""


class OutputSummary(msgspec.Struct):
    """Output of a session. ``why``: the most frequent reason for its failures; ``not_closed``: why
    closing failed.
    """

    output: str
    address: str = ""
    done: int = 0
    aborted: int = 0
    failed: int = 0
    why: str = ""
    not_closed: str = ""

    @property
    def line(self) -> str:
        """Its failures, as "speech: 5 of 5 failed (There is no sound card.)"; empty if there are
        none.
        """
        problems = []
        if self.failed:
            why = f" ({self.why})" if self.why else ""
            problems.append(
                f"{self.failed} of {self.done + self.aborted + self.failed} failed{why}"
            )
        if self.not_closed:
            problems.append(f"it was not closed ({self.not_closed})")
        return f"{self.output}: {'; '.join(problems)}" if problems else ""


def output_summaries(database: sqlite3.Connection, session: str) -> list[OutputSummary]:
    """Summarise the outputs of a session in the order in which they were opened.

    The last report on each part of an action counts.
    """
    opened: dict[str, OutputSummary] = {}
    last: dict[tuple[str, str, str], dict[str, Any]] = {}
    for topic, text in database.execute(_REPORTS, (session,)):
        message = read_json(text)
        if topic == "framework/fault":
            if message["node"] in opened and message["topic"] == CLOSE:
                opened[message["node"]].not_closed = message["error"]
            continue
        found = opened.setdefault(message["output"], OutputSummary(message["output"]))
        if topic == "output/opened":
            found.address = message["address"]
        elif message["state"] in _OVER:
            last[message["output"], message["action"], message["deed"]] = (
                message  # stored spelling of `part`
            )
    reasons: dict[str, Counter[str]] = {name: Counter() for name in opened}
    for (name, _, _), report in last.items():
        found = opened[name]
        setattr(found, report["state"], getattr(found, report["state"]) + 1)
        if report["state"] == "failed" and report.get("detail"):
            reasons[name][report["detail"]] += 1
    for name, counted in reasons.items():
        opened[name].why = counted.most_common(1)[0][0] if counted else ""
    return list(opened.values())

"""Summary of a session's outputs: actions done and failed."""

import sqlite3
from collections import Counter
from typing import Any

import msgspec

from sar_tui.loop.topics import MARKERS
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


# --- markers for other recorders


class MarkerSummary(msgspec.Struct):
    """Markers of a session for one destination, in all runs of the program.

    ``runs``: how often it was used; ``unfinished``: in how many of these the program was ended
    before it could count. ``late_ms``: the largest of the runs' medians from a prompt's onset until
    its marker was sent; ``latest_ms``: the largest of these times. ``failures``: why it failed,
    each once. ``facts``: what opening and closing found out.
    """

    destination: str
    runs: int = 0
    unfinished: int = 0
    sent: int = 0
    lost: int = 0
    unheard: int = 0
    late_ms: float | None = None
    latest_ms: float | None = None
    failures: list[str] = []
    facts: list[str] = []

    @property
    def line(self) -> str:
        """One line: "Markers to lsl: 120 sent, 0 lost; …"."""
        parts = [f"{self.sent} sent, {self.lost} lost"]
        if self.unheard:
            parts.append(f"{self.unheard} sent while nobody listened")
        if self.late_ms is not None and self.latest_ms is not None:
            parts.append(
                f"prompts sent {self.late_ms:.1f} ms after their onset, at most "
                f"{self.latest_ms:.1f} ms"
            )
        if self.unfinished:
            parts.append("not counted in a run that was killed or is not over")
        sentence = f"Markers to {self.destination}: {'; '.join(parts)}."
        return " ".join([sentence, *self.failures, *(f"{fact}." for fact in self.facts)])


def marker_summaries(database: sqlite3.Connection, session: str) -> list[MarkerSummary]:
    """Summarise the markers of a session, in the order in which their destinations were opened."""
    found: dict[str, MarkerSummary] = {}
    rows = database.execute(
        "SELECT run, message FROM events WHERE session=? AND topic=? ORDER BY seq",
        (session, MARKERS.name),
    )
    seen: set[tuple[str, int]] = set()
    for run, text in rows:
        change = read_json(text)
        name = change["destination"]
        summary = found.setdefault(name, MarkerSummary(name))
        if (name, run) not in seen:
            seen.add((name, run))
            summary.runs += 1
            summary.unfinished += 1
        detail = change.get("detail", "")
        if change["state"] == "failing" and detail not in summary.failures:
            summary.failures.append(detail)
        elif change["state"] != "failing" and detail and detail not in summary.facts:
            summary.facts.append(detail)
        if change["state"] == "closed":
            summary.unfinished -= 1
            for count in ("sent", "lost", "unheard"):
                setattr(summary, count, getattr(summary, count) + change.get(count, 0))
            for late in ("late_ms", "latest_ms"):
                values = [
                    each for each in (getattr(summary, late), change.get(late)) if each is not None
                ]
                setattr(summary, late, max(values, default=None))
    return list(found.values())

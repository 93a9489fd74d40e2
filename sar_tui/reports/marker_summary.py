"""Summary of a session's markers: where they went, and how many arrived."""

import sqlite3

import msgspec

from sar_tui.loop.topics import MARKERS
from sar_tui.store.database import read_json


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

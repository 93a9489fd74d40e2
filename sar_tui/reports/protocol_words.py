"""Adherence to the operators' protocol in words."""

from collections.abc import Iterator

from sar_tui.reports.protocol import Adherence, DueItem
from sar_tui.reports.sections import Section, Table

_LISTED = 30
"""Items that are shown; JSON has all."""
_ACTS = {"say": "said", "veto": "vetoed", "edit": "edited"}
_VERDICTS = {"vetoed": ("veto", "vetoes"), "edited": ("edit", "edits")}


def section(found: Adherence) -> Section:
    """Return the section on the protocol."""
    return Section("Protocol", ["\n".join(_sentences(found)), *_items(found)])


def _sentences(found: Adherence) -> Iterator[str]:
    used = ", ".join(
        f"{each.name} version {each.version} (SHA-256 {each.hash[:12]}…)"
        for each in found.protocols
    )
    operators = f"{found.operators} operator{'' if found.operators == 1 else 's'}"
    yield f"By the protocol {used}, with {operators}. {_practice(found)}"
    if not found.due:
        yield "Nothing was due by it."
    else:
        parts = [
            f"{name} {n} ({n / found.due:.0%})"
            for name, n in (
                ("done in time", found.done),
                ("done late", found.late),
                ("omitted", found.omitted),
            )
        ]
        told = [
            f"{n} {what}"
            for n, what in (
                (found.not_done, "left out by a key"),
                (found.failed, "refused by the session"),
            )
            if n
        ]
        more = f"; of those, {' and '.join(told)}" if told else ""
        yield f"Due {found.due}: {', '.join(parts)}{more}."
    if times := found.latency_s:
        yield (
            f"From due to done: median {times.median:.1f} s, from {times.least:.1f} to "
            f"{times.most:.1f} s (n = {times.n})."
        )
    outside = ", ".join(f"{_ACTS.get(kind, kind)} {n}" for kind, n in sorted(found.outside.items()))
    yield f"Acts outside of the protocol: {outside or 'none'}."
    for verdict, counts in found.reasons.items():
        n = sum(counts.values())
        reasons = ", ".join(f"{text} {times}" for text, times in counts.items())
        yield f"Reasons of {n} {_VERDICTS[verdict][n != 1]}: {reasons}."


def _practice(found: Adherence) -> str:
    if not any(found.practised.values()):
        return "No practice on recorded sessions is on record."
    told = ", ".join(f"{who} {times}" for who, times in found.practised.items())
    return f"Recorded sessions practised before: {told}."


def _items(found: Adherence) -> Iterator[Table]:
    if not found.items:
        return
    left = len(found.items) - _LISTED
    more = f"… and {left} more: --json has them all." if left > 0 else ""
    heads = ("run", "due at, s", "attempt", "what", "outcome", "after, s")
    rows = [_row(item) for item in found.items[:_LISTED]]
    yield Table(heads, rows, (*heads[:3], "after, s"), ("outcome",), more)


def _row(item: DueItem) -> tuple[str, ...]:
    latency = "" if item.latency_s is None else f"{item.latency_s:.1f}"
    what = f"{item.what} {item.number}: {item.do}"
    return str(item.run), f"{item.at_s:.1f}", str(item.attempt), what, item.outcome, latency

"""The result of a practice in words."""

from collections.abc import Iterator

from sar_tui.operator.practice import Agreed, PracticeResult
from sar_tui.reports.protocol_words import section as protocol_section
from sar_tui.reports.sections import Section, Table

_LONGEST = 40
"""Characters of a proposal's text that are shown."""


def sections(found: PracticeResult) -> list[Section]:
    """Return the result in words."""
    table: list[Table] = []
    if found.proposals:
        rows = [
            (
                each.kind,
                each.text if len(each.text) <= _LONGEST else f"{each.text[:_LONGEST]}…",
                each.yours or "no decision",
                each.protocol,
                each.recorded,
                "" if each.decision_ms is None else f"{each.decision_ms / 1000:.1f}",
            )
            for each in found.proposals
        ]
        heads = ("proposal", "text", "you", "protocol", "recorded", "s")
        table.append(Table(heads, rows, ("s",), ("you", "protocol", "recorded")))
    said = "\n".join(_sentences(found))
    return [Section("Practice", [said, *table]), protocol_section(found.adherence)]


def _sentences(found: PracticeResult) -> Iterator[str]:
    n = found.decided + found.timed_out
    end = "" if found.is_complete else " It was left before its end."
    yield f"Practice on session {found.session}.{end}"
    yield f"{n} proposal{'' if n == 1 else 's'}: {found.decided} decided in time."
    yield f"As the protocol says: {_share(found.as_protocol, 'it asks for no decision')}."
    yield f"As the recorded operator: {_share(found.as_recorded, 'nobody decided')}."


def _share(agreed: Agreed, none: str) -> str:
    return f"{agreed.same} of {agreed.of}" if agreed.of else none

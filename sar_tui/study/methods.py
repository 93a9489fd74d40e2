"""The methods of a study in words, for a paper: the plan, and numbers from the log alone."""

import sqlite3
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from sar_tui.export.methods import methods as methods_of_sessions
from sar_tui.export.passports import passports
from sar_tui.store import sessions
from sar_tui.study import ledger
from sar_tui.study.ledger import Frozen
from sar_tui.study.preregistration import conditions_in_words


def methods(db: sqlite3.Connection, folder: Path, frozen: Frozen) -> str:
    """Return a page in Markdown: participants and design, then the methods of the sessions."""
    ids = {one.id for one in ledger.played(db, frozen.plan.name, frozen.mode)}
    rows = [row for row in sessions.listing(db, folder) if row["id"] in ids][::-1]
    design = " ".join(_design(db, frozen))
    rest = methods_of_sessions(rows, passports(rows, with_dates=True)) if rows else ""
    return f"# Methods of {frozen.plan.title or frozen.plan.name}\n\n{design}\n\n" + rest.replace(
        "# Methods\n\n", "", 1
    )


def _design(db: sqlite3.Connection, frozen: Frozen) -> Iterator[str]:
    plan = frozen.plan
    people = ledger.enrolments(db, plan.name)
    sites = {one.participant.partition("@")[2] for one in people}
    at = f" at {len(sites)} sites" if len(sites) > 1 else ""
    yield f"{len(people)} people were enrolled{at}."
    groups = Counter(one.group for one in people if one.group)
    if groups:
        counts = ", ".join(f"{count} in {name}" for name, count in sorted(groups.items()))
        yield f"By group: {counts}."
    yield from conditions_in_words(plan)
    days = ", ".join(f"{visit.name} (day {visit.day})" for visit in plan.visits)
    yield f"Visits: {days}."
    ended = Counter(one.ended for one in people if one.ended)
    if ended:
        yield f"Participation ended early: {', '.join(f'{n} {how}' for how, n in ended.items())}."
    deviations = Counter(each.what for each in ledger.deviations(db, plan.name, frozen.mode))
    if deviations:
        told = ", ".join(f"{count} {what}" for what, count in deviations.most_common())
        yield f"Deviations from the plan: {told}."
    yield (
        f"The plan was frozen on {frozen.frozen_at[:10]} as version {plan.version} (SHA-256 "
        f"{frozen.sha256})."
    )

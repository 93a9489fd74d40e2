"""Numbered sheets for sealed envelopes, where no computer is at hand when people are enrolled."""

from collections.abc import Iterator, Sequence
from html import escape
from itertools import product

from sar_tui.reports.sections import document
from sar_tui.study.allocation import AllocationError, Assigned, Draws, assign
from sar_tui.study.enrolment import names_of
from sar_tui.study.plan import Study

_STYLE = (
    "<style>.sheet { page-break-after: always; min-height: 24rem; border-bottom: 1px dashed #888;"
    " padding: 1rem 0; } .inside { font-size: 2rem; margin-top: 6rem; }</style>"
)


def sheets(plan: Study, draws: Draws, site: str, number: int) -> Iterator[tuple[str, int, str]]:
    """Yield the stratum, the number in it, and the group of each sheet, as `enrol` will draw them.

    Args:
        plan: the study.
        draws: from its key.
        site: code of the site; empty if it has none.
        number: of sheets for each stratum.

    Raises:
        AllocationError: groups depend on who was enrolled before, or are listed elsewhere.
    """
    if not plan.groups or plan.allocation.method in ("minimisation", "list"):
        raise AllocationError(
            f"Sheets cannot be made for the method {plan.allocation.method}: its groups do not "
            "follow from the number of the person alone."
            if plan.groups
            else "The plan has no groups."
        )
    names = names_of(plan, draws)
    weights = {name: group.weight for name, group in plan.groups.items()}
    for values in product(*plan.allocation.strata.values()):
        stratum = "|".join(filter(None, (site, *values)))
        before: list[Assigned] = []
        for at in range(1, number + 1):
            group = assign(plan.allocation, weights, draws, before, stratum)
            before.append(Assigned(group=group, stratum=stratum))
            yield stratum, at, names.groups[group]


def page(plan: Study, found: Sequence[tuple[str, int, str]]) -> str:
    """Return a page that prints each sheet on a paper of its own."""
    title = f"Envelopes of the study {plan.title or plan.name}"
    body = [_STYLE, f"<h1>{escape(title)}</h1>"]
    for stratum, number, group in found:
        where = ", ".join(stratum.split("|")) or "all"
        body.append(
            f'<section class="sheet"><h2>{escape(plan.name)} · {escape(where)} · {number}</h2>'
            "<p>Outside of the envelope: the line above. Open it when the person is enrolled, and "
            "write down code, date and name of who opened it.</p>"
            f'<p class="inside">Group: {escape(group)}</p></section>'
        )
    return document(title, body)

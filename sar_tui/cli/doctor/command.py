"""``sar-tui doctor``: what works here, and how to mend what does not."""

from typing import TYPE_CHECKING

import typer

from sar_tui.cli.common import AsJson, Data, Home, Tasks, console, print_json
from sar_tui.cli.errors import FAILED

if TYPE_CHECKING:
    from sar_tui.cli.doctor.check import Finding

_MARKS = {"ok": "✓", "care": "!", "bad": "✗"}


def doctor(context: typer.Context, as_json: AsJson = False, data: Data = None, tasks: Tasks = None) -> None:
    """Tell what works here, and how to mend the rest."""
    from sar_tui.cli.doctor.general import examine

    findings = list(examine(Home.of(context, data, tasks)))
    if as_json:
        print_json({"checks": findings})
    else:
        _print(findings)
    if any(finding.state == "bad" for finding in findings):
        raise typer.Exit(FAILED)


def _print(findings: "list[Finding]") -> None:
    """A line each, and under it how to mend it."""
    import textwrap

    width = max(60, console().width)
    widest = max(len(finding.name) for finding in findings)
    for finding in findings:
        head = f"{_MARKS[finding.state]} {finding.name.ljust(widest)}  "
        margin = " " * len(head)
        print(textwrap.fill(finding.found, width, initial_indent=head, subsequent_indent=margin))
        if finding.mend:
            mend = textwrap.fill(finding.mend, width, initial_indent=f"{margin}→ ", subsequent_indent=f"{margin}  ")
            print(mend)

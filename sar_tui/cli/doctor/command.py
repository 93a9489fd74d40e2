"""``sar-tui doctor``: check this machine and this installation, and say how to fix what does not
work.
"""

from typing import TYPE_CHECKING

import typer

from sar_tui.cli.common import AsJson, Data, Home, Tasks, console, print_json, watch_plugins
from sar_tui.tui.exit_codes import FAILED

if TYPE_CHECKING:
    from sar_tui.cli.doctor.finding import Finding

_MARKS = {"ok": "✓", "care": "!", "bad": "✗"}


def doctor(
    context: typer.Context, as_json: AsJson = False, data: Data = None, tasks: Tasks = None
) -> None:
    """Check what works on this machine, and how to fix what does not."""
    from sar_tui.cli.doctor.examination import examine

    watch_plugins(context)
    findings = list(examine(Home.of(context, data, tasks)))
    if as_json:
        print_json({"checks": findings})
    else:
        _print(findings)
    if any(finding.state == "bad" for finding in findings):
        raise typer.Exit(FAILED)


def _print(findings: "list[Finding]") -> None:
    """Print a paragraph for each finding, with the advice below it."""
    import textwrap

    width = max(60, console().width)
    widest = max(len(finding.name) for finding in findings)
    for finding in findings:
        head = f"{_MARKS[finding.state]} {finding.name.ljust(widest)}  "
        margin = " " * len(head)
        print(textwrap.fill(finding.found, width, initial_indent=head, subsequent_indent=margin))
        if finding.advice:
            arrow = f"{margin}→ "
            print(
                textwrap.fill(
                    finding.advice, width, initial_indent=arrow, subsequent_indent=f"{margin}  "
                )
            )

"""``sar-tui doctor``: check this machine and this installation, and say how to fix what does not
work.
"""

import textwrap
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import typer

from sar_tui.cli.common import AsJson, Home, console, print_json, watch_plugins
from sar_tui.tui.exit_codes import FAILED

if TYPE_CHECKING:
    from sar_tui.cli.doctor.finding import Finding, Machine

_MARKS = {"ok": "✓", "care": "!", "bad": "✗"}


def doctor(context: typer.Context, home: Home, as_json: AsJson = False) -> None:
    """Check what works on this machine, and how to fix what does not."""
    watch_plugins(context)
    findings = list(examine(home, checks()))
    if as_json:
        print_json({"checks": findings})
    else:
        _print(findings)
    if any(finding.state == "bad" for finding in findings):
        raise typer.Exit(FAILED)


class Check(NamedTuple):
    """A name, and the function that looks. ``waits``: for a device or a child process, so that it
    runs beside the others.
    """

    name: str
    look: "Callable[[Machine], Finding]"
    waits: bool = False


def checks() -> Sequence[Check]:
    """Return all checks, in the order in which they are printed."""
    from sar_tui.cli.doctor import devices, machine
    from sar_tui.cli.doctor import devices as link
    from sar_tui.cli.doctor.data_in_git import examine_data_in_git
    from sar_tui.cli.doctor.letterbox import letterbox
    from sar_tui.cli.doctor.system_keys import system_keys

    return (
        Check("Python", machine.python),
        Check("Terminal", machine.terminal),
        Check("Terminal size", machine.size),
        Check("Colours", machine.colours),
        Check("Pictures", machine.pictures),
        Check("Connection", machine.connection),
        Check("Slow keys", system_keys, waits=True),
        Check("Clock", machine.clock),
        Check("Onset stamps", machine.onset_stamps),
        Check("Priority", machine.priority),
        Check("Measured timing", machine.measured_timing),
        Check("Sensor driver", devices.sensor_driver, waits=True),
        Check("Motion sensor", devices.motion_sensor, waits=True),
        Check("Servo controller", devices.servo_controller, waits=True),
        Check("Speech", devices.speech_engine),
        Check("Sound card", devices.sound_card),
        Check("Markers, LSL", devices.lsl_markers, waits=True),
        Check("Markers, serial", devices.serial_markers),
        Check("Operator here", link.operator_here),
        Check("Invitations", link.invitations),
        Check("Browser", link.browser),
        Check("Letterbox", letterbox),
        Check("Data", machine.database),
        Check("Saved data", machine.saved_data),
        Check("Data and git", examine_data_in_git, waits=True),
        Check("Disk space", machine.disk_space),
        Check("Tasks", machine.tasks),
        Check("Themes", machine.themes),
        Check("Outputs", machine.outputs),
        Check("Policies", machine.policies),
    )


def examine(home: Home, checks: Sequence[Check]) -> "Iterator[Finding]":
    """Run checks. One that raises is itself a finding."""
    from concurrent.futures import ThreadPoolExecutor

    from msgspec.structs import replace

    from sar_tui.cli.doctor import devices
    from sar_tui.cli.doctor.finding import Machine, bad

    with ThreadPoolExecutor() as pool:
        here = Machine(home, pool.submit(devices.examine_voice).result)
        waiting = {each.name: pool.submit(each.look, here) for each in checks if each.waits}
        for each in checks:
            try:
                found = waiting[each.name].result() if each.waits else each.look(here)
            except Exception as error:
                found = bad(f"This check failed ({type(error).__name__}: {error}).")
            yield replace(found, name=each.name)


def _print(findings: "Sequence[Finding]") -> None:
    """Print a paragraph for each finding, with the advice below it."""
    width = max(60, console().width)
    widest = max(len(finding.name) for finding in findings)
    for finding in findings:
        head = f"{_MARKS[finding.state]} {finding.name.ljust(widest)}  "
        margin = " " * len(head)
        print(textwrap.fill(finding.found, width, initial_indent=head, subsequent_indent=margin))
        if finding.advice:
            arrow, below = f"{margin}→ ", f"{margin}  "
            print(
                textwrap.fill(finding.advice, width, initial_indent=arrow, subsequent_indent=below)
            )

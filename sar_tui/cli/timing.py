"""``sar-tui timing``: measure the timing of this machine, or the delays of tones."""

import sys
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import AsJson, Home, console, print_json
from sar_tui.cli.progress_line import progress_line
from sar_tui.tui.exit_codes import FAILED

if TYPE_CHECKING:
    from sar_tui.timing.tones import ToneDelays
    from sar_tui.timing.verdict import Measured


def timing(
    home: Home,
    trials: Annotated[
        int, typer.Option(min=10, max=10_000, help="Number of responses to measure.")
    ] = 100,
    sound: Annotated[
        bool,
        typer.Option(
            "--sound", help="Measure the delays of tones instead: --trials of each kind, audible."
        ),
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Measure the timing of this machine.

    Reports whether it is fit for an experiment, and why. The figures are stored with later
    sessions, except those of tones.
    """
    raise typer.Exit(_tones(trials, as_json) if sound else _keys(home.folder, trials, as_json))


def _keys(folder: Path, trials: int, as_json: bool) -> int:
    """Measure reaction times, print, and return the exit code."""
    if sys.platform == "win32":
        print(
            "Timing cannot be measured on Windows: it has no pseudo-terminals. Use Linux or macOS.",
            file=sys.stderr,
        )
        return FAILED
    from sar_tui.timing.closed_loop import Mismatch
    from sar_tui.timing.scripted_participant import NoPrompt
    from sar_tui.timing.verdict import measure

    done = count(1)
    try:
        with progress_line("Measuring", still=True) as show:
            measured = measure(
                folder, trials, lambda name: show(f"Measuring {name}", next(done), 2 * trials)
            )
    except (NoPrompt, Mismatch, TimeoutError) as error:
        print(f"Timing could not be measured. {error}", file=sys.stderr)
        return FAILED
    if as_json:
        print_json({"timing": measured.as_json()})
    else:
        _print(measured)
    return 0


def _print(measured: "Measured") -> None:
    from sar_tui.cli.tables import add, table

    columns = ("bias (median)", "SD", "robust SD", "p99", "worst")
    made = table("error, ms", "trials", *columns, right=("trials", *columns))
    for name, figures in (("sar-tui", measured.own), ("a bare loop", measured.baseline)):
        shown = (
            figures.median_ms,
            figures.sd_ms,
            figures.robust_sd_ms,
            figures.p99_ms,
            figures.max_ms,
        )
        add(made, name, figures.n, *(f"{value:.2f}" for value in shown))
    out = console()
    out.print(made)
    plain = {
        "fit": "This machine is fit for an experiment: its error is far below the variation of "
        "keyboards and people.",
        "fit with care": "This machine is fit for an experiment, with care:",
        "not fit": "This machine is not fit for an experiment:",
    }
    out.print(f"\n{plain[measured.verdict]}")
    for reason in measured.reasons:
        out.print(f"  {reason}")
    out.print(
        "\nNot in these figures: the keyboard (11-73 ms), the terminal's drawing and the monitor."
    )


def _tones(number: int, as_json: bool) -> int:
    """Measure the delays of tones, print, and return the exit code."""
    from sar_tui.outputs.sound.protocol import SoundError
    from sar_tui.timing.tones import measure_tones

    done = count(1)
    try:
        with progress_line("Playing tones", still=True) as show:
            found = measure_tones(
                number, on_tone=lambda: show("Playing tones", next(done), 2 * number)
            )
    except (SoundError, OSError) as error:
        print(f"The delays of tones could not be measured. {error}", file=sys.stderr)
        return FAILED
    if as_json:
        print_json({"sound": found})
    else:
        _print_tones(found)
    return 0


def _print_tones(found: "ToneDelays") -> None:
    from sar_tui.cli.tables import add, table
    from sar_tui.timing.tones import AHEAD_MS

    columns = ("median", "robust SD", "p99", "worst")
    made = table("delay, ms", "tones", *columns, right=("tones", *columns))
    named = {"requested at once": found.at_once, f"planned {AHEAD_MS} ms ahead": found.planned}
    for name, figures in named.items():
        shown = (figures.median_ms, figures.robust_sd_ms, figures.p99_ms, figures.max_ms)
        add(made, name, figures.n, *(f"{value:.2f}" for value in shown))
    out = console()
    out.print(made)
    out.print(
        f"\n{found.card}: a sample waits {found.buffer_ms:.0f} ms in its buffer, which is in "
        "these figures."
    )
    out.print(
        "Not in these figures: what comes after it, such as a sound server, a wireless "
        "loudspeaker, the air."
    )

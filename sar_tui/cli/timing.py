"""``sar-tui timing``: check whether this machine is fit for an experiment.

It measures sar-tui and a bare loop alternately, each in a pseudo-terminal with a scripted
participant (``timing.closed_loop``). The verdict is the worst of these columns:

=============  ============  =========  =======  ========================  ==================
verdict        robust SD     |median|   p99      terminal                  clock
=============  ============  =========  =======  ========================  ==================
fit            1 ms or less  1 ms       5 ms     neither of these          steps of 0.1 ms
fit with care  3 ms or less  3 ms       20 ms    in a multiplexer          steps of 0.1 ms
not fit        more          more       more     over SSH                  coarser
=============  ============  =========  =======  ========================  ==================

1 ms is far below the delay of a keyboard's scanning (11-73 ms, Bridges et al. 2020). The
measurement runs in a terminal of its own, so it does not include the delay of SSH or of a
multiplexer: the verdict takes their presence into account.
"""

import json
import math
import os
import sys
import tempfile
import time
from collections.abc import Mapping
from datetime import UTC, datetime
from itertools import count
from pathlib import Path

import msgspec

from sar_tui.cli.common import console, print_json
from sar_tui.cli.progress_line import progress_line
from sar_tui.cli.tables import add, table
from sar_tui.drivers.private_folder import make_private
from sar_tui.store import provenance
from sar_tui.timing.closed_loop import BASELINE, MAX_PROMPTS, SAR_TUI, Mismatch, take_turns
from sar_tui.timing.error_statistics import ErrorStatistics, error_statistics
from sar_tui.timing.scripted_participant import NoPrompt
from sar_tui.tui.exit_codes import FAILED

FILE = provenance.TIMING_FILE
VERDICTS = ("fit", "fit with care", "not fit")
_LIMITS = (
    ("robust_sd_ms", 1.0, 3.0, "Reaction times scatter by {:.1f} ms (robust SD)."),
    ("median_ms", 1.0, 3.0, "Reaction times are off by {:.1f} ms (median)."),
    ("p99_ms", 5.0, 20.0, "One reaction time in a hundred is off by {:.1f} ms or more (p99)."),
)
_COARSE_CLOCK = 1e-4
_BUSY = 0.5
"""Load average for each core from which a busy machine is reported as a cause."""


class Circumstances(msgspec.Struct, frozen=True):
    """Circumstances that can make timing less exact.

    Args:
        ssh: True if the program runs over SSH.
        multiplexer: name of the terminal multiplexer, if there is one.
        load: load average over the minute before the measurement, if the system has one.
        cores: number of processor cores.
        clock_step: resolution of the clock in s.
        stamped_at_flush: share of prompts whose onset was stamped when the frame was flushed.
    """

    ssh: bool = False
    multiplexer: str | None = None
    load: float | None = None
    cores: int = 1
    clock_step: float = 1e-9
    stamped_at_flush: float = 1.0


def run(folder: Path, trials: int, as_json: bool) -> int:
    """Measure, print, store the figures in ``folder/timing.json`` for later sessions, and return
    the exit code.
    """
    if sys.platform == "win32":
        print(
            "Timing cannot be measured on Windows: it has no pseudo-terminals. Use Linux or macOS.",
            file=sys.stderr,
        )
        return FAILED
    make_private(folder)
    load = os.getloadavg()[0]
    try:
        with progress_line("Measuring", still=True) as show:
            done = count(1)

            def on_press(name: str) -> None:
                show(f"Measuring {name}", next(done), 2 * trials)

            measured = take_turns(
                (SAR_TUI, BASELINE),
                trials,
                max(4, math.ceil(trials / MAX_PROMPTS)),
                folder,
                on_press,
            )
    except (NoPrompt, Mismatch, TimeoutError) as error:
        print(f"Timing could not be measured. {error}", file=sys.stderr)
        return FAILED
    own, baseline = (
        error_statistics([trial.error_ms for trial in measured[program.name]])
        for program in (SAR_TUI, BASELINE)
    )
    machine = provenance.machine()
    at_flush = [trial.timing.get("onset_source") == "flush" for trial in measured[SAR_TUI.name]]
    verdict, reasons = judge(
        own,
        baseline,
        Circumstances(
            ssh=machine["ssh"],
            multiplexer=machine["multiplexer"],
            load=load,
            cores=machine["cores"] or 1,
            clock_step=time.get_clock_info("monotonic").resolution,
            stamped_at_flush=sum(at_flush) / len(at_flush),
        ),
    )
    figures = {
        "measured_at": datetime.now(UTC).isoformat(),
        **_figures(own),
        "verdict": verdict,
    }
    _write(folder / FILE, figures)
    if as_json:
        print_json({"timing": {**figures, "reasons": reasons, "bare": _figures(baseline)}})
    else:
        _print(own, baseline, verdict, reasons)
    return 0


def judge(
    own: ErrorStatistics, baseline: ErrorStatistics, here: Circumstances
) -> tuple[str, list[str]]:
    """Return the verdict and its reasons: first the findings, then possible causes."""
    worst, reasons = 0, []
    for name, fit, care, words in _LIMITS:
        value = getattr(own, name)
        if abs(value) > fit:
            worst = max(worst, 1 if abs(value) <= care else 2)
            reasons.append(words.format(value))
    if worst:
        reasons += _causes(own, baseline, here)
    if here.stamped_at_flush < 1:
        worst = max(worst, 1)
        reasons.append(
            "Some prompts could not be stamped as they reached the terminal; their stamps are "
            "less exact."
        )
    if here.multiplexer:
        worst = max(worst, 1)
        reasons.append(
            f"You are in {here.multiplexer}, whose delay is not in these figures. Run sessions "
            "outside it."
        )
    if here.ssh:
        worst = 2
        reasons.append(
            "You are connected by SSH: its delay is not in these figures. Run sessions on the "
            "machine itself."
        )
    if here.clock_step > _COARSE_CLOCK:
        worst = 2
        reasons.append(f"This machine's clock moves in steps of {here.clock_step * 1e3:.1f} ms.")
    return VERDICTS[worst], reasons


def _causes(own: ErrorStatistics, baseline: ErrorStatistics, here: Circumstances) -> list[str]:
    causes = []
    if here.load is not None and here.load > _BUSY * here.cores:
        causes.append(
            f"The machine is busy (load {here.load:.1f} on {here.cores} "
            f"core{'s' if here.cores > 1 else ''}). "
            "Close other programs and measure again."
        )
    if any(abs(getattr(baseline, name)) > fit for name, fit, *_ in _LIMITS):
        causes.append(
            "A bare loop is no better, so the cause is the machine: is it virtual, or saving power?"
        )
    else:
        causes.append(
            "A bare loop does better on this machine. Measure again; if the result is the same, "
            "please report it."
        )
    return causes


def _figures(of: ErrorStatistics) -> dict[str, float | int]:
    """Return the figures that are stored and printed, to the microsecond."""
    names = ("median_ms", "sd_ms", "robust_sd_ms", "p99_ms")
    return {"trials": of.n} | {name: round(getattr(of, name), 3) for name in names}


def _write(path: Path, figures: Mapping[str, object]) -> None:
    """Write a file atomically, readable only by the user."""
    handle, name = tempfile.mkstemp(prefix=".timing-", dir=path.parent)  # mkstemp makes it 0600
    with os.fdopen(handle, "w") as file:
        json.dump(figures, file, indent=2)
    Path(name).replace(path)


def _print(
    own: ErrorStatistics, baseline: ErrorStatistics, verdict: str, reasons: list[str]
) -> None:
    columns = ("bias (median)", "SD", "robust SD", "p99", "worst")
    made = table("error, ms", "trials", *columns, right=("trials", *columns))
    for name, figures in (("sar-tui", own), ("a bare loop", baseline)):
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
    out.print(f"\n{plain[verdict]}")
    for reason in reasons:
        out.print(f"  {reason}")
    out.print(
        "\nNot in these figures: the keyboard (11-73 ms), the terminal's drawing and the monitor."
    )

"""Verdict on a machine: whether it is fit for an experiment.

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
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from statistics import fmean, median, quantiles, stdev
from typing import NamedTuple

import msgspec

from sar_tui.drivers.files import make_private
from sar_tui.store import provenance
from sar_tui.timing.closed_loop import BASELINE, MAX_PROMPTS, SAR_TUI, take_turns

_NORMAL = 1.4826
"""The standard deviation of a normal distribution, in median absolute deviations."""


class ErrorStatistics(msgspec.Struct, frozen=True):
    """Statistics of ``n`` errors in ms.

    ``robust_sd_ms`` is the median absolute deviation scaled to be the standard deviation of normal
    errors, so that one stall of the machine does not hide the distribution of the others (Leys et
    al. 2013). ``iqr_ms`` is the interquartile range, ``p99_ms`` the 99th percentile of the errors'
    absolute values, ``max_ms`` the largest.
    """

    n: int
    mean_ms: float
    median_ms: float
    sd_ms: float
    iqr_ms: float
    robust_sd_ms: float
    p99_ms: float
    max_ms: float


def error_statistics(errors: Sequence[float]) -> ErrorStatistics:
    """Compute the statistics of errors in ms. Percentiles are interpolated between the errors (R's
    type 7).

    Raises:
        ValueError: there are fewer than two.
    """
    if len(errors) < 2:
        raise ValueError("Error statistics take two errors or more.")
    middle = median(errors)
    lower, _, upper = quantiles(errors, n=4, method="inclusive")
    sizes = [abs(error) for error in errors]
    return ErrorStatistics(
        n=len(errors),
        mean_ms=fmean(errors),
        median_ms=middle,
        sd_ms=stdev(errors),
        iqr_ms=upper - lower,
        robust_sd_ms=_NORMAL * median(abs(error - middle) for error in errors),
        p99_ms=quantiles(sizes, n=100, method="inclusive")[98],
        max_ms=max(sizes),
    )


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


class Measured(NamedTuple):
    """The errors of sar-tui and of a bare loop, the verdict and its reasons, and the figures that
    are stored.
    """

    own: ErrorStatistics
    baseline: ErrorStatistics
    verdict: str
    reasons: list[str]
    figures: Mapping[str, object]

    def as_json(self) -> dict[str, object]:
        return {**self.figures, "reasons": self.reasons, "bare": _figures(self.baseline)}


def measure(folder: Path, trials: int, on_press: Callable[[str], None]) -> Measured:
    """Measure, and store the figures in ``folder/timing.json`` for later sessions.

    Raises NoPrompt, Mismatch or TimeoutError if it cannot be measured.
    """
    make_private(folder)
    load = os.getloadavg()[0]
    blocks = max(4, math.ceil(trials / MAX_PROMPTS))
    measured = take_turns((SAR_TUI, BASELINE), trials, blocks, folder, on_press)
    own, baseline = (
        error_statistics([trial.error_ms for trial in measured[program.name]])
        for program in (SAR_TUI, BASELINE)
    )
    machine = provenance.machine()
    at_flush = [trial.timing.get("onset_source") == "flush" for trial in measured[SAR_TUI.name]]
    here = Circumstances(
        ssh=machine["ssh"],
        multiplexer=machine["multiplexer"],
        load=load,
        cores=machine["cores"] or 1,
        clock_step=time.get_clock_info("monotonic").resolution,
        stamped_at_flush=sum(at_flush) / len(at_flush),
    )
    verdict, reasons = judge(own, baseline, here)
    measured_at = datetime.now(UTC).isoformat()
    figures = {"measured_at": measured_at, **_figures(own), "verdict": verdict}
    _write(folder / FILE, figures)
    return Measured(own, baseline, verdict, reasons, figures)


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

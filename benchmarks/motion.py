"""Milliseconds of the analysis of a reach, and seconds and memory of `sar-tui detect` on hours of
samples.

The analysis stands beside a bare low-pass of the same samples: six Fourier transforms of three
axes, which no detector can do without. Times are those of the CPU.
"""

import json
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from sar_tui.motion.analysis import AnalysisParameters, Window, analyse
from sar_tui.motion.detector_names import COLUMN_NAMES, DetectorName
from sar_tui.motion.reach_kinds import KINDS
from sar_tui.motion.samples import SAMPLE, Recording, Samples
from sar_tui.motion.trajectories import simulate_reaches

RATE_HZ = 100.0
HOURS, FEW_HOURS = (1.0, 4.0), (1.0, 2.0)
MOST_ANALYSE_MS = 3.0
MOST_HOUR_S = 5.0
MOST_MEMORY_RATIO = 1.25
_REPEATED = 20
_DETECT = """
import json, resource, sys, time
import numpy as np
from sar_tui.motion.detection import detect_long

pattern, rounds = np.load(sys.argv[1]), int(sys.argv[2])
lasts_ns = int(pattern["at"][-1] - pattern["at"][0]) + 10_000_000

def blocks():
    for number in range(rounds):
        block = pattern.copy()
        block["at"] += number * lasts_ns
        yield block

began = time.process_time()
found = detect_long(blocks(), sys.argv[3])
units_per_mb = 1024 if sys.platform == "linux" else 2**20
memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / units_per_mb
print(json.dumps([time.process_time() - began, len(found.reaches), memory]))
"""


def measure(quick: bool, folder: Path, measured: Callable[[], None]) -> dict[str, Any]:
    """Measure windows of all kinds of reach, and recordings of an hour and of several, by each
    detector.
    """
    seeds = 1 if quick else 5
    windows = [
        as_samples(simulate_reaches(kind, seed).recording)
        for kind in KINDS
        for seed in range(seeds)
    ]
    analyses = [_analysis_ms(samples) for samples in windows]
    measured()
    bare = [_bare_ms(samples) for samples in windows]
    measured()
    pattern = folder / "reaches.npy"
    np.save(pattern, as_samples(simulate_reaches("lift-extend-touch", 5, count=6).recording))
    runs: list[dict[str, Any]] = []
    for detector in _detectors(quick):
        for hours in FEW_HOURS if quick else HOURS:
            runs.append({"detector": detector, "hours": hours} | _detect(pattern, hours, detector))
            measured()
    analyse_ms, bare_ms = statistics.median(analyses), statistics.median(bare)
    short, long = (run for run in runs if run["detector"] == "orientation")
    return {
        "samples": statistics.median(map(len, windows)),
        "analyse_ms": analyse_ms,
        "bare_ms": bare_ms,
        "ratio": analyse_ms / bare_ms,
        "runs": runs,
        "checks": {
            f"motion: a reach is analysed in at most {MOST_ANALYSE_MS:g} ms": analyse_ms
            <= MOST_ANALYSE_MS,
            f"motion: reaches of an hour are found in at most {MOST_HOUR_S:g} s": short["cpu_s"]
            <= MOST_HOUR_S,
            f"motion: memory of {long['hours']:g} hours at most {MOST_MEMORY_RATIO} x that of "
            "one": (long["memory_mb"] <= MOST_MEMORY_RATIO * short["memory_mb"]),
        },
    }


def steps(quick: bool) -> int:
    """Return the number of calls of ``measured``."""
    return 2 + 2 * len(_detectors(quick))


def _detectors(quick: bool) -> list[DetectorName]:
    return ["orientation"] if quick else list(COLUMN_NAMES)


def as_samples(recording: Recording) -> Samples:
    """Return a recording as samples of a sensor."""
    samples = np.zeros(len(recording.time_s), dtype=SAMPLE)
    samples["at"] = 1_000_000_000 + np.round(recording.time_s * 1e9).astype(np.int64)
    samples["rate"] = recording.rate
    samples["acceleration"] = np.nan if recording.acceleration is None else recording.acceleration
    samples["field"] = np.nan
    return samples


def _analysis_ms(samples: Samples) -> float:
    first, last = samples["at"][[0, -1]].tolist()
    window = Window(from_ns=first, started_ns=first + 1_500_000_000, to_ns=last + 1)
    parameters = AnalysisParameters()
    return _median_ms(lambda: analyse(samples, window, parameters))


def _bare_ms(samples: Samples) -> float:
    rate = samples["rate"].astype(float)

    def transform() -> None:
        for _ in range(3):
            np.fft.irfft(np.fft.rfft(rate, 2048, axis=0), axis=0)

    return _median_ms(transform)


def _median_ms(call: Callable[[], object]) -> float:
    call()
    times = []
    for _ in range(_REPEATED):
        began = time.process_time_ns()
        call()
        times.append(time.process_time_ns() - began)
    return statistics.median(times) / 1e6


def _detect(pattern: Path, hours: float, detector: str) -> dict[str, Any]:
    at = np.load(pattern)["at"]
    rounds = round(hours * 3600e9 / (int(at[-1] - at[0]) + 1e7))
    words = [sys.executable, "-c", _DETECT, str(pattern), str(rounds), detector]
    found = subprocess.run(words, check=True, capture_output=True, text=True)
    cpu_s, reaches, memory_mb = json.loads(found.stdout)
    return {"true": 6 * rounds, "reaches": reaches, "cpu_s": cpu_s, "memory_mb": memory_mb}

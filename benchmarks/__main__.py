"""Measure everything, print it, and keep it in ``benchmarks/results/``. Exits with 1 if a check fails."""

import argparse
import json
import re
import sys
import tempfile
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import Progress

from benchmarks import agent, paint, report, response, scale, sensor

RESULTS = Path(__file__).parent / "results"


def main() -> int:
    """Run the benchmarks; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer of everything; nothing is kept")
    parser.add_argument("--trials", type=int, help="reaction times for each program")
    given = parser.parse_args()
    trials = given.trials or (50 if given.quick else 300)
    starts, attempts, stops = (3, 10, 5) if given.quick else (10, 50, 25)
    console = Console()
    root = RESULTS.parent.parent / "build"
    root.mkdir(exist_ok=True)
    now = datetime.now(UTC)
    results: dict[str, Any] = {"measured_at": now.isoformat(), "machine": report.machine()}
    # The bar is drawn only when told to: a thread that draws it would disturb what is measured.
    with (
        tempfile.TemporaryDirectory(dir=root) as folder,
        Progress(console=console, transient=True, auto_refresh=False) as bar,
    ):
        place = Path(folder)

        def progress(what: str, total: int) -> Callable[[], None]:
            task = bar.add_task(what, total=total)
            return lambda: bar.update(task, advance=1, refresh=True)

        pressed = progress("reaction times", trials * len(response.PROGRAMS))
        started = progress("first paint", 2 * (starts + 1))
        simulated = progress("simulated attempts", attempts)
        streamed = progress("seconds of a sensor's stream", sensor.total_seconds(given.quick))
        stopped = progress("stops of the agent", stops)
        spoken = progress("reaction times beside the agent", 2 * trials)
        results["response"] = response.measure(trials, place, lambda name: pressed())
        results["paint"] = paint.measure(starts, place, started)
        results["scale"] = scale.measure(attempts, place, simulated)
        results["sensor"] = sensor.measure(given.quick, place, streamed)
        results["agent"] = agent.measure(stops, trials, place, stopped, spoken)
    for title, rows in report.tables(results).items():
        console.print(report.drawn(title, rows))
    if not given.quick:
        console.print(f"Kept in benchmarks/results/{_keep(results, now)}.")
    return 0 if all(report.checks(results).values()) else 1


def _keep(results: report.Results, now: datetime) -> str:
    """Write the figures and the page; returns the file's name."""
    own = results["machine"]
    named = re.sub(r"[^a-z0-9]+", "-", f"{own['system']} {own['architecture']} {own['cores']} cores".lower())
    name = f"{now:%Y-%m-%d}-{named}.json"
    RESULTS.mkdir(exist_ok=True)
    (RESULTS / name).write_text(json.dumps(results, indent=1) + "\n")
    (RESULTS / "latest.md").write_text(report.page(results))
    return name


if __name__ == "__main__":
    sys.exit(main())

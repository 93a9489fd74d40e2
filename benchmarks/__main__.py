"""Run the benchmarks, print the results, and store them in ``benchmarks/results/``. Exit with 1 if a check fails."""

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

from benchmarks import agent, commands, many_sessions, operator, paint, report, response, sensor, simulate

PARTS = ("response", "paint", "commands", "simulate", "sessions", "sensor", "agent", "operator")
RESULTS = Path(__file__).parent / "results"


def main() -> int:
    """Run the benchmarks, and return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument(
        "parts", nargs="*", metavar="PART", help=f"measure only these, and store nothing: {', '.join(PARTS)}"
    )
    parser.add_argument("--quick", action="store_true", help="fewer of everything; store nothing")
    parser.add_argument("--trials", type=int, help="number of reaction times for each program")
    given = parser.parse_args()
    if unknown := set(given.parts) - set(PARTS):
        parser.error(f"there is no part {', '.join(sorted(unknown))}; there is: {', '.join(PARTS)}")
    parts = given.parts or PARTS
    trials = given.trials or (50 if given.quick else 300)
    starts, stops, acts = (3, 5, 10) if given.quick else (10, 25, 200)
    console = Console()
    root = RESULTS.parent.parent / "build"
    root.mkdir(exist_ok=True)
    now = datetime.now(UTC)
    results: dict[str, Any] = {"measured_at": now.isoformat(), "machine": report.machine()}
    # The bar is redrawn by hand: a drawing thread would disturb the measurement.
    with (
        tempfile.TemporaryDirectory(dir=root) as folder,
        Progress(console=console, transient=True, auto_refresh=False) as bar,
    ):
        place = Path(folder)

        def progress(what: str, total: int) -> Callable[[], None]:
            task = bar.add_task(what, total=total)
            return lambda: bar.update(task, advance=1, refresh=True)

        if "response" in parts:
            pressed = progress("reaction times", trials * len(response.PROGRAMS))
            results["response"] = response.measure(trials, place, lambda name: pressed())
        if "paint" in parts:
            results["paint"] = paint.measure(starts, place, progress("first paint", 2 * (starts + 1)))
        if "commands" in parts:
            ended = progress("commands", len(commands.PROGRAMS) * (starts + 1))
            results["commands"] = commands.measure(starts, place, ended)
        if "simulate" in parts:
            simulated = progress("simulated sessions", simulate.total_sessions(given.quick))
            results["simulate"] = simulate.measure(given.quick, place, simulated)
        if "sessions" in parts:
            many, long = (100, 2000) if given.quick else (many_sessions.MANY, 20_000)
            listed = progress("lists of sessions", many_sessions.REPEATED)
            results["sessions"] = many_sessions.measure(many, long, place, listed)
        if "sensor" in parts:
            streamed = progress("seconds of a sensor's stream", sensor.total_seconds(given.quick))
            results["sensor"] = sensor.measure(given.quick, place, streamed)
        if "agent" in parts:
            stopped = progress("stops of the agent", stops)
            spoken = progress("reaction times beside the agent", 2 * trials)
            results["agent"] = agent.measure(stops, trials, place, stopped, spoken)
        if "operator" in parts:
            acted = progress("keys of an operator", 2 * acts)
            attended = progress("reaction times beside an operator", 2 * trials)
            results["operator"] = operator.measure(acts, trials, place, acted, attended)
    for title, rows in report.tables(results).items():
        console.print(report.drawn(title, rows))
    if not given.quick and not given.parts:
        console.print(f"Stored in benchmarks/results/{_keep(results, now)}.")
    return 0 if all(report.checks(results).values()) else 1


def _keep(results: report.Results, now: datetime) -> str:
    """Write the results and the page, and return the file's name."""
    own = results["machine"]
    named = re.sub(r"[^a-z0-9]+", "-", f"{own['system']} {own['architecture']} {own['cores']} cores".lower())
    name = f"{now:%Y-%m-%d}-{named}.json"
    RESULTS.mkdir(exist_ok=True)
    (RESULTS / name).write_text(json.dumps(results, indent=1) + "\n")
    (RESULTS / "latest.md").write_text(report.page(results))
    return name


if __name__ == "__main__":
    sys.exit(main())

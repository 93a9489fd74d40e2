"""Run the benchmarks, print each part's tables as soon as it is measured, and store all of them in
``benchmarks/results/``. Exit with 1 if a check fails.
"""

import argparse
import compileall
import json
import re
import sys
import tempfile
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import Progress

from benchmarks import report
from benchmarks.parts import PARTS, Extent

RESULTS = Path(__file__).parent / "results"


def main() -> int:
    """Run the benchmarks, and return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument(
        "parts",
        nargs="*",
        metavar="PART",
        help=f"measure only these, and store nothing: {', '.join(PARTS)}",
    )
    parser.add_argument("--quick", action="store_true", help="fewer of everything; store nothing")
    parser.add_argument("--trials", type=int, help="number of reaction times for each program")
    parser.add_argument("--minutes", type=float, help="duration of the part sensors")
    given = parser.parse_args()
    if unknown := set(given.parts) - set(PARTS):
        parser.error(f"there is no part {', '.join(sorted(unknown))}; there is: {', '.join(PARTS)}")
    parts = given.parts or PARTS
    failed: dict[str, str] = {}
    console = Console()
    checkout = RESULTS.parent.parent
    # pip compiles what it installs, except from a checkout
    for code in (
        "sar_tui",
        "tasks",
        "themes",
        "benchmarks",
    ):
        compileall.compile_dir(checkout / code, quiet=1)
    root = checkout / "build"
    root.mkdir(exist_ok=True)
    now = datetime.now(UTC)
    results: dict[str, Any] = {"measured_at": now.isoformat(), "machine": report.machine()}
    # The bar is redrawn by hand: a drawing thread would disturb the measurement.
    with (
        tempfile.TemporaryDirectory(dir=root) as folder,
        Progress(console=console, transient=True, auto_refresh=False) as bar,
    ):

        def progress(what: str, total: int) -> Callable[[], None]:
            task = bar.add_task(what, total=total)
            return lambda: bar.update(task, advance=1, refresh=True)

        extent = Extent(Path(folder), progress, given.quick, given.trials, given.minutes)
        for part in parts:
            began = time.monotonic()
            try:
                results[part] = PARTS[part](extent)
            except Exception as error:  # the others are measured, and kept, all the same
                failed[part] = f"{type(error).__name__}: {error}"
                continue
            for title, rows in report.tables({part: results[part]}).items():
                console.print(report.drawn(title, rows))
            console.print(f"{part} took {time.monotonic() - began:.0f} s.\n", highlight=False)
    for part, why in failed.items():
        console.print(f"{part} was not measured. {why}", markup=False)
    text = json.dumps(results, indent=1, default=lambda value: value.item())  # of numpy
    if not given.quick and not given.parts:
        console.print(f"Stored in benchmarks/results/{_keep(results, text, now)}.")
    return 0 if all(report.checks(results).values()) and not failed else 1


def _keep(results: report.Results, text: str, now: datetime) -> str:
    """Write the results, with their JSON, and the page; return the file's name."""
    own = results["machine"]
    named = re.sub(
        r"[^a-z0-9]+", "-", f"{own['system']} {own['architecture']} {own['cores']} cores".lower()
    )
    name = f"{now:%Y-%m-%d}-{named}.json"
    RESULTS.mkdir(exist_ok=True)
    (RESULTS / name).write_text(f"{text}\n")
    (RESULTS / "latest.md").write_text(report.page(results))
    return name


if __name__ == "__main__":
    sys.exit(main())

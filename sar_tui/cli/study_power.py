"""``sar-tui study power``: how many people a planned study needs."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sar_tui.cli.common import AsJson, Home, console, named_path, print_json
from sar_tui.cli.errors import Refused
from sar_tui.cli.progress_line import progress_line

if TYPE_CHECKING:
    from sar_tui.study.outcome import Assumptions, Baseline, Number, Outcome, Power
    from sar_tui.study.pilot import Pilot
    from sar_tui.study.power import Compute, Curve, Estimate

_WIDTH, _HEIGHT = 76, 16
_NUMBERS = {
    "mean": "mean",
    "person_sd": "SD between people",
    "session_sd": "SD of a person's sessions",
    "trial_sd": "SD of trials",
    "trials": "trials in a session",
    "within_sd": "SD within a person",
    "baseline_trials": "trials in a baseline",
    "baseline_sd": "SD of a person's baselines",
    "retest": "correlation of two visits",
    "dropout": "share of people lost",
    "effect": "effect",
    "effect_d": "effect, d",
    "effect_dz": "effect, dz",
}
_IN_UNIT = ("mean", "person_sd", "session_sd", "trial_sd", "within_sd", "baseline_sd", "effect")
_DESIGNS = {
    "within": "conditions of one person, paired t-test",
    "groups": "two groups, t-test",
    "groups, baseline": "two groups, regression on baseline and group (ANCOVA)",
}


def power(
    home: Home,
    file: Annotated[
        Path,
        typer.Argument(
            parser=named_path,
            metavar="FILE.toml",
            show_default=False,
            help="The plan, with [outcome] and [power].",
        ),
    ],
    draws: Annotated[
        int,
        typer.Option(metavar="N", min=1000, max=1_000_000, help="Simulated studies for each size."),
    ] = 10_000,
    seed: Annotated[
        int, typer.Option(metavar="N", min=0, max=2**63 - 1, help="Seed of all randomness.")
    ] = 1,
    processes: Annotated[
        int | None,
        typer.Option(
            metavar="N", min=1, show_default=False, help="Processes. Default: one for each core."
        ),
    ] = None,
    on: Annotated[
        str | None,
        typer.Option(
            metavar="tcp://HOST:PORT",
            show_default=False,
            help="Compute on the workers of this Dask scheduler.",
        ),
    ] = None,
    from_pilot: Annotated[
        Path | None,
        typer.Option(
            parser=named_path,
            metavar="DIR",
            show_default=False,
            help="Estimate the standard deviations from the sessions in this data folder.",
        ),
    ] = None,
    simulated: Annotated[
        bool, typer.Option("--simulated", help="With --from-pilot: from simulated sessions.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Simulate a planned study with several numbers of people, and say how many it needs.

    All tests are two-sided, at .05. The same seed gives the same numbers anywhere.
    """
    from sar_tui.study.outcome import assumptions, read_outcome, read_power
    from sar_tui.study.power import power_curve

    plan = _plan(file)
    outcome = read_outcome(plan)
    stated = read_power(plan, outcome)
    pilot = _pilot(from_pilot, plan, outcome, stated, simulated) if from_pilot else None
    planned, at_baseline = (
        _planned_trials(home, file, place) for place in (outcome, outcome.baseline)
    )
    assumed = assumptions(stated, outcome, pilot.numbers if pilot else None, planned, at_baseline)
    with _where(on, processes) as compute, progress_line("Simulating") as show:
        curve = power_curve(
            assumed.model,
            stated.sizes,
            wanted=stated.wanted,
            draws=draws,
            seed=seed,
            compute=compute,
            progress=lambda size: show(f"Simulating {size} people", 0, 0),
        )
    sentences = _sentences(assumed, curve, stated)
    if as_json:
        print_json(
            {
                "outcome": outcome,
                "unit": assumed.unit,
                "numbers": assumed.numbers,
                "model": assumed.model._asdict(),
                "wanted": stated.wanted,
                "alpha": 0.05,
                "seed": seed,
                "pilot": pilot,
                "estimates": curve.estimates,
                "smallest": curve.smallest,
                "sentences": sentences,
            }
        )
        return
    _print(assumed, outcome, stated, curve, pilot)
    console().print(" ".join(sentences), soft_wrap=True)


def _plan(file: Path) -> dict[str, Any]:
    """Return the content of a plan. Raises Refused."""
    from sar_tui.model.toml_lines import TomlError, decode

    try:
        return decode(file.read_bytes().decode())
    except OSError as error:
        raise Refused(f"{file} cannot be read: {error.strerror}.") from error
    except UnicodeDecodeError:
        raise Refused(f"{file} is not a text in UTF-8.") from None
    except TomlError as error:
        raise Refused(f"{file}, {error}") from error


def _planned_trials(home: Home, file: Path, place: "Outcome | Baseline | None") -> "Number | None":
    """Return the number of trials in the block of the outcome or the baseline; None without it, or
    if the plan is unfinished.
    """
    from sar_tui.plugins import PluginError
    from sar_tui.rules.declaration import ParameterError
    from sar_tui.runs.plan import Failed
    from sar_tui.study.conditions import trials_of
    from sar_tui.study.plan import PlanError, parse_plan, read_plan

    if place is None:
        return None
    try:
        return trials_of(parse_plan(read_plan(file), str(file)), home.catalogue(), place)
    except (PlanError, PluginError, ParameterError, Failed):
        return None


def _pilot(
    folder: Path, plan: dict[str, Any], outcome: "Outcome", stated: "Power", simulated: bool
) -> "Pilot":
    """Return the numbers of a pilot study. Raises Refused, StoreError."""
    from contextlib import closing

    from sar_tui.store.database import connect_unchanged
    from sar_tui.study.outcome import tasks_of
    from sar_tui.study.pilot import from_pilot

    tasks = tasks_of(plan, outcome)
    if not tasks and not outcome.is_form:
        raise Refused(
            f"The plan names no task for the block {outcome.block} of the visit {outcome.visit}, so "
            "that it is not known which sessions of the pilot study to look at."
        )
    with closing(connect_unchanged(folder)) as database:
        return from_pilot(database, tasks, outcome, stated.unit, simulated=simulated)


@contextmanager
def _where(address: str | None, processes: int | None) -> "Iterator[Compute]":
    """Give what runs the simulation. Raises Refused, Failed."""
    from sar_tui.study.power import cores, on_cores

    if address is None:
        with on_cores(processes or cores()) as compute:
            yield compute
        return
    if processes is not None:
        raise Refused("Give --processes or --on, not both: a cluster has its own.")
    from sar_tui.study.cluster import ClusterRefused, on_cluster

    try:
        with on_cluster(address) as compute:
            yield compute
    except ClusterRefused as error:
        raise Refused(str(error)) from None


def _print(
    assumed: "Assumptions",
    outcome: "Outcome",
    stated: "Power",
    curve: "Curve",
    pilot: "Pilot | None",
) -> None:
    from sar_tui.cli.tables import add, table
    from sar_tui.reports.charts import curve as drawn_curve

    out = console()
    where = ", ".join(filter(None, (outcome.block, outcome.visit)))
    out.print(f"{outcome.measure} ({where}): {_DESIGNS[outcome.compared]}, two-sided at .05.")
    out.print()
    shown = table("assumption", "value", "source", right=("value",), whole=("assumption", "value"))
    for name, number in assumed.numbers.items():
        unit = f" {assumed.unit}" if name in _IN_UNIT and assumed.unit else ""
        add(shown, _NUMBERS[name], f"{number.value:.4g}{unit}", number.source)
    out.print(shown)
    if pilot:
        out.print()
        out.print(pilot.sentence, soft_wrap=True)
    out.print()
    in_groups = outcome.compared != "within"
    heads = ("people", *(("in each group",) if in_groups else ()), "power", "95 % interval")
    shown = table(*heads, right=heads)
    for each in curve.estimates:
        add(shown, f"{each.size:,}", *((_halves(each.size),) if in_groups else ()), *_cells(each))
    out.print(shown)
    if len(curve.estimates) > 1:
        out.print()
        sizes = [float(each.size) for each in curve.estimates]
        powers = [100 * each.power for each in curve.estimates]
        out.print(f"power, %, over people; ╌ {100 * stated.wanted:g} %")
        width = min(out.width, _WIDTH)
        lines = drawn_curve(
            sizes, powers, width, _HEIGHT, axis=(0.0, 100.0), rule=100 * stated.wanted
        )
        out.print("\n".join(lines))
    out.print()


def _cells(estimate: "Estimate") -> tuple[str, str]:
    return f"{100 * estimate.power:.1f} %", _interval(estimate)


def _interval(estimate: "Estimate") -> str:
    return f"{100 * estimate.low:.1f} to {100 * estimate.high:.1f} %"


def _halves(size: int) -> str:
    return f"{size // 2:,}" if size % 2 == 0 else f"{size - size // 2:,} and {size // 2:,}"


def _sentences(assumed: "Assumptions", curve: "Curve", stated: "Power") -> list[str]:
    """Return what the smallest size finds; if none reaches the wanted power, what the largest
    does.
    """
    from sar_tui.study.outcome import LARGEST

    shown = curve.smallest or curve.estimates[-1]
    groups = "" if assumed.model.design == "within" else f" ({_halves(shown.size)} in each group)"
    found = (
        f"With {shown.size:,} people{groups} the study finds an effect of {assumed.effect} in "
        f"{100 * shown.power:.1f} % ({_interval(shown)}) of {shown.draws:,} simulated studies."
    )
    wanted = f"{100 * stated.wanted:g} %"
    if curve.smallest:
        return [found, f"It is the smallest number of people that reaches {wanted}."]
    return [found, f"Even {LARGEST:,} people find it in less than {wanted}."]

"""Published effects of the tasks, in sessions of simulated participants, and in controls who do not
show them.
"""

from collections.abc import Iterator
from functools import partial
from statistics import fmean, stdev
from typing import NamedTuple

from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.session import Session
from sar_tui.loop.task import Task
from sar_tui.loop.topics import STORED, TRIAL
from sar_tui.model.messages import Stored, TrialEnded
from sar_tui.model.theme import Theme
from sar_tui.plugins import Catalogue, PluginError, module_beside
from sar_tui.rules.parameters import build
from sar_tui.runs.sensors import simulated_nodes
from sar_tui.runs.simulate import participant_fault
from sar_tui.simulation.participant import SimulatedParticipant
from sar_tui.simulation.participant_model import PEOPLE, Effect, Rehearsal
from sar_tui.validation.report import Claim, Column, Conditions, Report, Row

SESSIONS, QUICK_SESSIONS = 200, 16
PERSON = "average"


class Shown(NamedTuple):
    """An effect in some sessions: its mean, and the standard deviation between sessions."""

    mean: float
    sd: float


def run(conditions: Conditions) -> Report:
    """Return one row for each task that declares an effect."""
    declared = dict(effects(conditions.catalogue))
    rows: list[Row] = []
    for number, (kind, effect) in enumerate(declared.items()):
        conditions.progress(f"effects: {kind.name}", number, len(declared))
        rows.append(_row(conditions, kind, effect))
    claims = [
        Claim(
            "Simulated people show each task's effect within its published range.",
            ", ".join(row["task"] for row in rows if not row["low"] <= row["mean"] <= row["high"]),
        ),
        Claim(
            "Simulated people without the effect are told from them: their mean lies outside of "
            "that range.",
            ", ".join(
                row["task"] for row in rows if row["low"] <= row["control_mean"] <= row["high"]
            ),
        ),
    ]
    return Report(rows, [_COLUMNS], claims)


def effects(catalogue: Catalogue) -> Iterator[tuple[type[Task], Effect]]:
    """Yield the tasks that declare an effect, and the effect. Raises PluginError if one cannot be
    loaded.
    """
    for name in catalogue.task_names():
        kind = catalogue.task(name)
        if module := module_beside(kind, "effect"):
            effect = getattr(module, "EFFECT", None)
            if not isinstance(effect, Effect):
                raise PluginError(
                    f"The effect.py of the task {name} must define EFFECT, an Effect."
                )
            yield kind, effect


def _row(conditions: Conditions, kind: type[Task], effect: Effect) -> Row:
    count = QUICK_SESSIONS if conditions.is_quick else SESSIONS
    theme = conditions.catalogue.theme("calm")
    found = _shown(kind, effect, theme, count)
    control = _shown(kind, effect, theme, count, effect.without)
    return {
        "task": kind.name,
        "effect": effect.title,
        "unit": effect.unit,
        "low": effect.low,
        "high": effect.high,
        "sessions": count,
        "mean": found.mean,
        "sd": found.sd,
        "control_mean": control.mean,
        "control_sd": control.sd,
        "source": effect.source,
    }


def _shown(
    kind: type[Task],
    effect: Effect,
    theme: Theme,
    count: int,
    rehearsal: Rehearsal | None = None,
) -> Shown:
    played = (play(kind, effect, theme, seed, rehearsal) for seed in range(1, count + 1))
    values = [value for trials in played if (value := effect.measure(trials)) is not None]
    return Shown(fmean(values), stdev(values))


def play(
    kind: type[Task],
    effect: Effect,
    theme: Theme,
    seed: int,
    rehearsal: Rehearsal | None = None,
) -> list[TrialEnded]:
    """Return the trials of a session of an average person, which is not stored.

    Args:
        kind, effect: the task and its effect, which has the settings.
        theme, seed: of the session.
        rehearsal: takes the place of the task's own `Task.rehearse`.
    """
    task = kind(build(kind.Parameters, effect.settings))
    if rehearsal:
        vars(task)["rehearse"] = partial(rehearsal, task)
    clock = VirtualClock()
    person = PEOPLE[PERSON]
    if task.sensor_seats(task.parameters):
        nodes = simulated_nodes(person, task, seed, clock, person)
    else:
        nodes = [SimulatedParticipant(person, task, seed)]
    session = Session(task, theme, clock, seed, nodes)
    trials: list[TrialEnded] = []

    def keep(trial: TrialEnded) -> None:
        trials.append(trial)
        session.bus.post(STORED, Stored(seat=trial.seat, attempt=trial.attempt, trial=trial.trial))

    session.bus.subscribe(TRIAL, keep)
    session.begin()
    while not session.ended and session.broken is None and clock.step():
        pass
    if fault := session.broken or participant_fault(session):
        raise PluginError(f"The task {kind.name} failed ({fault.error}, {fault.place}).")
    return trials


def _value(name: str) -> Column:
    return Column(name.replace("_", " "), lambda row: f"{row[name]:.1f}")


_COLUMNS = [
    Column("task", lambda row: row["task"], is_number=False),
    Column("effect", lambda row: f"{row['effect']} ({row['unit']})", is_number=False),
    Column("published", lambda row: f"{row['low']:g} to {row['high']:g}"),
    _value("mean"),
    _value("sd"),
    Column("without it", lambda row: f"{row['control_mean']:.1f}"),
    Column("source", lambda row: row["source"], is_number=False),
]

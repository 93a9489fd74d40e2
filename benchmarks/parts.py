"""The parts of the benchmarks, each with its extent."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks import (
    agent,
    commands,
    dial_out,
    export,
    flood,
    frames,
    many_sessions,
    measures,
    merge,
    motion,
    operator,
    paint,
    reaches,
    response,
    robots,
    sensor,
    sensors,
    simulate,
)


class Extent(NamedTuple):
    """Extent and place of a measurement.

    Attributes:
        folder: an empty folder on the disk to write to.
        progress: shows what is measured and its total, and returns a function that is called after
            each step.
        quick: measure fewer of everything.
        asked_trials: the number of reaction times of each program that somebody asked for.
        asked_minutes: the duration of streams over a line or a network that somebody asked for.
    """

    folder: Path
    progress: Callable[[str, int], Callable[[], None]]
    quick: bool
    asked_trials: int | None = None
    asked_minutes: float | None = None

    @property
    def trials(self) -> int:
        """The number of reaction times of each program."""
        return self.asked_trials or (50 if self.quick else 300)


def _response(extent: Extent) -> Any:
    pressed = extent.progress("reaction times", extent.trials * len(response.PROGRAMS))
    return response.measure(extent.trials, extent.folder, lambda name: pressed())


def _frames(extent: Extent) -> Any:
    attempts = 1 if extent.quick else 10
    return frames.measure(
        attempts, extent.folder, extent.progress("prompts of frames", frames.steps(attempts))
    )


def _paint(extent: Extent) -> Any:
    starts = 3 if extent.quick else 10
    return paint.measure(starts, extent.folder, extent.progress("first paint", 2 * (starts + 1)))


def _commands(extent: Extent) -> Any:
    starts = 3 if extent.quick else 10
    ended = extent.progress("commands", len(commands.PROGRAMS) * (starts + 1))
    return commands.measure(starts, extent.folder, ended)


def _flood(extent: Extent) -> Any:
    return flood.measure(extent.folder, extent.progress("floods of input", len(flood.UNITS)))


def _simulate(extent: Extent) -> Any:
    simulated = extent.progress("simulated sessions", simulate.total_sessions(extent.quick))
    return simulate.measure(extent.quick, extent.folder, simulated)


def _sessions(extent: Extent) -> Any:
    many, long = (100, 2000) if extent.quick else (many_sessions.MANY, 20_000)
    listed = extent.progress("lists of sessions", many_sessions.REPEATED)
    return many_sessions.measure(many, long, extent.folder, listed)


def _sensor(extent: Extent) -> Any:
    streamed = extent.progress("seconds of a sensor's stream", sensor.total_seconds(extent.quick))
    return sensor.measure(extent.quick, extent.folder, streamed)


def _sensors(extent: Extent) -> Any:
    duration_s = sensors.seconds(extent.asked_minutes, extent.quick)
    passed = extent.progress("seconds of four sensors", round(sensors.RUN_IN_S + duration_s))
    return sensors.measure(duration_s, extent.folder, passed)


def _agent(extent: Extent) -> Any:
    stops = 5 if extent.quick else 25
    stopped = extent.progress("stops of the agent", stops)
    spoken = extent.progress("reaction times beside the agent", 2 * extent.trials)
    return agent.measure(stops, extent.trials, extent.folder, stopped, spoken)


def _robots(extent: Extent) -> Any:
    repeats = 2 if extent.quick else 20
    tried = extent.progress("stops of robots", robots.names() * repeats)
    return robots.measure(repeats, tried)


def _operator(extent: Extent) -> Any:
    acts = 10 if extent.quick else 200
    acted = extent.progress("keys of an operator", 2 * acts)
    attended = extent.progress("reaction times beside an operator", 2 * extent.trials)
    return operator.measure(acts, extent.trials, extent.folder, acted, attended)


def _dial_out(extent: Extent) -> Any:
    lines, acts = (dial_out.LINES[:1], 3) if extent.quick else (dial_out.LINES, 40)
    trials = extent.asked_trials or min(extent.trials, 100)
    acted = extent.progress("acts of a visitor", acts * len(lines))
    visited = extent.progress("reaction times beside a visitor", (1 + len(lines)) * trials)
    return dial_out.measure(lines, acts, trials, extent.folder, acted, visited)


def _export(extent: Extent) -> Any:
    trials, samples = (20_000, 50_000) if extent.quick else (1_000_000, 3_600_000)
    return export.measure(
        trials, samples, extent.folder, extent.progress("exports", export.steps())
    )


def _merge(extent: Extent) -> Any:
    few, many = (5, 50) if extent.quick else (100, 1000)
    return merge.measure(few, many, extent.folder, extent.progress("merges", merge.steps()))


def _motion(extent: Extent) -> Any:
    return motion.measure(
        extent.quick,
        extent.folder,
        extent.progress("reaches in samples", motion.steps(extent.quick)),
    )


def _reaches(extent: Extent) -> Any:
    return reaches.measure(
        extent.quick, extent.progress("recordings of people", reaches.steps(extent.quick))
    )


def _measures(extent: Extent) -> Any:
    return measures.measure(
        extent.quick, extent.progress("movement measures", measures.steps(extent.quick))
    )


PARTS: Mapping[str, Callable[[Extent], Any]] = {
    "response": _response,
    "frames": _frames,
    "paint": _paint,
    "commands": _commands,
    "flood": _flood,
    "simulate": _simulate,
    "sessions": _sessions,
    "export": _export,
    "merge": _merge,
    "motion": _motion,
    "reaches": _reaches,
    "measures": _measures,
    "sensor": _sensor,
    "sensors": _sensors,
    "agent": _agent,
    "robots": _robots,
    "operator": _operator,
    "dial_out": _dial_out,
}
"""Each part by its name: measures it, and returns its figures."""

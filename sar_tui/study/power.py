"""Power of a study by simulation: how often a stated effect is found, and with how many people.

Studies are drawn in chunks, each from a random stream of its own (`numpy.random.SeedSequence`), so
that the result is the same in whatever process, order or place chunks run.
"""

import math
import os
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from statistics import NormalDist
from typing import NamedTuple

import msgspec
import numpy as np
import numpy.typing as npt

from sar_tui.rules.student import t95
from sar_tui.study.outcome import LARGEST, Model, least_size

DRAWS = 10_000
"""Simulated studies for each size."""
CHUNK = 1000
"""Simulated studies with one random stream."""
_CELLS = 100_000
"""People whose numbers are drawn at once, so that they stay in the processor's cache."""

Floats = npt.NDArray[np.float64]
Counts = npt.NDArray[np.int64]


class Chunk(NamedTuple):
    """A number of simulated studies of one size.

    Attributes:
        model: that they are drawn from.
        size: number of people who are enrolled.
        seed: of the whole simulation.
        number: of the chunk, from 0.
        draws: number of studies.
    """

    model: Model
    size: int
    seed: int
    number: int
    draws: int


Compute = Callable[[Sequence[Chunk]], Iterable[int]]
"""Runs `found_in` on chunks, and yields their results in any order."""


class Estimate(msgspec.Struct, frozen=True):
    """The share of simulated studies that find the effect, with its 95 % interval (Wilson 1927,
    10.1080/01621459.1927.10502953).
    """

    size: int
    found: int
    draws: int
    power: float
    low: float
    high: float


class Curve(msgspec.Struct, frozen=True):
    """Power over sizes, in their order, and the smallest size that reaches the wanted power; None
    if even the largest does not.
    """

    estimates: list[Estimate]
    smallest: Estimate | None


# --- sizes


def power_curve(
    model: Model,
    sizes: Sequence[int] = (),
    *,
    wanted: float = 0.8,
    draws: int = DRAWS,
    seed: int = 1,
    compute: Compute | None = None,
    progress: Callable[[int], None] = lambda size: None,
) -> Curve:
    """Simulate a study with several sizes, and find the smallest with the wanted power.

    Args:
        model: of the outcome.
        sizes: numbers of people; if empty, some around the smallest size.
        wanted: power of the smallest size.
        draws: simulated studies for each size.
        seed: of all randomness.
        compute: where chunks run; None: here.
        progress: called with each size before it is simulated.
    """
    known: dict[int, Estimate] = {}

    def estimated(size: int) -> Estimate:
        if size not in known:
            progress(size)
            known[size] = estimate(model, size, draws=draws, seed=seed, compute=compute)
        return known[size]

    for size in sizes:
        estimated(size)
    smallest = _smallest(model, wanted, estimated)
    shown = {*sizes} or _around(model, smallest.size if smallest else LARGEST)
    if smallest:
        shown.add(smallest.size)
    return Curve([estimated(size) for size in sorted(shown)], smallest)


def _smallest(model: Model, wanted: float, estimated: Callable[[int], Estimate]) -> Estimate | None:
    """Return the smallest size whose simulated power is the wanted one, by bisection around the
    size that a normal approximation gives.
    """
    step = _step(model)
    least, most = math.ceil(least_size(model.design) / step), LARGEST // step
    guess = min(max(least, round(_approximate(model, wanted) / step)), most)
    high, reach = guess, 1
    while estimated(high * step).power < wanted:
        if high == most:
            return None
        high, reach = min(most, high + reach), 2 * reach
    low, reach = min(high, guess) - 1, 1
    while low >= least and estimated(low * step).power >= wanted:
        high, low, reach = low, low - reach, 2 * reach
    low = max(low, least - 1)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if estimated(middle * step).power >= wanted else (middle, high)
    return estimated(high * step)


def _step(model: Model) -> int:
    """Return the number of people by which a study with groups of one size can grow."""
    return 1 if model.design == "within" else 2


def _approximate(model: Model, wanted: float) -> float:
    """Return the size by the normal approximation."""
    normal = NormalDist()
    z = normal.inv_cdf(0.975) + normal.inv_cdf(wanted)
    match model.design:
        case "within":
            needed = (z * model.difference_sd / model.effect) ** 2
        case "groups":
            needed = 4 * (z * model.total_sd / model.effect) ** 2
        case _:
            unexplained = 1 - model.retest**2
            needed = 4 * unexplained * (z * model.total_sd / model.effect) ** 2
    return min(needed / (1 - model.dropout), LARGEST)


def _around(model: Model, size: int) -> set[int]:
    """Return sizes from a half to twice a size."""
    step, least = _step(model), least_size(model.design)
    shares = (0.4, 0.6, 0.8, 1.0, 1.2, 1.5, 2.0)
    return {min(LARGEST, max(least, step * round(share * size / step))) for share in shares}


# --- studies of one size


def estimate(
    model: Model,
    size: int,
    *,
    draws: int = DRAWS,
    seed: int = 1,
    compute: Compute | None = None,
) -> Estimate:
    """Simulate studies of one size."""
    chunks = [
        Chunk(model, size, seed, number, min(CHUNK, draws - number * CHUNK))
        for number in range(math.ceil(draws / CHUNK))
    ]
    found = sum((compute or in_this_process)(chunks))
    low, high = wilson(found, draws)
    return Estimate(size, found, draws, found / draws, low, high)


def in_this_process(chunks: Sequence[Chunk]) -> Iterator[int]:
    """Run chunks one after the other."""
    return map(found_in, chunks)


@contextmanager
def on_cores(processes: int) -> Iterator[Compute]:
    """Give what runs chunks in so many processes of this machine."""
    if processes == 1:
        yield in_this_process
        return
    pool = ProcessPoolExecutor(processes, get_context("spawn"), _leave_interrupts_to_parent)
    try:
        yield lambda chunks: pool.map(found_in, chunks)
    finally:
        pool.shutdown(cancel_futures=True)


def _leave_interrupts_to_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def cores() -> int:
    """Return the number of cores that this program may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def wilson(found: int, of: int) -> tuple[float, float]:
    """Return the 95 % interval of a share (Wilson 1927)."""
    z = NormalDist().inv_cdf(0.975)
    share, part = found / of, z**2 / of
    middle = share + part / 2
    half = z * math.sqrt(share * (1 - share) / of + part / (4 * of))
    low, high = (middle - half) / (1 + part), (middle + half) / (1 + part)
    return max(0.0, min(share, low)), min(1.0, max(share, high))


# --- one chunk


def found_in(chunk: Chunk) -> int:
    """Return the number of studies of a chunk whose two-sided test at .05 finds the effect.

    A study that too many people have left to be tested finds nothing.
    """
    test = {"within": _within, "groups": _groups, "groups, baseline": _groups_with_baseline}
    streams = np.random.SeedSequence(chunk.seed, spawn_key=(chunk.size, chunk.number))
    generator = np.random.default_rng(streams)
    rows = max(1, _CELLS // chunk.size)
    found = 0
    for first in range(0, chunk.draws, rows):
        t, df = test[chunk.model.design](
            chunk.model, chunk.size, min(rows, chunk.draws - first), generator
        )
        found += int(np.count_nonzero(np.abs(t) > _critical(df)))
    return found


def _critical(df: Counts) -> Floats:
    """Return the critical values of t; infinite without a degree of freedom."""
    known, place = np.unique(df, return_inverse=True)
    values = np.array([t95(int(each)) if each > 0 else math.inf for each in known])
    return values[place]


Drawn = tuple[Floats, Counts]
"""For each study: t and its degrees of freedom."""


def _within(model: Model, size: int, draws: int, generator: np.random.Generator) -> Drawn:
    """Test the mean difference of people's two conditions. What is theirs in both cancels out."""
    first, second = model.within_sd * generator.standard_normal((2, draws, size))
    difference = _Sample.of(model.effect + second - first, model.dropout, generator)
    df = difference.n - 1
    variance = difference.squares / np.maximum(df, 1)
    return _ratio(difference.mean, variance * _inverse(difference.n)), df


def _groups(model: Model, size: int, draws: int, generator: np.random.Generator) -> Drawn:
    """Test the difference of two groups with the pooled variance. The larger one of an odd number
    of people is the first.
    """
    half = size // 2
    sd = model.total_sd
    without = _Sample.of(
        sd * generator.standard_normal((draws, size - half)), model.dropout, generator
    )
    treated = _Sample.of(
        model.effect + sd * generator.standard_normal((draws, half)), model.dropout, generator
    )
    df = _degrees(without.n, treated.n, 2)
    variance = (without.squares + treated.squares) / np.maximum(df, 1)
    shares = _inverse(without.n) + _inverse(treated.n)
    return _ratio(treated.mean - without.mean, variance * shares), df


def _groups_with_baseline(
    model: Model, size: int, draws: int, generator: np.random.Generator
) -> Drawn:
    """Test the group in the least-squares regression of the outcome on baseline and group.

    Its closed form: with sums of squares and products within the groups, the slope is Sxy / Sxx, the
    residual sum of squares Syy - Sxy² / Sxx, and the variance of the adjusted difference that of the
    residuals times 1/n1 + 1/n2 + (difference of the baselines)² / Sxx.
    """
    half = size // 2
    without = _pairs(model, 0.0, (draws, size - half), generator)
    treated = _pairs(model, model.effect, (draws, half), generator)
    (x1, y1, xy1), (x2, y2, xy2) = without, treated
    df = _degrees(y1.n, y2.n, 3)
    sxx, syy, sxy = x1.squares + x2.squares, y1.squares + y2.squares, xy1 + xy2
    slope = sxy / np.where(sxx > 0, sxx, 1)
    variance = (syy - slope * sxy) / np.maximum(df, 1)
    apart = x2.mean - x1.mean
    leverage = _inverse(y1.n) + _inverse(y2.n) + apart**2 / np.where(sxx > 0, sxx, 1)
    return _ratio(y2.mean - y1.mean - slope * apart, variance * leverage), df


def _pairs(
    model: Model, effect: float, shape: tuple[int, int], generator: np.random.Generator
) -> "tuple[_Sample, _Sample, Floats]":
    """Return baselines and outcomes of a group, and the sums of their products around the means."""
    person = model.person_sd * generator.standard_normal(shape)
    x, y = generator.standard_normal((2, *shape))
    x, y = person + model.of_baseline * x, person + model.within_sd * y
    stay = _staying(shape, model.dropout, generator)
    baseline, outcome = _Sample.among(x, stay), _Sample.among(y + effect, stay)
    return baseline, outcome, np.einsum("ij,ij->i", baseline.centred, outcome.centred)


class _Sample(NamedTuple):
    """For each study: number of people, mean, deviations of people, and the sum of their squares."""

    n: Counts
    mean: Floats
    centred: Floats
    squares: Floats

    @classmethod
    def of(cls, values: Floats, dropout: float, generator: np.random.Generator) -> "_Sample":
        draws, people = values.shape
        return cls.among(values, _staying((draws, people), dropout, generator))

    @classmethod
    def among(cls, values: Floats, stay: npt.NDArray[np.bool_] | None) -> "_Sample":
        """Return the sample of those who stay; None: all."""
        draws, people = values.shape
        if stay is None:
            n = np.full(draws, people)
            mean = values.mean(axis=1)
            centred = values - mean[:, None]
        else:
            n = stay.sum(axis=1)
            mean = np.where(stay, values, 0.0).sum(axis=1) / np.maximum(n, 1)
            centred = np.where(stay, values - mean[:, None], 0.0)
        return cls(n, mean, centred, np.einsum("ij,ij->i", centred, centred))


def _staying(
    shape: tuple[int, int], dropout: float, generator: np.random.Generator
) -> npt.NDArray[np.bool_] | None:
    """Draw who is not lost, independently of all else; None if nobody is."""
    return generator.random(shape) >= dropout if dropout else None


def _degrees(n1: Counts, n2: Counts, estimated: int) -> Counts:
    """Return the degrees of freedom of two groups; 0 if one of them is empty."""
    return np.where((n1 > 0) & (n2 > 0), n1 + n2 - estimated, 0)


def _inverse(n: Counts) -> Floats:
    return 1.0 / np.maximum(n, 1)


def _ratio(difference: Floats, variance: Floats) -> Floats:
    """Return t; 0 without a variance."""
    known = np.where(variance > 0, variance, math.inf)
    return difference / np.sqrt(known)

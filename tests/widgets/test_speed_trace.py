"""Speed traces of reaches show phases, speed and time, also without colour."""

import math
from itertools import pairwise

import numpy as np
import pytest
from textual.app import App, ComposeResult

from sar_tui.motion.analysis import AnalysisParameters, Finding, Window, analyse
from sar_tui.motion.samples import SAMPLE, Samples
from sar_tui.motion.synthesis import PROFILES, TABLE_4_1, ReachShape, SimulatedHand
from sar_tui.motion.trace import MOST_POINTS, Trace, trace_of
from sar_tui.widgets.speed_trace import SpeedTrace, draw_traces

SECOND = 1_000_000_000
ONSET = 3 * SECOND
DWELLING = ReachShape(out_s=0.8, dwell_s=0.6, back_s=0.6, peak_out=1.8, peak_back=-2.4)
FAST = TABLE_4_1[6].shape
STYLES = {"out": "cyan", "dwell": "white", "back": "magenta"} | dict.fromkeys(
    ("rest", "earlier", "axis"), "dim"
)


def found(shape: ReachShape, profile: str = "noisy") -> tuple[Samples, Finding]:
    """A reach after three seconds of rest, and what the analysis makes of it."""
    hand = SimulatedHand(PROFILES[profile], seed=4)
    hand.move(ONSET, shape)
    until = ONSET + round((shape.duration_s + 2) * SECOND)
    samples = hand.samples(0, until)
    window = Window(from_ns=0, started_ns=ONSET - SECOND // 2, to_ns=until)
    return samples, analyse(samples, window, AnalysisParameters())


def trace(shape: ReachShape, profile: str = "noisy", label: str = "") -> Trace:
    samples, finding = found(shape, profile)
    made = trace_of(samples, finding.onset_ns, finding.end_ns, finding.details, label)
    assert made
    return made


def drawn(*traces: Trace, width: int = 76, height: int = 12) -> list[str]:
    return draw_traces(traces, width, height).plain.split("\n")


def steady(rate: float, label: str) -> Trace:
    times = {"onset_s": 0.1, "arrival_s": 0.4, "departure_s": 0.5, "end_s": 0.9}
    return Trace(rate=[rate] * 50, rate_hz=50.0, label=label, **times)


def dots(mark: str) -> bool:
    return "⠀" < mark <= "⣿"


# --- the curve of a reach


@pytest.mark.parametrize(
    "profile", ["clean", "noisy", "biased", "drifting", "tilted", "lossy", "patient"]
)
def test_outward_is_positive_in_any_orientation(profile: str) -> None:
    made = trace(FAST, profile)
    onset = round(made.onset_s * made.rate_hz)
    assert max(made.rate) == pytest.approx(FAST.peak_out, abs=0.35)
    assert min(made.rate) == pytest.approx(FAST.peak_back, abs=0.35)
    assert made.rate.index(max(made.rate)) < made.rate.index(min(made.rate))
    assert np.mean(made.rate[: onset - 3]) == pytest.approx(0, abs=0.08)


def test_an_upside_down_sensor_gives_the_same_curve() -> None:
    samples, finding = found(FAST, "clean")
    turned = samples.copy()
    turned["rate"] *= -1
    whole = (finding.onset_ns, finding.end_ns, finding.details)
    assert trace_of(samples, *whole) == trace_of(turned, *whole)


def test_phases_have_the_analysed_durations_in_order() -> None:
    _, finding = found(DWELLING)
    made = trace(DWELLING)
    times = (made.onset_s, made.arrival_s, made.departure_s, made.end_s)
    lasted = [later - earlier for earlier, later in pairwise(times)]
    measured = [finding.details[f"{name}_ms"] for name in ("out", "dwell", "back")]
    assert [1000 * each for each in lasted] == pytest.approx(measured, abs=0.01)
    assert made.onset_s == pytest.approx(0.3, abs=0.01)
    assert (len(made.rate) - 1) / made.rate_hz > made.end_s + 0.4


@pytest.mark.parametrize("seconds", [0.4, 2.0, 7.0])
def test_a_curve_is_downsampled_and_keeps_its_peak(seconds: float) -> None:
    peak = 3.0 / seconds
    made = trace(ReachShape(out_s=seconds, back_s=seconds, peak_out=peak, peak_back=-peak), "clean")
    assert len(made.rate) <= MOST_POINTS
    assert max(made.rate) == pytest.approx(peak, rel=0.04)
    assert all(map(math.isfinite, made.rate))


def test_a_reach_without_samples_has_no_curve() -> None:
    _, finding = found(FAST)
    empty = np.empty(0, SAMPLE)
    assert trace_of(empty, ONSET, ONSET + SECOND, finding.details) is None
    samples, _ = found(FAST)
    assert trace_of(samples[:200], ONSET, ONSET + SECOND, finding.details) is None


# --- the drawing


@pytest.mark.parametrize("size", [(40, 6), (76, 6), (76, 9), (120, 30)])
@pytest.mark.parametrize("count", [1, 3])
def test_it_fills_the_available_space(size: tuple[int, int], count: int) -> None:
    lines = drawn(*[trace(DWELLING)] * count, width=size[0], height=size[1])
    assert len(lines) == size[1]
    assert {len(line) for line in lines} == {size[0]}


@pytest.mark.parametrize("width", [40, 76, 120])
def test_the_phases_are_named_above_the_curve_in_order(width: int) -> None:
    names, *body = drawn(trace(DWELLING), width=width)
    places = [names.index(name) for name in ("out", "dwell", "back")]
    assert places == sorted(places)
    rows = [number for number, line in enumerate(body) if dots(line[places[0]])]
    assert rows[0] < next(number for number, line in enumerate(body) if dots(line[places[2]]))
    bounds = [index for index, mark in enumerate(body[0]) if mark == "┊"]
    assert len(bounds) == 4
    for (first, last), place in zip(pairwise(bounds), places, strict=True):
        assert first <= place < last


def test_the_latest_reach_is_a_solid_line_and_earlier_ones_are_dotted() -> None:
    above, below = steady(1.0, "before"), steady(-1.0, "this reach")
    lines = drawn(above, below)
    fullest = [
        max((ord(mark) - 0x2800).bit_count() for mark in line if dots(mark))
        for line in lines[:-1]
        if any(map(dots, line))
    ]
    assert fullest == [1, 2]


def test_several_reaches_have_a_legend_if_there_is_space() -> None:
    before, newest = steady(1.0, "reach 1"), steady(-1.0, "this reach")
    found = drawn(before, newest, height=9)[-1].split()
    assert found == ["⠒⠒", "this", "reach", "⠂⠂", "reach", "1"]
    assert "this reach" not in "".join(
        drawn(before, newest, height=8) + drawn(newest, height=9)[:-1]
    )


def test_colour_does_not_change_the_characters() -> None:
    made = trace(DWELLING)
    coloured = draw_traces([made], 76, 10, STYLES)
    assert coloured.plain == draw_traces([made], 76, 10).plain
    assert {"cyan", "white", "magenta"} <= {str(span.style) for span in coloured.spans}


@pytest.mark.parametrize("rate", [[], [0.0], [0.0] * 50, [5.0] * 50, [-5.0] * 50])
def test_any_measurement_can_be_drawn(rate: list[float]) -> None:
    odd = Trace(rate=rate, rate_hz=50.0, onset_s=0.0, arrival_s=0.0, departure_s=0.0, end_s=0.0)
    assert len(drawn(odd)) == 12


class PanelLayout(App[None]):
    def compose(self) -> ComposeResult:
        yield SpeedTrace()


async def test_the_widget_draws_only_the_given_reaches() -> None:
    app = PanelLayout()
    async with app.run_test(size=(60, 10)) as pilot:
        widget = app.query_one(SpeedTrace)
        assert widget.render().plain == ""
        widget.show([trace(DWELLING)])
        await pilot.pause()
        assert widget.render().plain.split("\n") == drawn(trace(DWELLING), width=60, height=10)
        widget.show([])
        assert widget.render().plain == ""

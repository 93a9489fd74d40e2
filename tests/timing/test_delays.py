"""Statistics of timing errors, and the delays of tones, on a card that nobody hears."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.outputs.sound.protocol import SoundError
from sar_tui.timing import tones
from sar_tui.timing.tones import ToneDelays, measure_tones
from sar_tui.timing.verdict import error_statistics
from tests.outputs.voice_fixtures import NOBODY
from tests.program import Call

ERRORS = st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=60)


def test_known_errors_give_figures_worked_out_by_hand() -> None:
    figures = error_statistics([-2.0, 0.0, 1.0, 2.0, 4.0])
    assert figures.n == 5
    assert figures.mean_ms == pytest.approx(1.0)
    assert figures.median_ms == 1.0
    assert figures.sd_ms == pytest.approx(5**0.5)
    assert figures.iqr_ms == 2.0
    assert figures.robust_sd_ms == pytest.approx(1.4826)
    assert figures.p99_ms == pytest.approx(3.92)
    assert figures.max_ms == 4.0


def test_one_stall_moves_the_standard_deviation_but_not_the_robust_one() -> None:
    calm = error_statistics([0.1 * (number % 5) for number in range(100)])
    stalled = error_statistics([*(0.1 * (number % 5) for number in range(99)), 200.0])
    assert stalled.sd_ms > 50 * calm.sd_ms
    assert stalled.robust_sd_ms == pytest.approx(calm.robust_sd_ms)


@pytest.mark.parametrize("errors", [[], [1.0]])
def test_too_few_errors_have_no_spread(errors: list[float]) -> None:
    with pytest.raises(ValueError, match="two errors"):
        error_statistics(errors)


@given(errors=ERRORS, shift=st.floats(-100, 100))
def test_a_constant_delay_moves_the_median_and_leaves_the_width(
    errors: list[float], shift: float
) -> None:
    before, after = error_statistics(errors), error_statistics([error + shift for error in errors])
    assert after.median_ms == pytest.approx(before.median_ms + shift, abs=1e-6)
    for width in ("sd_ms", "iqr_ms", "robust_sd_ms"):
        assert getattr(after, width) == pytest.approx(getattr(before, width), abs=1e-6)


@given(errors=ERRORS)
def test_the_figures_are_in_their_order(errors: list[float]) -> None:
    figures = error_statistics(errors)
    assert 0 <= figures.p99_ms <= figures.max_ms + 1e-9
    assert min(errors) - 1e-9 <= figures.median_ms <= max(errors) + 1e-9


# --- tones


def test_the_delays_of_tones_are_measured() -> None:
    found = measure_tones(2, NOBODY)
    assert (found.card, found.at_once.n, found.planned.n) == ("Null", 2, 2)
    assert found.buffer_ms > 0


def test_without_a_sound_card_it_says_so() -> None:
    with pytest.raises(SoundError, match="There is no sound card that can be used"):
        measure_tones(2, ("JACK",))


@pytest.fixture
def delays(monkeypatch: pytest.MonkeyPatch) -> None:
    found = ToneDelays(
        "ALSA", 30.0, error_statistics([31.0, 35.0, 33.0]), error_statistics([0.01, 0.02, 0.03])
    )
    monkeypatch.setattr(tones, "measure_tones", lambda count, on_tone: found)


@pytest.mark.usefixtures("delays")
def test_the_command_prints_the_delays(call: Call) -> None:
    called = call("timing", "--sound", "--trials", "10")
    assert (called.code, "ALSA: a sample waits 30 ms" in called.out) == (0, True)
    sound = json.loads(call("timing", "--sound", "--json").out)["sound"]
    assert sound["at_once"]["median_ms"] == 33.0


def test_the_command_fails_with_a_sentence(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(count: int, on_tone: object) -> None:
        raise SoundError("There is no sound card.")

    monkeypatch.setattr(tones, "measure_tones", fail)
    called = call("timing", "--sound")
    assert (called.code, called.out) == (1, "")
    assert "There is no sound card." in called.err

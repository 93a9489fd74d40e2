"""Segmentation of a stretch at once is the Segmenter's, sample by sample."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.inputs.recording_file import read_recording
from sar_tui.motion.samples import Floats, Samples
from sar_tui.motion.segmentation import Segmentation, segment
from sar_tui.motion.segmenter import Segmenter
from sar_tui.motion.single_axis import SingleAxisParameters
from sar_tui.motion.synthesis import PROFILES, ReachShape, SimulatedHand
from tests.examples import examples

RECORDING = Path(__file__).parents[2] / "data/table-4.1.csv"


def one_by_one(
    time_s: Floats, rate: Floats, rate_hz: float, parameters: SingleAxisParameters
) -> Segmentation:
    segmenter = Segmenter(rate_hz, parameters)
    found = []
    for now, sample in zip(time_s, rate, strict=True):
        segmenter.push(now[None], sample[None])
        began_s = math.nan if segmenter.began_s is None else segmenter.began_s
        returned_s = segmenter.returned_s if segmenter.returned else -math.inf
        found.append((segmenter.still_for_s, began_s, returned_s))
    return Segmentation(*np.array(found).T)


def assert_same(
    samples: Samples, rate_hz: float, parameters: SingleAxisParameters | None = None
) -> None:
    time_s, rate = samples["at"] / 1e9, samples["rate"].astype(float)
    parameters = parameters or SingleAxisParameters()
    expected = one_by_one(time_s, rate, rate_hz, parameters)
    for close in (1e-9, 0.01):  # the latter leaves nearly all to the Segmenter
        found = segment(time_s, rate, rate_hz, parameters, close)
        np.testing.assert_equal(tuple(found), tuple(expected))


@examples(60)
@given(st.data(), st.sampled_from(sorted(PROFILES)), st.integers(0, 10_000))
def test_a_simulated_hand_is_segmented_as_sample_by_sample(
    data: st.DataObject, profile: str, seed: int
) -> None:
    rate_hz = data.draw(st.sampled_from([250.0, 100.0, 21.0]))
    hand = SimulatedHand(PROFILES[profile], rate_hz, seed)
    onset_s = data.draw(st.floats(0, 3))
    for _ in range(data.draw(st.integers(0, 3))):
        out_s, back_s, dwell_s = (data.draw(st.floats(0.1, 2)) for _ in range(3))
        shape = ReachShape(
            out_s=out_s,
            back_s=back_s,
            dwell_s=dwell_s,
            peak_out=data.draw(st.floats(0.05, 4)),
            peak_back=-data.draw(st.floats(0.05, 4)),
            submovements=data.draw(st.sampled_from([0, 0, 4])),
            twitch=data.draw(st.booleans()),
            seed=seed,
        )
        hand.move(round(onset_s * 1e9), shape)
        onset_s += shape.duration_s + data.draw(st.floats(0.2, 3))
    samples = hand.samples(0, round((onset_s + 1) * 1e9))
    assert_same(
        samples, rate_hz, SingleAxisParameters(longest_s=data.draw(st.sampled_from([1.5, 15.0])))
    )


def test_a_recording_is_segmented_as_sample_by_sample_without_what_is_no_number() -> None:
    samples = read_recording(RECORDING).copy()
    assert_same(samples, 1e9 / float(np.median(np.diff(samples["at"]))))
    samples["rate"][100:120] = np.nan
    assert_same(samples[:700], 125.0)


@pytest.mark.parametrize("number", [1, 2, 24, 25, 299, 300, 301])
def test_a_few_samples_are_segmented_as_sample_by_sample(number: int) -> None:
    hand = SimulatedHand(PROFILES["patient"], 250.0, seed=1)
    hand.move(300_000_000, ReachShape(out_s=0.4, back_s=0.4))
    assert_same(hand.samples(0, 2_000_000_000)[:number], 250.0)


def test_a_comparison_that_rounding_may_decide_is_left_to_the_segmenter() -> None:
    """A hand that turns exactly as fast as the threshold, without any noise."""
    time_s = np.arange(1000) / 250
    rate = np.zeros((1000, 3))
    rate[500:, 2] = 0.1
    expected = one_by_one(time_s, rate, 250.0, SingleAxisParameters())
    np.testing.assert_equal(tuple(segment(time_s, rate, 250.0)), tuple(expected))

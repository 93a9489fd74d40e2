"""A simulated hand of a moving arm: its samples are those of one person's reaches, as quick as
requested.
"""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from sar_tui.motion.samples import Samples
from sar_tui.motion.synthesis import PROFILES, ReachShape
from sar_tui.motion.trajectories import SimulatedArm
from tests.examples import examples

SECOND = 1_000_000_000
START = 7 * SECOND
REACH = ReachShape(out_s=0.8, back_s=0.8)


def an_arm(
    kind: str = "lift-extend-touch", profile: str = "patient", reaches: int = 3
) -> SimulatedArm:
    """Return an arm that reaches after one second, and every four."""
    arm = SimulatedArm(kind, PROFILES[profile], 250.0, seed=3)
    for number in range(reaches):
        arm.move(START + (1 + 4 * number) * SECOND, REACH)
    return arm


def clean(kind: str, reaches: int = 1) -> Samples:
    return an_arm(kind, "clean", reaches).samples(START, START + 4 * reaches * SECOND)


@pytest.mark.parametrize("kind", ["lift-extend-touch", "submovements"])
@given(cuts=st.lists(st.integers(0, 12 * SECOND), max_size=6))
@examples(20)
def test_samples_do_not_depend_on_how_they_are_requested(kind: str, cuts: list[int]) -> None:
    whole = an_arm(kind).samples(START, START + 12 * SECOND)
    arm, edges = an_arm(kind), [0, *sorted(cuts), 12 * SECOND]
    parts = [arm.samples(START + begin, START + end) for begin, end in itertools.pairwise(edges)]
    assert np.concatenate(parts).tobytes() == whole.tobytes()


@pytest.mark.parametrize("kind", ["drinking", "cross-arm", "two-hand-push"])
def test_a_reach_has_the_duration_of_the_shape_and_turns_about_several_axes(kind: str) -> None:
    samples = clean(kind)
    since_s = (samples["at"] - START) / 1e9 - 1.0
    speed = np.linalg.norm(samples["rate"], axis=1)
    assert not speed[(since_s < 0) | (since_s > 1.6 + 0.01)].max() > 1e-5
    moving = since_s[speed > 0.02 * speed.max()]
    assert (moving[0], moving[-1]) == pytest.approx((0.0, 1.6), abs=0.15)
    shares = np.linalg.svd(samples["rate"], compute_uv=False)
    assert shares[1] > 0.1 * shares[0]


def test_a_hand_is_about_where_it_was_after_each_reach_and_gravity_turns_with_it() -> None:
    samples = clean("forearm-rotation", reaches=5)
    turned = [Rotation.identity()]
    rate = samples["rate"].astype(float)
    for step in Rotation.from_rotvec((rate[1:] + rate[:-1]) / 2.0 / 250.0):
        turned.append(turned[-1] * step)
    orientation = Rotation.concatenate(turned)
    degrees = np.degrees(orientation.magnitude())
    at_rest = (samples["at"] - START) % (4 * SECOND) < 0.9 * SECOND
    assert degrees[at_rest].max() < 8
    assert degrees.max() > 30
    gravity = orientation[at_rest].apply(samples["acceleration"][at_rest])
    assert np.abs(gravity - gravity[0]).max() < 0.2

"""Addresses of servo outputs: the wiring, or a clear error."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.outputs.output import OutputError
from sar_tui.outputs.servo.channel import JointChannel, ServoAddress, parse


@pytest.mark.parametrize(
    ("text", "serial", "joints", "range_deg", "speed"),
    [
        ("", None, "right_arm 0", 45, 180),
        ("620001", 620_001, "right_arm 0", 45, 180),
        ("?speed=90&range=30.5", None, "right_arm 0", 30.5, 90),
        ("620001?right_arm=3&nod=0&left_arm=-2", 620_001, "nod 0,left_arm -2,right_arm 3", 45, 180),
        ("?turn=-0&lean=15", None, "turn -0,lean 15", 45, 180),
    ],
)
def test_an_address_says_which_controller_which_joints_and_how_far_and_fast(
    text: str, serial: int | None, joints: str, range_deg: float, speed: float
) -> None:
    wired = (joint.split() for joint in joints.split(","))
    channels = tuple(JointChannel(name, abs(int(at)), at.startswith("-")) for name, at in wired)
    assert parse(text) == ServoAddress(serial, channels, range_deg, speed)


@pytest.mark.parametrize(
    ("texts", "why"),
    [
        ("left", '"left" is not a serial number'),
        ("-1 ١٢٣ //robot:5661", "not a serial number"),
        ("?tail=0", "tail"),
        ("?nod=first ?nod= ?nod=٣ ?nod=100", "nod"),
        ("?nod", "bad query field"),
        ("?nod=0&nod=1", "twice"),
        ("?nod=1&turn=-1", "same channel"),
        ("?range=4 ?range=91 ?range=nan", "range"),
        ("?speed=361 ?speed=fast", "speed"),
    ],
)
def test_an_invalid_address_is_refused_with_the_reason_and_the_allowed_forms(
    texts: str, why: str
) -> None:
    for text in texts.split():
        with pytest.raises(OutputError) as refused:
            parse(text)
        assert why in str(refused.value), text
        assert "servo:SERIAL?right_arm=0" in str(refused.value), text


@given(st.text(max_size=40) | st.text("?&=-0123456789nodturnlean", max_size=40))
def test_any_address_is_parsed_or_refused(text: str) -> None:
    try:
        address = parse(text)
    except OutputError:
        return
    assert address.joint_channels
    assert 5 <= address.range_deg <= 90
    assert 30 <= address.speed_deg_s <= 360

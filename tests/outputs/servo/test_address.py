"""Addresses of servo outputs: the wiring, or a clear error."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.outputs.output import OutputError
from sar_tui.outputs.servo.channel import JointChannel, ServoAddress, parse

ALONE = (JointChannel("right_arm", 0, reverse=False),)


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("", ServoAddress(None, ALONE, 45, 180)),
        ("620001", ServoAddress(620_001, ALONE, 45, 180)),
        ("?speed=90&range=30.5", ServoAddress(None, ALONE, 30.5, 90)),
        (
            "620001?right_arm=3&nod=0&left_arm=-2",
            ServoAddress(
                620_001,
                (
                    JointChannel("nod", 0, False),
                    JointChannel("left_arm", 2, True),
                    JointChannel("right_arm", 3, False),
                ),
                45,
                180,
            ),
        ),
        (
            "?turn=-0&lean=15",
            ServoAddress(
                None, (JointChannel("turn", 0, True), JointChannel("lean", 15, False)), 45, 180
            ),
        ),
    ],
)
def test_an_address_says_which_controller_which_joints_and_how_far_and_fast(
    text: str, address: ServoAddress
) -> None:
    assert parse(text) == address


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("left", '"left" is not a serial number'),
        ("-1", "not a serial number"),
        ("١٢٣", "not a serial number"),
        ("?tail=0", "tail"),
        ("?nod=first", "nod"),
        ("?nod=", "nod"),
        ("?nod=٣", "nod"),
        ("?nod=100", "nod"),
        ("?nod", "bad query field"),
        ("?nod=0&nod=1", "twice"),
        ("?nod=1&turn=-1", "same channel"),
        ("?range=4", "range"),
        ("?range=91", "range"),
        ("?range=nan", "range"),
        ("?speed=361", "speed"),
        ("?speed=fast", "speed"),
        ("//robot:5661", "not a serial number"),
    ],
)
def test_an_invalid_address_is_refused_with_the_reason_and_the_allowed_forms(
    text: str, why: str
) -> None:
    with pytest.raises(OutputError) as refused:
        parse(text)
    assert why in str(refused.value)
    assert "servo:SERIAL?right_arm=0" in str(refused.value)


@given(st.text(max_size=40) | st.text("?&=-0123456789nodturnlean", max_size=40))
def test_any_address_is_parsed_or_refused(text: str) -> None:
    try:
        address = parse(text)
    except OutputError:
        return
    assert address.joint_channels
    assert 5 <= address.range_deg <= 90
    assert 30 <= address.speed_deg_s <= 360

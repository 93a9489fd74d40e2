"""Contrast ratios are those of WCAG 2.2."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.model.contrast import contrast, cut, is_color

COLORS = st.from_regex("#[0-9a-f]{6}", fullmatch=True)


def wcag_ratio(one: str, other: str) -> float:
    """Return the contrast ratio of two colours, by the formula of WCAG 2.2."""

    def luminance(color: str) -> float:
        linear = []
        for hex_pair in re.findall("..", color.removeprefix("#")):
            share = int(hex_pair, 16) / 255
            linear.append(share / 12.92 if share <= 0.04045 else ((share + 0.055) / 1.055) ** 2.4)
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    light, dark = sorted((luminance(one), luminance(other)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


@pytest.mark.parametrize(
    ("one", "other", "ratio"),
    [("#000000", "#ffffff", 21.0), ("#777777", "#ffffff", 4.48), ("#123456", "#123456", 1.0)],
)
def test_contrast_is_that_of_wcag(one: str, other: str, ratio: float) -> None:
    assert contrast(one, other) == pytest.approx(ratio, abs=0.01)
    assert contrast(other, one) == contrast(one, other)


@given(COLORS, COLORS)
def test_contrast_agrees_with_the_definition(one: str, other: str) -> None:
    assert contrast(one, other) == pytest.approx(wcag_ratio(one, other))


def test_a_ratio_below_a_bound_is_not_rounded_up_to_it() -> None:
    assert cut(4.4999) == 4.49
    assert cut(4.5) == 4.5
    assert cut(contrast("#000000", "#ffffff")) == 21.0


@pytest.mark.parametrize("value", ["#a0b1c2", "#FFFFFF", "#000000"])
def test_a_colour_is_six_hexadecimal_digits_after_a_hash(value: str) -> None:
    assert is_color(value)


@pytest.mark.parametrize(
    "value", ["red", "#12345", "#1234567", "#12345g", "112233", "", "#112233\n", "#١١٢٢٣٣"]
)
def test_anything_else_is_not_a_colour(value: str) -> None:
    assert not is_color(value)

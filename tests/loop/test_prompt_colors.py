"""Colours of prompts: they stand out on each theme, and people tell them apart, whatever their
colour vision.
"""

from itertools import combinations

import numpy as np
import pytest

from sar_tui.loop.prompt_colors import LEAST_CONTRAST, OKABE_ITO, color_on, color_problem
from sar_tui.model.contrast import contrast
from sar_tui.plugins import Catalogue
from sar_tui.widgets.big_prompt import prompt_color

# fmt: off
VISION = {
    "normal": np.eye(3),
    "protanopia": np.array([[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
                            [-0.003882, -0.048116, 1.051998]]),
    "deuteranopia": np.array([[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
                              [-0.011820, 0.042940, 0.968881]]),
    "tritanopia": np.array([[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602],
                            [0.004733, 0.691367, 0.303900]]),
}
# fmt: on
"""Linear RGB as people see it, by Machado, Oliveira & Fernandes (2009), severity 1."""


def lab(color: str, vision: str) -> np.ndarray:
    """CIE L*a*b* of a colour as people with a vision see it."""
    srgb = np.array([int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)])
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    seen = np.clip(VISION[vision] @ linear, 0, 1)
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    xyz = np.array(to_xyz) @ seen
    x, y, z = np.cbrt(xyz / np.array([0.9505, 1.0, 1.089]))
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize("vision", VISION)
def test_two_colours_differ_for_each_kind_of_colour_vision(vision: str) -> None:
    seen = {name: lab(color, vision) for name, color in OKABE_ITO.items()}
    pairs = [(seen[one], seen[other]) for one, other in combinations(seen, 2)]
    least = min(float(np.linalg.norm(one - other)) for one, other in pairs)
    assert least > 10


@pytest.mark.parametrize("name", OKABE_ITO)
def test_a_colour_stands_out_on_the_background_of_each_theme(
    name: str, catalogue: Catalogue
) -> None:
    for theme in map(catalogue.theme, catalogue.theme_names()):
        background = theme.colors.background
        assert contrast(color_on(name, background), background) >= LEAST_CONTRAST
        if theme.dark:
            assert color_on(name, background) == OKABE_ITO[name]


@pytest.mark.parametrize("background", ["#000000", "#ffffff", "#777777", "#d55e00"])
def test_colours_are_found_for_any_background(background: str) -> None:
    assert all(
        contrast(color_on(name, background), background) >= LEAST_CONTRAST for name in OKABE_ITO
    )


@pytest.mark.parametrize("background", ["#10171e", "#fff4d6"])
@pytest.mark.parametrize("color_system", ["standard", "256", "truecolor"])
def test_each_name_has_a_colour_of_its_own_in_any_terminal(
    color_system: str, background: str
) -> None:
    from rich.color import ColorSystem

    system = {
        "standard": ColorSystem.STANDARD,
        "256": ColorSystem.EIGHT_BIT,
        "truecolor": ColorSystem.TRUECOLOR,
    }
    colors = [prompt_color(name, background, color_system) for name in OKABE_ITO]
    drawn = {color.downgrade(system[color_system]) for color in colors if color}
    assert len(drawn) == len(OKABE_ITO)


def test_other_names_are_refused_and_have_the_colour_of_texts() -> None:
    assert "There is no colour 'pink'. Choose one of: red, " in color_problem("pink")
    assert color_problem("") == color_problem("sky blue") == ""
    assert prompt_color("pink", "#000000", "truecolor") is None

"""The simulated people of each task show the published effect, and those without it do not."""

from statistics import fmean

import pytest

from sar_tui.model.theme import Theme
from sar_tui.plugins import Catalogue
from sar_tui.validation.effects import effects, play

SESSIONS = {"flanker": 8, "gonogo": 6, "tapping": 5, "tracking_tempo": 6}
LONG_SESSIONS = {"nback": 4, "posner": 6, "srtt": 4, "stop_signal": 6}
DECLARED = {kind.name: (kind, effect) for kind, effect in effects(Catalogue())}


def test_every_effect_is_tested() -> None:
    assert set(DECLARED) == set(SESSIONS) | set(LONG_SESSIONS)


@pytest.mark.parametrize(
    ("name", "sessions"),
    [
        *SESSIONS.items(),
        *(pytest.param(*each, marks=pytest.mark.slow) for each in LONG_SESSIONS.items()),
    ],
)
def test_people_show_the_effect_and_those_without_it_are_told_from_them(
    name: str, sessions: int, calm: Theme
) -> None:
    kind, effect = DECLARED[name]
    for rehearsal, is_shown in ((None, True), (effect.without, False)):
        played = [play(kind, effect, calm, seed, rehearsal) for seed in range(1, sessions + 1)]
        values = [effect.measure(trials) for trials in played]
        mean = fmean(value for value in values if value is not None)
        assert (effect.low <= mean <= effect.high) is is_shown

"""Sessions of the bundled tasks in which simulated people show the declared effect."""

from collections.abc import Callable

import pytest

from sar_tui.model.messages import TrialEnded
from sar_tui.model.theme import Theme
from sar_tui.plugins import Catalogue
from sar_tui.validation.effects import effects, play

EffectSession = Callable[[str], list[TrialEnded]]


@pytest.fixture(scope="session")
def effect_session(catalogue: Catalogue, calm: Theme) -> EffectSession:
    """Return a function that plays a session of a task, with the settings of its effect."""
    declared = {kind.name: (kind, effect) for kind, effect in effects(catalogue)}
    return lambda name: play(*declared[name], calm, seed=1)

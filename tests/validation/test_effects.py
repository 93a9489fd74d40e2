"""The simulated people of each task show the published effect, and those without it do not."""

from pathlib import Path
from statistics import fmean

import pytest

from sar_tui.model.theme import Theme
from sar_tui.plugins import Catalogue, PluginError
from sar_tui.validation import effects
from sar_tui.validation.report import Conditions
from tests.documented import write_documented

SESSIONS = {"flanker": 4, "gonogo": 3, "tapping": 3, "tracking_tempo": 2}
LONG_SESSIONS = {"nback": 4, "posner": 6, "srtt": 4, "stop_signal": 6}
DECLARED = {kind.name: (kind, effect) for kind, effect in effects.effects(Catalogue())}


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
        played = [
            effects.play(kind, effect, calm, seed, rehearsal) for seed in range(1, sessions + 1)
        ]
        values = [effect.measure(trials) for trials in played]
        mean = fmean(value for value in values if value is not None)
        assert (effect.low <= mean <= effect.high) is is_shown


@pytest.mark.parametrize(
    ("fault", "failing"),
    [("none", ["", ""]), ("the control shows it", ["", "flanker"]), ("far", ["flanker", ""])],
)
def test_a_claim_about_the_effects_names_the_task_that_is_against_it(
    fault: str, failing: list[str], monkeypatch: pytest.MonkeyPatch, catalogue: Catalogue
) -> None:
    kind, effect = DECLARED["flanker"]
    if fault == "the control shows it":
        effect = effect._replace(without=kind.rehearse)
    elif fault == "far":
        effect = effect._replace(low=effect.high + 100, high=effect.high + 200)
    monkeypatch.setattr(effects, "effects", lambda _: iter([(kind, effect)]))
    monkeypatch.setattr(effects, "QUICK_SESSIONS", 4)
    report = effects.run(Conditions(catalogue, is_quick=True))
    assert [claim.against for claim in report.claims] == failing
    assert [(row["task"], row["sessions"]) for row in report.rows] == [("flanker", 4)]


def test_an_effect_file_that_declares_none_is_refused(tmp_path: Path) -> None:
    (write_documented(tmp_path / "mytasks", "arrows") / "effect.py").write_text("")
    with pytest.raises(PluginError, match="must define EFFECT"):
        list(effects.effects(Catalogue(tasks=(tmp_path / "mytasks",))))

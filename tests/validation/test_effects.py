"""The validation of effects finds those of the bundled tasks, and notices if one is not there."""

from pathlib import Path

import msgspec
import pytest

from sar_tui.plugins import Catalogue, PluginError
from sar_tui.validation import effects
from sar_tui.validation.report import Conditions
from tests.documented import write_documented


@pytest.mark.slow
def test_each_declared_effect_is_shown_and_its_control_is_not() -> None:
    report = effects.run(Conditions(Catalogue(), is_quick=True))
    assert {row["task"] for row in report.rows} >= {"flanker"}
    assert [claim.against for claim in report.claims if claim.against] == []


def test_a_control_that_shows_the_effect_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    ((kind, effect), *_) = effects.effects(Catalogue())
    monkeypatch.setattr(
        effects, "effects", lambda _: iter([(kind, effect._replace(without=kind.rehearse))])
    )
    _, outside = effects.run(Conditions(Catalogue(), is_quick=True)).claims
    assert outside.against == kind.name


@pytest.mark.slow
def test_an_effect_outside_of_its_range_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    ((kind, effect), *_) = effects.effects(Catalogue())
    far = effect._replace(low=effect.high + 100, high=effect.high + 200)
    monkeypatch.setattr(effects, "effects", lambda _: iter([(kind, far)]))
    inside, _ = effects.run(Conditions(Catalogue(), is_quick=True)).claims
    assert inside.against == kind.name
    assert msgspec.json.encode(effects.run(Conditions(Catalogue(), is_quick=True)).rows)


def test_an_effect_file_that_declares_none_is_refused(tmp_path: Path) -> None:

    (write_documented(tmp_path / "mytasks", "arrows") / "effect.py").write_text("")
    with pytest.raises(PluginError, match="must define EFFECT"):
        list(effects.effects(Catalogue(tasks=(tmp_path / "mytasks",))))

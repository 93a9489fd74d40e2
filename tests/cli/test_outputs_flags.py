"""``--outputs``, ``--speech`` and ``--language`` on the command line."""

import json
import wave
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import Plan
from sar_tui.store import participants, programmes
from sar_tui.store.database import connect
from sar_tui.store.programmes import Programme
from tests.needs_speech import needs_speech
from tests.program import Call

SIMULATE = "simulate keyboard --user average --seed 1 --attempts 1 --set prompts_per_attempt=2"
RUN = "run keyboard -p P01"


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch, data: Path) -> list[Plan]:
    """Fake a terminal and an app, with a participant; return the plans of the sessions it was
    opened with.
    """
    with closing(connect(data)) as database:
        participants.add(database, "P01")
    plans: list[Plan] = []

    def run_app(folder: Path, catalogue: Catalogue, plan: Plan, *_: Any, **__: Any) -> int:
        plans.append(plan)
        return 0

    monkeypatch.setattr("sar_tui.app.app.run_app", run_app)
    stream = SimpleNamespace(isatty=lambda: True)
    streams = SimpleNamespace(stdin=stream, stdout=stream, stderr=stream)
    monkeypatch.setattr("sar_tui.cli.common.sys", streams)
    return plans


def stored(call: Call) -> dict[str, Any]:
    """The parameters of the latest session."""
    found: dict[str, Any] = call("show last --json").json["session"]["parameters"]
    return found


def test_outputs_are_named_either_way_and_the_option_speech_adds_speech(
    call: Call, opened: list[Plan], tmp_path: Path
) -> None:
    where = f"file:{tmp_path}"
    cases: dict[str, tuple[object, str]] = {
        "--outputs screen,speech": (("screen", "speech"), ""),
        "--set outputs=screen,speech": (("screen", "speech"), ""),
        f"--speech {where}": (("screen", "speech"), where),
        f"--speech {where} --outputs tones,speech": (("tones", "speech"), where),
        f"--set speech={where}": (("screen",), where),
    }
    for options, (outputs, speech) in cases.items():
        assert call(f"{RUN} {options}").code == 0
        parameters = opened[-1].parameters
        assert parameters.outputs == outputs, options
        assert not speech or parameters.speech == speech, options


def test_options_override_saved_settings_and_keep_the_rest(
    call: Call, opened: list[Plan], data: Path
) -> None:
    saved = Programme({"outputs": ["screen", "tones"], "language": "es", "attempts": 3}, "playful")
    with closing(connect(data)) as database:
        programmes.save(database, "P01", "keyboard", saved, after=0)
    call(RUN)
    call(f"{RUN} --speech sound --language en")
    first, second = (plan.parameters for plan in opened)
    assert (first.outputs, first.language) == (("screen", "tones"), "es")
    assert (second.outputs, second.language) == (("screen", "tones", "speech"), "en")
    assert (first.attempts, second.attempts) == (3, 3)


@needs_speech
def test_a_simulated_session_speaks_into_files_and_says_so(call: Call, tmp_path: Path) -> None:
    to = tmp_path / "said"
    assert call(f"{SIMULATE} --speech file:{to}").code == 0
    assert stored(call)["outputs"] == ["screen", "speech"]
    assert stored(call)["speech"] == f"file:{to}"
    files = sorted(to.rglob("*.wav"))
    assert len(files) >= 3, "a greeting, an answer, a goodbye"
    for file in files:
        with wave.open(str(file)) as sound:
            assert sound.getnframes() / sound.getframerate() > 0.3


def test_a_simulated_session_speaks_the_language_it_is_given(call: Call, data: Path) -> None:
    for language, thanks in (("en", "Thank you"), ("es", "racias")):
        assert call(f"{SIMULATE} --language {language}").code == 0
        assert stored(call)["language"] == language
        with closing(connect(data)) as database:
            said = "SELECT final FROM actions WHERE kind='goodbye' ORDER BY rowid DESC"
            (final,) = database.execute(said).fetchone()
        assert thanks in json.loads(final)["text"]

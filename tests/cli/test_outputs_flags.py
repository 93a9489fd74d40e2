"""``--outputs``, ``--speech`` and ``--language`` on the command line."""

import json
import sqlite3
import wave
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from sar_tui.link.broker_process import BrokerProcess
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import Plan
from sar_tui.store import participants, programmes
from sar_tui.store.database import connect
from sar_tui.store.programmes import Programme
from tests.needs_speech import needs_speech
from tests.program import Call

SIMULATE = (
    "simulate keyboard --user average --seed 1 --attempts 1 --set prompts_per_attempt=2".split()
)
RUN = ("run", "keyboard", "-p", "P01")


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[Plan]:
    """Fake a terminal and an app, with a participant; return the plans of the sessions it was
    opened with.
    """
    with closing(connect(tmp_path / "data")) as database:
        participants.add(database, "P01")
    plans: list[Plan] = []

    def run_app(
        folder: Path, catalogue: Catalogue, plan: Plan, link: BrokerProcess | None, **_: object
    ) -> int:
        plans.append(plan)
        return 0

    monkeypatch.setattr("sar_tui.app.app.run_app", run_app)
    monkeypatch.setenv("TERM", "xterm-256color")
    stream = SimpleNamespace(isatty=lambda: True)
    monkeypatch.setattr(
        "sar_tui.cli.common.sys", SimpleNamespace(stdin=stream, stdout=stream, stderr=stream)
    )
    return plans


def stored(folder: Path) -> dict[str, Any]:
    """The parameters of the latest session."""
    with sqlite3.connect(folder / "data" / "sar-tui.db") as connection:
        (text,) = connection.execute(
            "SELECT parameters FROM sessions ORDER BY rowid DESC"
        ).fetchone()
    found: dict[str, Any] = json.loads(text)
    return found


@pytest.mark.parametrize(
    "how", [("--outputs", "screen,speech"), ("--set", "outputs=screen,speech")]
)
def test_outputs_are_named_either_way(call: Call, opened: list[Plan], how: tuple[str, str]) -> None:
    assert call(*RUN, *how).code == 0
    assert opened[0].parameters.outputs == ("screen", "speech")


def test_the_option_speech_adds_speech_to_the_outputs(
    call: Call, opened: list[Plan], tmp_path: Path
) -> None:
    where = f"file:{tmp_path}"
    call(*RUN, "--speech", where)
    call(*RUN, "--speech", where, "--outputs", "tones,speech")
    call(*RUN, "--set", f"speech={where}")
    assert [(plan.parameters.outputs, plan.parameters.speech) for plan in opened] == [
        (("screen", "speech"), where),
        (("tones", "speech"), where),
        (("screen",), where),
    ]


def test_options_override_saved_settings_and_keep_the_rest(
    call: Call, opened: list[Plan], tmp_path: Path
) -> None:
    saved = Programme({"outputs": ["screen", "tones"], "language": "es", "attempts": 3}, "playful")
    database = connect(tmp_path / "data")
    programmes.save(database, "P01", "keyboard", saved, after=0)
    database.close()
    call(*RUN)
    call(*RUN, "--speech", "sound", "--language", "en")
    found = [
        (plan.parameters.outputs, plan.parameters.language, plan.parameters.attempts)
        for plan in opened
    ]
    assert found == [(("screen", "tones"), "es", 3), (("screen", "tones", "speech"), "en", 3)]


@needs_speech
def test_a_simulated_session_speaks_into_files_and_says_so(call: Call, tmp_path: Path) -> None:
    to = tmp_path / "said"
    assert call(*SIMULATE, "--speech", f"file:{to}").code == 0
    assert (stored(tmp_path)["outputs"], stored(tmp_path)["speech"]) == (
        ["screen", "speech"],
        f"file:{to}",
    )
    files = sorted(to.rglob("*.wav"))
    assert len(files) >= 3, "a greeting, an answer, a goodbye"
    for file in files:
        with wave.open(str(file)) as sound:
            assert sound.getnframes() / sound.getframerate() > 0.3


def test_a_simulated_session_speaks_the_language_it_is_given(call: Call, tmp_path: Path) -> None:
    said = []
    for language in ("en", "es"):
        assert call(*SIMULATE, "--language", language).code == 0
        with sqlite3.connect(tmp_path / "data" / "sar-tui.db") as connection:
            finals = connection.execute(
                "SELECT final FROM actions WHERE kind='goodbye' ORDER BY rowid"
            ).fetchall()
        said.append(json.loads(finals[-1][0])["text"])
    assert "Thank you" in said[0]
    assert "racias" in said[1]
    assert stored(tmp_path)["language"] == "es"

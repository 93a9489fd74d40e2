"""``sar-tui --patient``: refused in a sentence before the screen changes."""

from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.store import participants, passphrase
from sar_tui.store.database import connect
from sar_tui.store.passphrase import Passphrase
from tests.program import Call


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(passphrase, "_COST", 16)
    return tmp_path / "data"


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (["--patient", "P01"], "no exercise to do alone"),
        (["--patient", "P0l"], "There is no participant P0L. Is it P01?"),
        (["--patient", "no name"], "A participant code has"),
        (["--patient", "P01", "sessions"], "--patient goes without a command"),
    ],
)
def test_what_cannot_be_used_is_refused(
    arguments: list[str], why: str, call: Call, folder: Path
) -> None:
    Passphrase(folder).set("quiet river")
    with closing(connect(folder)) as database:
        participants.add(database, "P01")
    called = call(*arguments)
    assert called.code == 2
    assert why in " ".join(called.err.split())


def test_without_a_passphrase_it_says_how_to_set_one(call: Call, folder: Path) -> None:
    called = call("--patient P01")
    assert called.code == 2
    assert "sar-tui passphrase" in called.err

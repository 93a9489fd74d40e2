"""Files of people are made new, for their owner only, and nothing takes the place of another."""

import os
import stat
from datetime import datetime
from pathlib import Path

import pytest

from sar_tui.drivers.files import unused, write_private
from tests.program import Call


@pytest.fixture
def programme(call: Call, tmp_path: Path) -> None:
    (tmp_path / "p.toml").write_text('task = "keyboard"\n[parameters]\nattempts = 2\n')
    assert (
        call(
            "programme",
            "import",
            "P01",
            "keyboard",
            tmp_path / "p.toml",
            "--reason",
            "Tires",
            "--new",
        ).code
        == 0
    )


@pytest.mark.usefixtures("programme")
@pytest.mark.skipif(os.name != "posix", reason="modes are those of POSIX")
def test_programmes_and_presets_that_are_exported_are_for_their_owner_only(
    call: Call, tmp_path: Path
) -> None:
    old = os.umask(0)
    try:
        assert (
            call("programme", "export", "P01", "keyboard", "--to", tmp_path / "out.toml").code == 0
        )
        assert call("programme", "export", "P01", "keyboard", "--preset", "mine").code == 0
    finally:
        os.umask(old)
    for path in (tmp_path / "out.toml", tmp_path / "data" / "presets" / "keyboard" / "mine.toml"):
        assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_two_backups_in_one_second_are_two_files(
    call: Call, simulated: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Still(datetime):
        @classmethod
        def now(cls, tz: object = None) -> "Still":
            return cls(2026, 3, 2, 10, 15)

    monkeypatch.setattr("sar_tui.store.backup.datetime", Still)
    made = [Path(call("backup", "--json").json["file"]).name for _ in range(3)]
    assert made == [f"sar-tui-20260302T101500Z{number}.db" for number in ("", "-2", "-3")]


def test_a_name_that_is_taken_gets_a_number(tmp_path: Path) -> None:
    (tmp_path / "a.db").symlink_to("nowhere")
    assert unused(tmp_path / "a.db") == tmp_path / "a-2.db"
    with pytest.raises(FileExistsError):
        write_private(tmp_path / "a.db", "text")
    assert not (tmp_path / "nowhere").exists()

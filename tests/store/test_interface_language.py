"""The language of the screens for therapists."""

import stat
from pathlib import Path

import pytest

from sar_tui.store.interface_language import (
    FILE,
    choose_interface_language,
    interface_language,
)


@pytest.mark.parametrize(
    ("environment", "code"),
    [
        ({}, "en"),
        ({"LANG": "de_CH.UTF-8"}, "de"),
        ({"LANG": "de_DE.UTF-8", "LC_ALL": "es_MX.UTF-8"}, "es"),
        ({"LC_MESSAGES": "es", "LANG": "de_DE"}, "es"),
        ({"LANG": "sr_RS@latin"}, "en"),
        ({"LC_ALL": "C.UTF-8", "LANG": "de_DE"}, "en"),
    ],
)
def test_it_is_that_of_the_computer(tmp_path: Path, environment: dict[str, str], code: str) -> None:
    assert interface_language(tmp_path, environment) == code


def test_a_chosen_one_is_kept_for_the_data_folder(tmp_path: Path) -> None:
    choose_interface_language(tmp_path, "es")
    choose_interface_language(tmp_path, "de")
    assert interface_language(tmp_path, {"LANG": "es_ES"}) == "de"
    assert [path.name for path in tmp_path.iterdir() if path.name.startswith(FILE)] == [FILE]
    assert stat.S_IMODE((tmp_path / FILE).stat().st_mode) == 0o600


@pytest.mark.parametrize("text", [b"klingon\n", b"\xff\xfe", b""])
def test_a_damaged_choice_is_ignored(tmp_path: Path, text: bytes) -> None:
    (tmp_path / FILE).write_bytes(text)
    assert interface_language(tmp_path, {"LANG": "es_ES"}) == "es"

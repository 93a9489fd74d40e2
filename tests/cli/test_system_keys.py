"""``sar-tui doctor`` tells of slow, sticky and bounce keys, as the systems' own programs print
them.
"""

import platform
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from sar_tui.cli.doctor.finding import Finding
from sar_tui.cli.doctor.system_keys import system_keys

pytestmark = pytest.mark.skipif(platform.system() == "Windows", reason="runs shell scripts")

GNOME = {
    "slowkeys-enable": "false",
    "slowkeys-delay": "uint32 300",
    "stickykeys-enable": "false",
    "bouncekeys-enable": "false",
    "bouncekeys-delay": "uint32 300",
}
WINDOWS = {"Flags": "126", "BounceTime": "0", "DelayBeforeAcceptance": "1000"}
HERE: Any = SimpleNamespace()


@pytest.fixture
def programs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with all programs of the system."""
    monkeypatch.setenv("PATH", str(tmp_path))
    return tmp_path


def program(folder: Path, name: str, body: str) -> None:
    """Write a program, for which the shell needs no other."""
    path = folder / name
    path.write_text(f"#!/bin/sh\n{body}\n")
    path.chmod(0o755)


def on(monkeypatch: pytest.MonkeyPatch, system: str) -> Finding:
    """Return what is found on a system."""
    monkeypatch.setattr(platform, "system", lambda: system)
    return system_keys(HERE)


def in_gnome(folder: Path, monkeypatch: pytest.MonkeyPatch, **changed: str) -> Finding:
    settings = GNOME | {name.replace("_", "-"): value for name, value in changed.items()}
    cases = " ".join(f'{name}) echo "{value}";;' for name, value in settings.items())
    program(folder, "gsettings", f'case "$3" in {cases} esac')
    return on(monkeypatch, "Linux")


def in_macos(folder: Path, monkeypatch: pytest.MonkeyPatch, **settings: str) -> Finding:
    """Let ``defaults`` fail for each setting that was never touched."""
    cases = " ".join(f"{name}) echo {value};;" for name, value in settings.items())
    missing = (
        '*) echo "The domain/default pair of (com.apple.universalaccess, $3) does not exist" >&2; '
        "exit 1;;"
    )
    program(folder, "defaults", f'case "$3" in {cases} {missing} esac')
    return on(monkeypatch, "Darwin")


def in_windows(
    folder: Path, monkeypatch: pytest.MonkeyPatch, sticky: str = "510", **changed: str
) -> Finding:
    """Let ``reg query`` print the key, and then name, type and value."""
    cases = " ".join(
        f'"Response {name}") value={value};;' for name, value in (WINDOWS | changed).items()
    )
    body = (
        'case "${2##*[ \\\\\\\\]} $4" in '
        f'{cases} "StickyKeys Flags") value={sticky};; *) exit 1;; esac; '
        'echo; echo "HKEY_CURRENT_USER\\\\Control Panel"; echo "    $4    REG_SZ    $value"; echo'
    )
    program(folder, "reg", body)
    return on(monkeypatch, "Windows")


def test_nothing_is_found_where_all_is_off(programs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for found in (
        in_gnome(programs, monkeypatch),
        in_macos(programs, monkeypatch),
        in_windows(programs, monkeypatch),
    ):
        assert (found.state, found.advice) == ("ok", "")
        assert "no slow, sticky or bounce keys" in found.found


def test_slow_keys_are_told_with_their_delay_and_the_settings_that_record_them(
    programs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for found in (
        in_gnome(programs, monkeypatch, slowkeys_enable="true"),
        in_macos(programs, monkeypatch, slowKey="1", slowKeyDelay="300", stickyKey="0"),
        in_windows(programs, monkeypatch, Flags="127", DelayBeforeAcceptance="300"),
    ):
        assert found.state == "care"
        assert "slow keys (300 ms)" in found.found
        assert found.advice.endswith("--set system_keys=slow --set added_delay_ms=300")


def test_sticky_keys_are_told_and_no_reason_to_worry(
    programs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for found in (
        in_gnome(programs, monkeypatch, stickykeys_enable="true"),
        in_macos(programs, monkeypatch, stickyKey="1"),
        in_windows(programs, monkeypatch, sticky="511"),
    ):
        assert (found.state, found.found.split(" in ")[0]) == ("ok", "sticky keys")
        assert found.advice.endswith("--set system_keys=sticky")


def test_slow_and_sticky_keys_are_recorded_together(
    programs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = in_gnome(programs, monkeypatch, slowkeys_enable="true", stickykeys_enable="true")
    assert "--set system_keys=both --set added_delay_ms=300" in found.advice


def test_bounce_keys_alone_add_nothing_to_a_press(
    programs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for found in (
        in_gnome(programs, monkeypatch, bouncekeys_enable="true"),
        in_windows(programs, monkeypatch, Flags="127", BounceTime="300"),
    ):
        assert (found.state, found.advice) == ("ok", "")
        assert found.found.startswith("bounce keys (300 ms) in ")


def test_slow_keys_of_which_the_delay_is_not_stored_are_told_without_it(
    programs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = in_macos(programs, monkeypatch, slowKey="1")
    assert found.found.startswith("slow keys in macOS")
    assert found.advice.endswith("added_delay_ms=MS")


@pytest.mark.parametrize("system", ["Linux", "Darwin", "Windows", "FreeBSD"])
def test_where_the_system_cannot_be_asked_the_doctor_says_where_to_look(
    programs: Path, monkeypatch: pytest.MonkeyPatch, system: str
) -> None:
    found = on(monkeypatch, system)
    assert (found.state, "not known here" in found.found) == ("ok", True)
    assert "accessibility settings" in found.advice


def test_settings_that_cannot_be_read_are_not_taken_for_off(
    programs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program(programs, "defaults", 'echo "Could not read the domain" >&2; exit 1')
    assert "not known here" in on(monkeypatch, "Darwin").found

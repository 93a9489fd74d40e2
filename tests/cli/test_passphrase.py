"""``sar-tui passphrase``, and ``sar-tui --patient``, which needs one."""

import io
import os
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.store import participants, passphrase
from sar_tui.store.database import connect
from sar_tui.store.passphrase import Passphrase
from sar_tui.timing.pty import Terminal
from tests.end_to_end.participant_terminal import command
from tests.program import Call


def _type(monkeypatch: pytest.MonkeyPatch, line: str) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO(line))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(passphrase, "_COST", 16)
    return tmp_path / "data"


def test_it_is_set_from_standard_input_and_removed_again(
    call: Call, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _type(monkeypatch, "quiet river\n")
    called = call("passphrase")
    assert (called.code, called.err) == (0, "")
    assert "The passphrase is set." in called.out
    assert Passphrase(folder).check("quiet river", "pause")
    assert call("passphrase --remove").code == 0
    assert call("passphrase --tries --json").json["is_set"] is False


def test_the_tries_are_listed(call: Call, folder: Path) -> None:
    stored = Passphrase(folder)
    stored.set("quiet river")
    stored.check("wrong", "patient mode")
    stored.check("quiet river", "pause")
    called = call("passphrase --tries")
    assert [line.split()[2:] for line in called.out.splitlines()[3:]] == [
        ["wrong", "patient", "mode"],
        ["right", "pause"],
    ]
    found = call("passphrase --tries --json").json
    assert found["is_set"] is True
    assert [each["result"] for each in found["tries"]] == ["wrong", "right"]


def test_none_or_a_short_one_is_refused(
    call: Call, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for line, why in (("", "standard input"), ("abc\n", "at least 6")):
        _type(monkeypatch, line)
        call("passphrase").refused(why)
        assert not (folder / passphrase.FILE).exists()


def test_patient_mode_needs_a_passphrase_a_participant_and_an_exercise(
    call: Call, folder: Path
) -> None:
    call("--patient P01").refused("sar-tui passphrase")
    Passphrase(folder).set("quiet river")
    with closing(connect(folder)) as database:
        participants.add(database, "P01")
    call("--patient P01").refused("no exercise to do alone")
    call("--patient P0l").refused("There is no participant P0L. Is it P01?")
    call("--patient", "no name").refused("A participant code has")


@pytest.mark.skipif(os.name != "posix", reason="there are no pseudo-terminals")
def test_in_a_terminal_it_is_asked_for_twice_and_not_shown(data: Path) -> None:
    with Terminal(command("passphrase", "--data", str(data))) as terminal:
        terminal.wait_for("New passphrase:")
        terminal.write(b"quiet river\r")
        terminal.wait_for("Once more:")
        terminal.write(b"quiet river\r")
        assert terminal.wait() == 0
        assert b"quiet river" not in terminal.output
    assert Passphrase(data).check("quiet river")

"""``sar-tui letterbox``: a clinic and a home by commands, and what is refused."""

import io
import sys
from pathlib import Path

import pytest

from tests.program import Call, Called

HOME = ("--data", "home")


@pytest.fixture(autouse=True)
def in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def typed(call: Call, monkeypatch: pytest.MonkeyPatch) -> Call:
    """Call the program with a first argument that is its standard input."""

    def program(line: str, *words: object) -> Called:
        monkeypatch.setattr(sys, "stdin", io.StringIO(f"{line}\n"))
        return call(*words)

    return program


@pytest.fixture
def clinic(call: Call, typed: Call) -> Path:
    """The letterbox of a clinic with P07, whose data is where ``call`` has it."""
    typed("kornblume", "passphrase")
    folder = Path("shared ü box").absolute()
    call("letterbox new --clinic", "Klinik Bern Süd", "--folder", folder).shows("Klinik Bern Süd")
    call("programme import P07 keyboard --preset mild --new --reason start")
    return folder


@pytest.fixture
def invited(call: Call, clinic: Path) -> tuple[str, str]:
    """The file and the code of an invitation of P07."""
    found = call("letterbox invite P07 --json").json
    return found["file"], found["code"]


def test_from_an_invitation_to_the_first_session_at_the_clinic(
    call: Call, typed: Call, invited: tuple[str, str], clinic: Path
) -> None:
    file, code = invited
    typed(code.upper(), "letterbox join", file, *HOME).shows(
        "trains P07 for Klinik Bern Süd", "To train: sar-tui"
    )
    assert not Path(file).exists()
    call("simulate keyboard -p P07 --user average --attempts 1", *HOME)
    call("letterbox sync", *HOME).shows("1 written")
    call("letterbox sync").shows("2 letters taken (P07 2), 1 written.")
    assert len(call("sessions -p P07 --json").json["sessions"]) == 1
    call("letterbox message P07", "Well done.").shows("To P07: Well done.")
    call("letterbox days P07 Wednesday mon").shows("mon wed")
    call("letterbox ask P07 nasa-tlx").shows("NASA-TLX")
    call("letterbox sync", *HOME).shows("4 letters taken")
    call("record list -p P07", *HOME).shows("Well done.", "mon wed", "NASA-TLX")
    call("letterbox list", *HOME).shows("P07 trains here for Klinik Bern Süd.", "Arrived there")
    home = call("letterbox list --json").json["homes"][0]
    assert (home["name"], home["state"], home["missing"]) == ("P07", "joined", [])


def test_the_words_are_asked_for_again_until_they_are_right(
    call: Call, invited: tuple[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    file, code = invited
    typed = iter(["one two", "", code])
    monkeypatch.setattr("builtins.input", lambda _: next(typed))
    monkeypatch.setattr("sar_tui.cli.letterbox.is_interactive", lambda: True)
    call("letterbox join", file, *HOME).shows("The code has 8 words; these are 2.", "Welcome.")


def test_revoking_is_asked_about(
    call: Call, typed: Call, invited: tuple[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sar_tui.cli.letterbox.is_interactive", lambda: True)
    assert typed("n", "letterbox revoke P07").code != 0
    assert call("letterbox list --json").json["homes"][0]["state"] == "invited"
    call("letterbox revoke P07 --yes").shows("P07 is revoked")


def test_a_revoked_home_is_named(
    call: Call, typed: Call, invited: tuple[str, str], clinic: Path
) -> None:
    file, code = invited
    typed(code, "letterbox join", file, *HOME)
    call("letterbox sync")
    call("letterbox revoke P07").shows("P07 is revoked", "invite P07")
    call("letterbox sync", *HOME)
    call("letterbox list", *HOME).shows("takes no letters from this computer")
    call("letterbox revoke P07").refused("No home of P07")


@pytest.mark.parametrize(
    ("words", "why"),
    [
        ("letterbox sync", "There is no letterbox here."),
        ("letterbox list", "There is no letterbox here."),
        ("letterbox invite P07", "There is no letterbox here."),
        ("letterbox new --clinic Bern --folder data/in", "cannot be in the data folder"),
        ("letterbox new --clinic Bern --folder .", "cannot be in the data folder"),
        ("letterbox new --clinic --- --folder box", "has no letters"),
        ("letterbox new --clinic 東京 --folder box", "has no letters"),
        (f"letterbox new --clinic {'x' * 41} --folder box", "at most 40"),
        ("letterbox new --clinic Bern --folder full", "holds other files"),
        ("letterbox join nothing", "cannot be read"),
        ("letterbox join full/notes", "no invitation"),
    ],
)
def test_bad_input_is_refused(words: str, why: str, call: Call) -> None:
    Path("full").mkdir()
    Path("full/notes").write_text("x")
    call(words).refused(why)


@pytest.mark.parametrize(
    ("code", "why"),
    [
        ("one two", "The code has 8 words; these are 2."),
        (
            "vacant bamboo body black glide pumpkin wreck fashion",
            "not the words of this invitation",
        ),
        ("vacant bamboo body black glide pumpkin wreck xyzzy", "“xyzzy” is no word"),
        ("va bamboo body black glide pumpkin wreck fashion", "“va” is no word"),
        ("", "The code has 8 words; these are 0."),
    ],
)
def test_a_wrong_code_is_refused_and_nothing_is_stored(
    code: str, why: str, typed: Call, invited: tuple[str, str]
) -> None:
    typed(code, "letterbox join", invited[0], *HOME).refused(why)
    assert not Path("home").exists()


def test_a_data_folder_that_is_somebody_elses_joins_nobody(
    call: Call, typed: Call, invited: tuple[str, str], clinic: Path
) -> None:
    file, code = invited
    typed(code, "letterbox join", file).refused("This data folder is the clinic's")
    call("programme import P99 keyboard --preset mild --new --reason start", *HOME)
    typed(code, "letterbox join", file, *HOME).refused("has other people")


def test_a_person_with_two_clinics_needs_two_data_folders(
    call: Call, typed: Call, invited: tuple[str, str], clinic: Path
) -> None:
    typed(invited[1], "letterbox join", invited[0], *HOME)
    other = ("--data", "zurich")
    typed("kornblume", "passphrase", *other)
    call("letterbox new --clinic Zürich --folder zurich-box", *other)
    call("programme import P07 keyboard --preset mild --new --reason start", *other)
    second = call("letterbox invite P07 --json", *other).json
    typed(second["code"], "letterbox join", second["file"], *HOME).refused(
        "is of KLINIK-BERN-SUD", "use another data folder"
    )


def test_a_person_needs_a_programme_and_the_clinic_a_passphrase(call: Call) -> None:
    call("letterbox new --clinic Bern --folder box")
    call("letterbox invite P07").refused("There is no participant P07")
    call("record add adverse-event P07 what=x severity=mild --new")
    call("letterbox invite P07").refused("has no programme to train by")
    call("programme import P07 keyboard --preset mild --reason start")
    call("letterbox invite P07").refused("sar-tui passphrase")
    call("letterbox message P07 hello").refused("does not train at home")


def test_a_message_is_as_long_as_a_screen_can_show(call: Call, invited: tuple[str, str]) -> None:
    call("letterbox message P07", "x" * 301).refused("at most 300 characters")
    call("letterbox message P07", "").refused("Write what they should read.")
    call("letterbox days P07 someday").refused("Days are Mon, Tue")
    call("letterbox ask P07 pain").refused("is no form")


def test_another_folder_is_a_letterbox_only_if_it_is_one(
    call: Call, typed: Call, invited: tuple[str, str], clinic: Path
) -> None:
    file, code = invited
    Path("elsewhere").mkdir()
    moved = Path(file).rename("elsewhere/invitation")
    typed(code, "letterbox join", moved, *HOME).refused("is no letterbox", "--folder DIR")
    typed(code, "letterbox join", moved, "--folder", clinic, *HOME).shows("Welcome.")

"""Data of people and git: nothing is added after a day of use in a checkout, and tracked data are
warned of.
"""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from sar_tui.cli.doctor.data_in_git import data_in_git
from sar_tui.store.database import FILE, RESCUE
from sar_tui.store.safeguard import LastSaved
from tests.program import Call

REPOSITORY = Path(__file__).parents[2]
SAMPLE = ("README.md", "make_recording.py", "table-4.1.csv")

pytestmark = pytest.mark.skipif(not shutil.which("git"), reason="git is not installed")


def git(folder: Path, *words: str) -> str:
    """Run git in a folder, without the settings of who runs the tests."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    plain = {"GIT_CONFIG_GLOBAL": os.devnull, "GIT_CONFIG_SYSTEM": os.devnull}
    done = subprocess.run(
        ["git", "-C", folder, *words], env=kept | plain, capture_output=True, text=True, check=True
    )
    return done.stdout


@pytest.fixture
def checkout(tmp_path: Path, call: Call, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A checkout with its sample recording, from which the program is started as `make run`
    does.
    """
    folder = tmp_path / "checkout"
    (folder / "data").mkdir(parents=True)
    shutil.copy(REPOSITORY / ".gitignore", folder)
    for name in SAMPLE:
        shutil.copy(REPOSITORY / "data" / name, folder / "data")
    git(folder, "init", "-q")
    git(folder, "add", ".")
    monkeypatch.chdir(folder)
    monkeypatch.setenv("SAR_TUI_DATA", "data")
    return folder


@pytest.fixture
def programme(checkout: Path, call: Call) -> None:
    """A programme of P01."""
    file = checkout.parent / "programme.toml"
    file.write_text('task = "keyboard"\n[parameters]\nattempts = 2\n')
    assert call("programme import P01 keyboard", file, "--reason", "Tires early", "--new").code == 0


@pytest.mark.slow
@pytest.mark.usefixtures("programme")
def test_after_a_day_of_use_git_adds_nothing(checkout: Path, call: Call) -> None:
    data = checkout / "data"
    tracked = git(checkout, "ls-files").splitlines()
    assert tracked == [".gitignore", *(f"data/{name}" for name in SAMPLE)]
    for command in (
        "simulate keyboard --user average --seed 1 --attempts 2 -p P01",
        "simulate keyboard --user poor --attempts 2 -p P02 --speech file:data/said",
        "backup",
        "export --all --simulated --format bids",
        "programme export P01 keyboard --preset left-arm",
        "programme export P01 keyboard --to p01.toml",
        "progress P01 --html p01.html",
        "link invite operator --name OP1 --host 127.0.0.1",
    ):
        called = call(command)
        assert called.code == 0, called.err
    LastSaved(data, "abc").close()
    shutil.copy(data / FILE, data / f"{RESCUE}abc.db")
    assert call("rescue").code == 0
    folders = [call("export last --simulated --json").json["folder"] for _ in range(2)]
    assert {Path(folder).parent for folder in folders} == {data / "exports"}
    assert len(set(folders)) == 2, "neither takes the other's place"
    assert all(Path(folder, "trials.csv").exists() for folder in folders)
    made = {path.name for path in data.iterdir()} - set(SAMPLE)
    assert {"backups", "exports", "link", "presets", "saved", FILE} <= made
    assert git(checkout, "add", "-n", ".") == ""


@pytest.mark.parametrize(
    "command",
    [
        "export last --simulated --to study",
        "backup --to copies",
        "programme export P01 keyboard --to p01.txt",
        "progress P01 --html p01.xhtml",
    ],
)
@pytest.mark.usefixtures("programme")
def test_who_writes_where_git_would_add_it_is_told(
    checkout: Path, call: Call, command: str
) -> None:
    call("simulate keyboard --user average --attempts 1 -p P01")
    called = call(command)
    place = command.rsplit(maxsplit=1)[-1]
    assert (called.code, f"! git would add {place}" in called.err) == (0, True)
    (checkout / ".git" / "info" / "exclude").write_text(place)
    assert git(checkout, "add", "-n", ".") == ""
    outside = command.replace(f" {place}", f" {checkout.parent}/copy-{place}")
    assert call(outside).err == "", "not in a work tree"


def test_the_doctor_warns_of_data_that_git_tracks_or_would_add(checkout: Path, call: Call) -> None:
    call("simulate keyboard --user average --attempts 1")

    def told() -> tuple[str, str]:
        checks = {row["name"]: row for row in call("doctor --json").json["checks"]}
        return checks["Data and git"]["state"], checks["Data and git"]["found"]

    assert told() == ("ok", "git neither tracks data of people here, nor would add it")
    git(checkout, "add", "-f", f"data/{FILE}")
    state, found = told()
    assert (state, f"data/{FILE}" in found, "tracks" in found) == ("care", True, True)
    git(checkout, "rm", "-q", "--cached", f"data/{FILE}")
    (checkout / ".gitignore").unlink()
    state, found = told()
    assert (state, "would add" in found) == ("care", True)


def test_data_of_people_is_recognised_anywhere_in_a_checkout(checkout: Path, call: Call) -> None:
    call("simulate keyboard --user average --attempts 1 -p P01")
    call("export --all --simulated --to study --recode keys/codes.csv")
    call("backup --to old/copy.db")
    call("link invite operator --name OP1 --host 127.0.0.1")
    (checkout / "table.csv").write_text("a,b\n1,2\n")
    added = "study keys old table.csv operator-OP1.sar-link data/link"
    git(checkout, "add", "-f", *added.split())
    found = data_in_git(checkout, checkout / "data")
    tracked = {path.as_posix() for path in found.tracked}
    people = "study/sar-tui-export.json keys/codes.csv old/copy.db operator-OP1.sar-link"
    assert tracked >= {*people.split(), "data/link/authority.key"}
    assert not tracked & {"table.csv", "data/README.md", ".gitignore"}
    assert not found.would_add
    assert data_in_git(REPOSITORY, None).tracked == ()


def test_another_program_named_in_a_strangers_repository_is_not_started(
    checkout: Path, tmp_path: Path
) -> None:
    hook = tmp_path / "hook"
    hook.write_text(f"#!/bin/sh\ntouch {tmp_path / 'ran'}\n")
    hook.chmod(0o700)
    git(checkout, "config", "core.fsmonitor", str(hook))
    data_in_git(checkout, checkout / "data")
    assert not (tmp_path / "ran").exists()

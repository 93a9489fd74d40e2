"""``sar-tui demo``: invented people to look around with, in a folder that is gone afterwards."""

import signal
import tempfile
from pathlib import Path

import pytest

from sar_tui.cli import demo
from sar_tui.runs import demonstration
from sar_tui.store.database import FILE, connect
from sar_tui.store.locks import hold
from sar_tui.timing.pty import Terminal
from tests.end_to_end.participant_terminal import ScreenReader, command
from tests.program import Call


@pytest.fixture
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder for temporary files."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setenv("TMPDIR", str(folder))
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


def begin_to_invent(terminal: Terminal, folder: Path, pattern: str) -> None:
    """Wait until the program has begun to make its database."""
    for _ in range(2000):
        if terminal.ended or list(folder.glob(pattern)):
            break
        terminal.settle(silence_ms=20)
    assert list(folder.glob(pattern)), bytes(terminal.output)


def test_a_demonstration_can_be_kept_and_says_how_to_look_at_it(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(demonstration, "_STORIES", (demonstration._misses,))
    folder = tmp_path / "kept"
    call("demo --keep", folder).shows(f"sar-tui --data {folder}")
    assert {path.name for path in tmp_path.iterdir()} == {"kept"}
    call("sessions --data", folder).shows("P04", "demonstration")
    call("demo --keep", folder).refused("a folder of its own")
    call("sessions --data", folder).shows("P04")


def test_a_kept_demonstration_that_is_stopped_leaves_nothing(
    temporary: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "kept"
    with Terminal(command("demo", "--keep", str(folder))) as terminal:
        begin_to_invent(terminal, folder.parent, f"kept/{FILE}")
        terminal.kill(signal.SIGTERM)
        assert terminal.wait() == 143
    assert not folder.exists()


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("demo", "This needs a real terminal"),
        ("--data somewhere demo", "leave out --data"),
        ("demo --keep ''", "a name is missing"),
    ],
)
def test_without_a_terminal_or_with_data_it_is_refused_and_nothing_is_made(
    call: Call, temporary: Path, given: str, said: str
) -> None:
    call(given.replace("''", ""), *([""] if "''" in given else [])).refused(said)
    assert list(temporary.iterdir()) == []


def test_what_a_killed_demonstration_left_is_removed_and_nothing_else(temporary: Path) -> None:
    left, in_use, strange, data = (
        temporary / name
        for name in ("sar-tui-demo-left", "sar-tui-demo-used", "sar-tui-demo-strange", "data")
    )
    for folder in (left, in_use, data):
        connect(folder).close()
        hold(folder, "demo", "folder").release()
    strange.mkdir()
    (temporary / "sar-tui-demo-link").symlink_to(data)
    with hold(in_use, "demo", "folder"):
        demo._remove_leftovers()
    assert not left.exists()
    assert all(folder.is_dir() for folder in (in_use, strange, data))
    assert (data / FILE).exists()


def everything(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*")}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("end", "code"),
    [
        ("ctrl+q", 0),
        pytest.param("ctrl+c", 130, marks=pytest.mark.slow),
        pytest.param(signal.SIGTERM, 143, marks=pytest.mark.slow),
        pytest.param(None, 129, marks=pytest.mark.slow),
    ],
)
def test_it_opens_on_invented_people_and_leaves_nothing_in_the_file_system(
    tmp_path: Path, temporary: Path, end: str | signal.Signals | None, code: int
) -> None:
    home = tmp_path / "home"
    home.mkdir()
    places = {"HOME": str(home), "SAR_TUI_DATA": str(home / "data")}
    for name in ("XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_STATE_HOME", "XDG_CACHE_HOME"):
        places[name] = str(home / name)
    with Terminal(command("demo"), environment=places) as terminal:
        terminal.wait_for("Nothing here is kept.")
        terminal.wait_for("P06")
        screen = ScreenReader(terminal).text()
        assert "Demonstration: invented people." in screen
        assert len(list(temporary.iterdir())) == 1
        if end is None:
            terminal.hang_up()
            assert terminal.process.wait(60) == code
        else:
            terminal.press(end) if isinstance(end, str) else terminal.kill(end)
            assert terminal.wait() == code
            assert b"Nothing of it was kept." in terminal.output
    assert everything(temporary) | everything(home) == set()


@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_while_people_are_invented_ends_it_and_leaves_nothing(
    temporary: Path, end: signal.Signals
) -> None:
    with Terminal(command("demo")) as terminal:
        begin_to_invent(terminal, temporary, f"sar-tui-demo-*/data/{FILE}")
        terminal.kill(end)
        assert terminal.wait() == 128 + end
        assert b"Traceback" not in terminal.output
    assert everything(temporary) == set()

"""Code of the pages of earlier versions runs in this one.

The folder of a version holds the code of its pages as it stood; of those before `sar_tui.api`, with
its import lines.
"""

import json
import re
import socket
import sys
import time
import tomllib
from pathlib import Path
from textwrap import dedent, indent
from typing import Annotated, Any

import pytest

from sar_tui.api import task as door
from sar_tui.api.node import VirtualClock
from sar_tui.api.output import MS, OutputError, Report
from sar_tui.api.sensor import SourceError, open_source
from sar_tui.api.testing import Catalogue, check
from sar_tui.outputs import outputs
from tests.api.conftest import Install
from tests.api.pages import VERSIONS, kept, task_files
from tests.examples import first_rows
from tests.program import Call

ALL_FILES = {version: task_files(version) for version in VERSIONS}
TASKS = [(version, name) for version in VERSIONS for name in ALL_FILES[version]]
FRAGMENTS = [
    (version, block.code)
    for version in VERSIONS
    for block in kept(version, "write-your-own-task.md")
    if block.code not in [code for task in ALL_FILES[version].values() for code in task.values()]
    and "def test_" not in block.code
]
PICTURE = bytes.fromhex(
    "89504e470d0a1a0a0000000d4948445200000001000000010802000000907753de0000000c4944415408d763f8cfc0"
    "000003010100c9fe92ef0000000049454e44ae426082"
)
each_version = pytest.mark.parametrize("version", VERSIONS)


def write_task(folder: Path, files: dict[str, str]) -> Path:
    """Write the files of a task, and the pictures that one of them shows."""
    (folder / "pictures").mkdir(parents=True)
    for name, code in files.items():
        (folder / name).write_text(code, encoding="utf-8")
    for name in ("apple", "banana"):
        (folder / "pictures" / f"{name}.png").write_bytes(PICTURE)
    return folder


def test_each_version_has_its_pages() -> None:
    assert VERSIONS[:2] == ["35a882e", "a10d0a0"]
    assert min(len(files) for files in ALL_FILES.values()) >= 1
    assert len(TASKS) >= 24


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:chance of a situation")
@pytest.mark.parametrize(("version", "name"), first_rows(4, TASKS))
def test_a_task_is_played_and_keeps_the_contract(tmp_path: Path, version: str, name: str) -> None:
    folder = write_task(tmp_path / name, ALL_FILES[version][name])
    assert [(done.check, done.problems) for done in check(folder) if not done.ok] == []


@pytest.mark.parametrize(("version", "fragment"), FRAGMENTS)
def test_a_part_of_a_task_can_be_declared(version: str, fragment: str) -> None:
    names: dict[str, Any] = {name: getattr(door, name) for name in door.__all__}
    names |= {"Annotated": Annotated, "TurnParameters": door.TaskParameters}
    is_module = fragment.startswith(("class", "from", "import"))
    within_a_class = f"class Fragment(Task):\n{indent(dedent(fragment), '    ')}"
    exec(fragment if is_module else within_a_class, names)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:chance of a situation")
def test_the_parts_of_the_first_page_make_one_task(tmp_path: Path) -> None:
    """Its pieces, and its translation, belong to the arrows that precede them."""
    version = "35a882e"
    whole = ALL_FILES[version]["arrows"]["task.py"]
    instructions, settings, problems, _ = (code for _, code in FRAGMENTS[:4])
    (words,) = kept(version, "write-your-own-task.md", "toml")
    head, _, _ = whole.partition("    def instructions")
    _, _, tail = whole.partition("    def stimulus")
    source = f"{settings}{problems}\n\n{head}{instructions}\n    def stimulus{tail}"
    source = source.replace('"Arrows"\n', '"Arrows"\n    Parameters = ArrowsParameters\n')
    folder = write_task(tmp_path / "arrows", {"task.py": source, "words.es.toml": words.code})
    assert [(done.check, done.problems) for done in check(folder) if not done.ok] == []
    kind = Catalogue(tasks=(tmp_path,)).task("arrows")
    assert kind.Parameters(prompts_per_attempt=30, attempts=60).problems()["attempts"]
    assert kind(kind.Parameters(language="es")).instructions().startswith("Pulse la flecha")


@each_version
def test_the_tests_of_the_pages_pass(
    version: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, files in ALL_FILES[version].items():
        write_task(tmp_path / "mytasks" / name, files)
    for page in ("write-your-own-task.md", "write-a-node.md"):
        for block in kept(version, page):
            if "def test_" in block.code:
                names: dict[str, Any] = {}
                exec(block.code, names)
                run_test(names, tmp_path / "mytasks" / "twist", monkeypatch)


def run_test(names: dict[str, Any], twist: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run the tests of a block, each of which may ask for the module of the node."""
    for name, test in names.items():
        if name.startswith("test_"):
            if test.__code__.co_argcount:
                monkeypatch.syspath_prepend(str(twist))
                import twists  # type: ignore[import-not-found]

                test(twists)
                monkeypatch.delitem(sys.modules, "twists")
            else:
                test()


def put_in(install: Install, version: str, page: str, file: str = "") -> tuple[str, str]:
    """Install the plug-in of a page; return the name of its entry point, and its code."""
    code = next(block.code for block in kept(version, page))
    (entry,) = (block.code for block in kept(version, page, "toml"))
    ((group, points),) = tomllib.loads(entry)["project"]["entry-points"].items()
    ((name, value),) = points.items()
    install({value.partition(":")[0]: code}, group, name, value)
    return name, code


@each_version
def test_an_output_moves_stops_and_its_log_can_be_read(
    version: str,
    install: Install,
    call: Call,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    name, _ = put_in(install, version, "add-an-output.md")
    line = tmp_path / "line"
    line.touch()
    with pytest.raises(OutputError, match="Say which serial line"):
        outputs.check_outputs([name])
    robot = sys.modules["serial_robot"].SerialRobot(str(line))
    clock, reports = VirtualClock(), list[Report]()
    robot.open(Catalogue().theme("calm"), clock, reports.append)
    robot.gesture("one", "wave")
    clock.advance(1800 * MS)
    robot.gesture("two", "wave")
    robot.stop()
    robot.close()
    assert line.read_text().split("\n")[:3] == ["wave 1800", "wave 1800", "still"]
    assert [(report.action, report.state) for report in reports] == [
        ("one", "started"), ("one", "done"), ("two", "started"), ("two", "aborted")
    ]  # fmt: skip
    done = call(
        "simulate", "keyboard", "--user", "average", "--attempts", 1, "--seed", 1,
        "--set", f"outputs=screen robot:{line}",
    )  # fmt: skip
    assert done.code == 0, done.err
    monkeypatch.chdir(tmp_path)
    exec(kept(version, "add-an-output.md")[1].code, {})
    assert {"started", "done"} <= set(capsys.readouterr().out.split())


class _Enough(Exception):
    """Ends the sender of the page."""


@pytest.mark.parametrize(
    "version",
    [
        v
        for v in VERSIONS
        if any("feed.drain" in b.code for b in kept(v, "write-your-own-sensor.md"))
    ],
)
def test_a_sensor_is_fed_by_the_sender_of_its_page(
    version: str,
    install: Install,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    page = "write-your-own-sensor.md"
    name, _ = put_in(install, version, page)
    with pytest.raises(SourceError, match="There is no sensor udp:first"):
        open_source(f"{name}:first")
    _, send, feed = (block.code for block in kept(version, page))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    pause, lines = time.sleep, iter(range(100))
    is_sent = False

    def sleep(_: float) -> None:
        """Send all lines in the first pause of the page's loop; there are no other ones."""
        nonlocal is_sent
        if is_sent:
            pause(0.001)
        elif next(lines, None) is None:
            raise _Enough
        elif not sys._getframe(1).f_code.co_filename.startswith("send"):
            wait_for_listener(port, pause)
            with pytest.raises(_Enough):
                exec(compile(send.replace("5005", str(port)), "send.py", "exec"), {})
            is_sent = True

    monkeypatch.setattr(time, "sleep", sleep)
    exec(feed.replace('"udp"', f'"udp:{port}"'), {})
    out = capsys.readouterr().out
    assert "state='attached'" in out
    assert int(re.findall(r"(\d+) received", out)[0]) > 0


def wait_for_listener(port: int, pause: Any) -> None:
    """Return as soon as something listens on a UDP port.

    A port without a listener refuses the second of two datagrams. To bind it as a trial would take
    it from the sensor.
    """
    for _ in range(10_000):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
            other.connect(("127.0.0.1", port))
            try:
                other.send(b"")
                other.send(b"")
            except ConnectionRefusedError:
                pause(0.001)
            else:
                return
    raise AssertionError("the sensor does not listen")


@pytest.mark.parametrize("version", [v for v in VERSIONS if kept(v, "export-data.md")])
def test_a_format_writes_its_file(
    version: str, install: Install, call: Call, tmp_path: Path
) -> None:
    name, _ = put_in(install, version, "export-data.md")
    assert call("simulate", "keyboard", "--user", "average", "--attempts", 2).code == 0
    done = call("export", "--all", "--simulated", "--format", name, "--to", tmp_path / "out")
    assert done.code == 0, done.err
    counts = json.loads((tmp_path / "out" / "counts.json").read_text())
    assert counts["attempts"] == 2
    assert counts["trials"] == 40


@each_version
def test_a_theme_is_read_with_what_the_page_declares(version: str, tmp_path: Path) -> None:
    calm = Catalogue().theme_folder("calm")
    words, looks, gestures, manner = (
        block.code for block in kept(version, "themes-and-words.md", "toml")
    )
    phrases, _, _ = (calm / "phrases.en.toml").read_text(encoding="utf-8").partition("[vocabulary]")
    folder = tmp_path / "evening"
    folder.mkdir()
    (folder / "phrases.en.toml").write_text(phrases + words, encoding="utf-8")
    (folder / "theme.toml").write_text("\n".join((looks, gestures, manner)), encoding="utf-8")
    theme = Catalogue(themes=(tmp_path,)).theme("evening")
    declared = tomllib.loads(looks)
    assert (theme.title, theme.summary) == (declared["title"], declared["summary"])
    assert theme.colors.background == declared["colors"]["background"]
    assert theme.gestures["nod"].duration_ms == 900
    assert theme.manners["positive"].gesture == "cheer"
    assert [each for each in theme.repairs if "phrases" in each or "cannot" in each] == []

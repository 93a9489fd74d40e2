"""A plug-in that was written for another API is refused in one sentence that says so."""

from pathlib import Path

import pytest

from sar_tui.api.output import OutputError
from sar_tui.api.sensor import SourceError, open_source
from sar_tui.api.testing import Catalogue, PluginError, load_task
from sar_tui.export import registry
from sar_tui.export.errors import ExportError
from sar_tui.outputs import outputs
from sar_tui.plugins import module_beside
from tests.api.conftest import Install
from tests.documented import write_documented
from tests.program import Call

AFTER_NAME = 'name = "arrows"  # the same as the folder\n'


def arrows(tmp_path: Path, number: str = "", *, head: str = "") -> Path:
    """Return the folder of the documented task, with a number of the API and other first lines."""
    folder = write_documented(tmp_path / "mytasks", "arrows")
    source = (folder / "task.py").read_text(encoding="utf-8")
    assert AFTER_NAME in source
    declared = f"{AFTER_NAME}    {number}\n"
    (folder / "task.py").write_text(head + source.replace(AFTER_NAME, declared), encoding="utf-8")
    return folder


def test_a_task_for_this_api_is_loaded(tmp_path: Path) -> None:
    assert load_task(arrows(tmp_path, "api = 1")).title == "Arrows"


@pytest.mark.parametrize(
    ("number", "head"),
    [
        ("api = 2", ""),
        ("", "api = 2\n"),
        ("api = 2", "from sar_tui.api.task import NoSuchName\n"),
    ],
    ids=["class", "module", "with a name of API 2"],
)
def test_a_task_for_another_api_is_refused(tmp_path: Path, number: str, head: str) -> None:
    with pytest.raises(PluginError) as refused:
        load_task(arrows(tmp_path, number, head=head))
    assert str(refused.value) == (
        "The task arrows was written for API 2; this program has API 1. Update sar-tui."
    )


def test_the_command_line_says_no_more(tmp_path: Path, call: Call) -> None:
    arrows(tmp_path, "api = 2")
    done = call("simulate", "arrows", "--user", "average", "--tasks", tmp_path / "mytasks")
    assert done.code == 2
    assert "was written for API 2; this program has API 1. Update sar-tui." in done.err
    assert "Traceback" not in done.err


def test_a_view_for_another_api_is_refused(tmp_path: Path) -> None:
    folder = arrows(tmp_path)
    (folder / "view.py").write_text(
        "from sar_tui.api.view import TaskView\n\n\nclass View(TaskView):\n    api = 0\n"
    )
    with pytest.raises(PluginError, match="was written for API 0; this program has API 1"):
        module_beside(load_task(folder), "view")


def test_a_node_for_another_api_is_refused_when_its_class_is_made() -> None:
    from sar_tui.api.node import Node

    with pytest.raises(Exception, match=r"^The node twists was written for API 3; "):
        type("Twists", (Node,), {"name": "twists", "api": 3})


def test_an_output_for_another_api_is_refused(install: Install) -> None:
    source = "from sar_tui.api.output import Output\n\n\nclass Lamp(Output):\n    api = 2\n"
    install({"lamp": source + '    name = "lamp"\n'}, "sar_tui.outputs", "lamp", "lamp:Lamp")
    with pytest.raises(OutputError, match=r"^The output lamp was written for API 2; "):
        outputs.check_outputs(["lamp"])


def test_a_sensor_for_another_api_is_refused(install: Install) -> None:
    install({"ball": "class Ball:\n    api = 2\n"}, "sar_tui.inputs", "ball", "ball:Ball")
    with pytest.raises(SourceError, match=r"^The sensor ball was written for API 2; "):
        open_source("ball")


def test_a_format_for_another_api_is_refused(install: Install) -> None:
    install({"rows": "api = 2\n\n\nclass Rows: ...\n"}, "sar_tui.exports", "rows", "rows:Rows")
    with pytest.raises(ExportError, match=r"^The format rows was written for API 2; "):
        registry.load("rows")


@pytest.mark.parametrize("number", [1, 2])
def test_a_theme_says_its_number(tmp_path: Path, number: int) -> None:
    folder = tmp_path / "plain"
    folder.mkdir()
    calm = Catalogue().theme_folder("calm")
    for file in ("theme.toml", "phrases.en.toml"):
        text = (calm / file).read_text(encoding="utf-8")
        (folder / file).write_text(f"api = {number}\n{text}" if file == "theme.toml" else text)
    catalogue = Catalogue(themes=(tmp_path,))
    if number == 1:
        assert not any(catalogue.theme("plain").repairs)
        return
    with pytest.raises(PluginError) as refused:
        catalogue.theme("plain")
    assert str(refused.value) == (
        "The theme plain was written for API 2; this program has API 1. Update sar-tui."
    )

"""Modules that a task's session loads: shared, or its own."""

from pathlib import Path

import pytest

from sar_tui.app.loop_graph import loop_graph
from sar_tui.loop.session import Parts
from sar_tui.plugins import Catalogue
from sar_tui.validation import modularity
from sar_tui.validation.modularity import (
    TASKS,
    Loaded,
    NotLoaded,
    code,
    compared_loops,
    count,
    load,
    node_classes,
)
from sar_tui.validation.report import Conditions
from tests.validation.broken_parts import OwnMemory


def file(folder: Path, name: str, lines: int) -> str:
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    path.write_text("x = 1\n" * lines)
    return str(path)


def test_a_session_loads_what_its_task_needs(catalogue: Catalogue) -> None:
    keyboard, reaching = (set(load(name, catalogue).modules) for name in ("keyboard", "reaching"))
    assert keyboard >= {
        "sar_tui.loop.bus", "sar_tui.loop.nodes.event_handler", "sar_tui.inputs.keyboard",
    }  # fmt: skip
    other = ("sar_tui.motion", "sar_tui.simulation", "sar_tui.store")
    assert not [name for name in keyboard if name.startswith(other)]
    assert reaching >= {
        "sar_tui.inputs.phidget", "sar_tui.inputs.imu_feed", "sar_tui.motion.single_axis",
    }  # fmt: skip
    assert not reaching & {
        "sar_tui.inputs.simulated", "sar_tui.motion.synthesis", "sar_tui.simulation.participant",
    }  # fmt: skip


def test_modules_in_a_tasks_folder_or_loaded_by_it_are_its_own_and_those_of_the_app_shared(
    tmp_path: Path,
) -> None:
    loaded = Loaded(
        modules={
            "sar_tui.loop.bus": file(tmp_path, "bus.py", 10),
            "sar_tui.app.app": file(tmp_path, "app.py", 100),
            "sar_tui_tasks.mine.task": file(tmp_path / "mine", "task.py", 3),
        },
        package="sar_tui_tasks.mine",
        folder=str(tmp_path / "mine"),
    )
    file(tmp_path / "mine", "view.py", 2)
    assert code(loaded).shared == {"sar_tui.loop.bus": 10}
    assert code(loaded).own == {"task.py": 3, "view.py": 2}
    modules = {"lab": file(tmp_path, "lab.py", 4), "laboratory": file(tmp_path, "laboratory.py", 9)}
    external = Loaded(modules=modules, package="lab", folder=str(tmp_path / "none"))
    assert code(external).own == {"lab": 4}


def test_in_the_strict_count_modules_used_by_one_task_are_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, catalogue: Catalogue
) -> None:
    both = {"sar_tui.loop.bus": file(tmp_path, "bus.py", 60)}
    one = both | {"sar_tui.motion.single_axis": file(tmp_path, "robust.py", 20)}

    def loaded(name: str, _: Catalogue) -> Loaded:
        own = {f"{name}.task": file(tmp_path / name, "task.py", 20)}
        return Loaded((one if name == "reaching" else both) | own, name, str(tmp_path / name))

    monkeypatch.setattr(modularity, "load", loaded)
    report = modularity.run(Conditions(catalogue))
    rows = {row["task"]: row for row in report.rows}
    assert (rows["keyboard"]["shared"], rows["keyboard"]["strict_shared"]) == (0.75, 0.75)
    assert (rows["reaching"]["shared"], rows["reaching"]["strict_shared"]) == (0.8, 0.6)
    assert all(claim.holds for claim in report.claims)


def test_a_task_that_shares_too_little_or_does_not_run_fails_the_claim(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, catalogue: Catalogue
) -> None:
    def loaded(name: str, _: Catalogue) -> Loaded:
        if name == "keyboard":
            raise NotLoaded("its session does not end")
        shared = {"sar_tui.loop.bus": file(tmp_path, "bus.py", 60)}
        own = {f"{name}.task": file(tmp_path, "task.py", 40)}
        return Loaded(shared | own, name, str(tmp_path / "none"))

    monkeypatch.setattr(modularity, "load", loaded)
    (claim,) = modularity.run(Conditions(catalogue)).claims
    others = ", ".join(f"{name} 60%" for name in catalogue.task_names() if name != "keyboard")
    assert claim.against == f"{others}, keyboard cannot be counted: its session does not end"


def test_a_task_that_cannot_be_loaded_is_reported(tmp_path: Path) -> None:
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "task.py").write_text("this is no Python")
    with pytest.raises(NotLoaded, match=r"The task broken cannot be loaded: task\.py:1: "):
        load("broken", Catalogue((tmp_path,)))


def test_a_part_that_a_task_lacks_or_replaces_under_its_name_is_told(catalogue: Catalogue) -> None:
    theme = catalogue.theme("calm")
    graphs = {task: loop_graph(catalogue.task(task), theme) for task in TASKS}
    nodes = {task: node_classes(catalogue.task(task), theme) for task in TASKS}
    swapped = {"keyboard": graphs["reaching"], "reaching": graphs["keyboard"]}
    assert "imu" in compared_loops(swapped, nodes).claims[0].against
    own = node_classes(catalogue.task("reaching"), theme, Parts(memory=OwnMemory))
    report = compared_loops(graphs, {**nodes, "reaching": own})
    assert [claim.against for claim in report.claims] == ["", "memory", ""]
    assert [row["part"] for row in report.rows if row["state"] == "changed"] == ["memory"]


@pytest.mark.parametrize(
    ("source", "lines"),
    [
        ("\n\n# a comment\n", 0),
        ('"""Documentation\nof a module."""\n', 0),
        ("a = 1  # with a comment\n\nb = 2\n", 2),
        ("f(\n    1,\n\n    # why\n    2,\n)\n", 4),
        ('a = """one\ntwo\nthree"""\n', 3),
        ('LIMIT = 3\n"""What it is."""\n', 1),
        ('def f():\n    """Does\n    it."""\n', 1),
        ("a = 1; b = 2\n", 1),
    ],
)
def test_only_code_is_counted(source: str, lines: int) -> None:
    assert count(source) == lines

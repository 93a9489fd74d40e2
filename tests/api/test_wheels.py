"""A plug-in of each kind, installed from a wheel of its own, is listed and used by the commands."""

import json
import os
import shutil
import subprocess
import sys
import tomllib
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from sar_tui.plugins import Catalogue
from tests.api.pages import DOCS, blocks
from tests.documented import FILES

Program = Callable[..., subprocess.CompletedProcess[str]]


def make_wheel(folder: Path, group: str, name: str, value: str, files: Mapping[str, str]) -> Path:
    """Write a wheel with an entry point."""
    info = f"plugin_{name.replace('-', '_')}-1.dist-info"
    written = {
        **files,
        f"{info}/METADATA": f"Metadata-Version: 2.1\nName: plugin-{name}\nVersion: 1\n",
        f"{info}/WHEEL": "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
        f"{info}/entry_points.txt": f"[{group}]\n{name} = {value}\n",
    }
    record = f"{info}/RECORD"
    written[record] = "".join(f"{file},,\n" for file in (*written, record))
    path = folder / f"{info.removesuffix('.dist-info')}-py3-none-any.whl"
    with zipfile.ZipFile(path, "w") as wheel:
        for file, text in written.items():
            wheel.writestr(file, text)
    return path


def of_page(folder: Path, page: str, module: str) -> Path:
    """Write the wheel of the plug-in that a page shows, with the entry point that it shows."""
    found = blocks((DOCS / page).read_text(encoding="utf-8"))
    toml = next(block.code for block in found if "entry-points" in block.code)
    code = next(block.code for block in found if block.language == "python")
    ((group, points),) = tomllib.loads(toml)["project"]["entry-points"].items()
    ((name, value),) = points.items()
    _, _, attribute = value.partition(":")
    return make_wheel(folder, group, name, f"{module}:{attribute}", {f"{module}.py": code})


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Program:
    """Run a command where six wheels are installed."""
    folder = tmp_path_factory.mktemp("wheels")
    calm = Catalogue().theme_folder("calm")
    theme = {f"dusk/{file.name}": file.read_text("utf-8") for file in calm.glob("*.toml")}
    theme["dusk/__init__.py"] = ""
    task = {"arrows_task.py": FILES["arrows", "task.py"]}
    wheels = (
        make_wheel(folder, "sar_tui.tasks", "arrows", "arrows_task:Arrows", task),
        make_wheel(folder, "sar_tui.themes", "dusk", "dusk", theme),
        of_page(folder, "add-an-output.md", "serial_robot"),
        of_page(folder, "write-your-own-sensor.md", "udp_sensor"),
        of_page(folder, "export-data.md", "counts"),
        of_page(folder, "write-a-policy.md", "two_thresholds"),
    )
    site = folder / "site"
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-index", "--no-deps"]
    subprocess.run(
        [*pip, "--disable-pip-version-check", "--target", site, *wheels],
        check=True,
        capture_output=True,
    )

    def run(*arguments: object, without: str = "") -> subprocess.CompletedProcess[str]:
        path = site
        if without:
            path = folder / f"without-{without}"
            ignored = shutil.ignore_patterns(f"*{without}*")
            shutil.copytree(site, path, ignore=ignored, dirs_exist_ok=True)
        return subprocess.run(
            [sys.executable, *map(str, arguments)],
            env=os.environ | {"PYTHONPATH": str(path), "SAR_TUI_DATA": str(folder / "data")},
            cwd=folder,
            capture_output=True,
            text=True,
            check=False,
        )

    return run


@pytest.mark.slow
def test_each_is_listed(program: Program) -> None:
    tasks = json.loads(program("-m", "sar_tui", "tasks", "--json").stdout)["tasks"]
    assert "arrows" in {row["name"] for row in tasks}
    themes = json.loads(program("-m", "sar_tui", "themes", "--json").stdout)["themes"]
    assert "dusk" in {row["name"] for row in themes}
    checks = json.loads(program("-m", "sar_tui", "doctor", "--json").stdout)["checks"]
    found = {row["name"]: row["found"] for row in checks}
    assert "robot" in found["Outputs"]
    assert "two-thresholds" in found["Policies"]
    unknown = program("-m", "sar_tui", "export", "--all", "--format", "none")
    assert "counts" in unknown.stderr
    source = "from sar_tui.api.sensor import open_source\nprint(open_source('udp').info)\n"
    assert program("-c", source).stdout == "None\n"


@pytest.mark.slow
def test_a_session_uses_them_and_is_exported_and_replayed(program: Program, tmp_path: Path) -> None:
    line = tmp_path / "line"
    line.touch()
    settings = (
        "difficulty_policy=two-thresholds",
        "thresholds_up=1",
        "thresholds_down=0",
        f"outputs=screen robot:{line}",
    )
    done = program(
        *("-m", "sar_tui", "simulate", "arrows", "--user", "competent", "--theme", "dusk"),
        *("--attempts", 3, "--seed", 1),
        *(word for setting in settings for word in ("--set", setting)),
    )
    assert done.returncode == 0, done.stderr
    shown = json.loads(program("-m", "sar_tui", "show", "last", "--json").stdout)
    assert [row["level"] for row in shown["attempts"]] == [1, 2, 3]
    assert "wave" in line.read_text()
    assert json.loads(program("-m", "sar_tui", "replay", "last", "--json").stdout)["identical"]
    to = tmp_path / "out"
    exported = program(
        *("-m", "sar_tui", "export", "--all", "--simulated", "--format", "counts", "--to", to)
    )
    assert exported.returncode == 0, exported.stderr
    assert json.loads((to / "counts.json").read_text())["attempts"] == 3

    refused = program("-m", "sar_tui", "replay", "last", without="two_thresholds")
    assert (
        "There is no difficulty policy two-thresholds here: install the package" in refused.stderr
    )
    assert "Traceback" not in refused.stderr
    for kept in (("show", "last"), ("export", "--all", "--simulated", "--to", tmp_path / "csv")):
        assert program("-m", "sar_tui", *kept, without="two_thresholds").returncode == 0


def test_two_packages_that_offer_the_same_are_told(tmp_path: Path) -> None:
    for package in ("one", "two"):
        info = tmp_path / f"{package}-1.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1\n")
        (info / "entry_points.txt").write_text("[sar_tui.tasks]\ndots = dots:Dots\n")
    done = subprocess.run(
        [sys.executable, "-m", "sar_tui", "tasks", "show", "dots"],
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (
        "Several packages offer the task dots: one and two. Uninstall all but one." in done.stderr
    )

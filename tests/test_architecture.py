"""docs/architecture.md names every package, no other, in the order that import-linter enforces; its
paths exist.
"""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| (\d+) \| `([\w/.]+)` \|", PAGE, re.MULTILINE)


def module(path: str) -> str:
    return path.removesuffix(".py").rstrip("/").replace("/", ".")


def test_every_package_has_a_row_and_every_row_a_package() -> None:
    inside = [path for path in (ROOT / "sar_tui").iterdir() if not path.name.startswith("__")]
    packages = {f"sar_tui/{path.name}/" for path in inside if (path / "__init__.py").is_file()}
    modules = {f"sar_tui/{path.name}" for path in inside if path.suffix == ".py"}
    assert {path for _, path in ROWS} == packages | modules | {"tasks/"}
    assert modules == {
        "sar_tui/plugins.py",
        "sar_tui/plugin_calls.py",
        "sar_tui/plugin_loader.py",
    }, "others belong into a package"


def test_the_layers_are_those_that_are_enforced() -> None:
    linter = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"][
        "importlinter"
    ]
    layers = next(
        contract["layers"] for contract in linter["contracts"] if contract["type"] == "layers"
    )
    enforced = [{name.strip() for name in layer.split("|")} for layer in layers]
    floors = sorted({int(floor) for floor, _ in ROWS}, reverse=True)
    assert [
        {module(path) for floor, path in ROWS if int(floor) == here} for here in floors
    ] == enforced


def test_every_path_on_the_page_exists() -> None:
    named = {
        path for path in re.findall(r"`([\w./*-]+)`", PAGE) if "/" in path or path.endswith(".py")
    }
    missing = [path for path in named if not _exists(path)]
    assert missing == []


def _exists(path: str) -> bool:
    if "*" in path:
        return any(ROOT.glob(path))
    if path in ("task.py", "view.py"):
        return any(ROOT.glob(f"tasks/*/{path}"))
    return any((ROOT / start / path).exists() for start in ("", "sar_tui"))

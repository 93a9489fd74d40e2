"""A plug-in as if it were installed: its modules, with their entry points."""

import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import pytest

Install = Callable[[Mapping[str, str], str, str, str], None]


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Install]:
    """Install modules by their name, with one entry point: group, name, value."""
    made: list[str] = []

    def put(modules: Mapping[str, str], group: str, name: str, value: str) -> None:
        site = tmp_path / f"site-{len(made)}"
        info = site / f"plugin_{name}-1.dist-info"
        info.mkdir(parents=True)
        for module, source in modules.items():
            path = site / f"{module.replace('.', '/')}.py"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(source, encoding="utf-8")
            made.append(module)
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: plugin-{name}\nVersion: 1\n")
        (info / "entry_points.txt").write_text(f"[{group}]\n{name} = {value}\n")
        monkeypatch.syspath_prepend(str(site))

    yield put
    for module in made:
        for name in (module, module.partition(".")[0]):
            sys.modules.pop(name, None)

"""In a folder of many sites each export replaces its site's files, wholly or not at all, and no
others.
"""

import os
import shutil
from pathlib import Path

import pytest

from sar_tui.export.errors import ExportError
from sar_tui.export.sites import about, site_target
from sar_tui.export.target import sync, write_manifest


def made(
    folder: Path, site: str, text: str, tables: tuple[str, ...] = ("trials", "sessions")
) -> None:
    """Make an export of a site: a file a table, and its manifest."""
    with site_target(folder, site) as hidden:
        for table in tables:
            place = hidden / table / f"site={site}"
            place.mkdir(parents=True)
            (place / f"{table}-{site}.parquet").write_text(text)
        (hidden / about(site)).mkdir(parents=True)
        (hidden / about(site) / "methods.md").write_text(text)
        write_manifest(hidden, about(site), format="parquet", sessions=[])
        sync(hidden)


def held(folder: Path, site: str) -> dict[str, str]:
    """Return the texts of a site's files."""
    return {
        path.parts[-3]: path.read_text()
        for path in folder.glob(f"*/site={site}/*")
        if path.name != "sar-tui-export.json"
    }


def both(text: str) -> dict[str, str]:
    return {"trials": text, "sessions": text, "_sites": text}


def test_a_site_replaces_its_own_files_only(tmp_path: Path) -> None:
    made(tmp_path / "lake", "BERN", "old", ("trials", "sessions", "events"))
    made(tmp_path / "lake", "BERN-2", "other")
    made(tmp_path / "lake", "BERN", "new")
    assert held(tmp_path / "lake", "BERN") == both("new"), (
        "a table that is not exported any more is gone"
    )
    assert held(tmp_path / "lake", "BERN-2") == both("other")
    assert sorted(path.name for path in (tmp_path / "lake").glob(".site=*")) == []


@pytest.mark.skipif(os.name != "posix", reason="kills a process")
def test_a_program_that_is_killed_at_any_moment_leaves_a_site_old_or_new(tmp_path: Path) -> None:
    made(tmp_path / "before", "BERN", "old", ("trials", "sessions", "events"))
    found = []
    for moment in range(99):
        lake = tmp_path / f"lake{moment}"
        shutil.copytree(tmp_path / "before", lake)
        if not killed_at_a_move(lake, moment):
            break
        made(lake, "ULM", "ulm")
        found.append(held(lake, "BERN"))
        assert held(lake, "ULM") == both("ulm")
        made(lake, "BERN", "newer")
        assert held(lake, "BERN") == both("newer")
        assert list(lake.glob(".site=*")) == []
    old = both("old") | {"events": "old"}
    assert [each for each in found if each not in (old, both("new"))] == []
    assert (found[0], found[-1]) == (old, both("new"))


def killed_at_a_move(lake: Path, moment: int) -> bool:
    """Export in another process, which is killed before it moves a file for the nth time; False if
    it moves fewer.
    """
    if child := os.fork():
        return os.waitpid(child, 0)[1] != 0
    moves = iter(range(moment))
    rename = Path.rename

    def move(path: Path, to: Path) -> Path:
        if next(moves, None) is None:
            os._exit(9)
        return rename(path, to)

    Path.rename = move  # type: ignore[method-assign]
    made(lake, "BERN", "new")
    os._exit(0)


def test_a_failure_leaves_the_earlier_export_whole(tmp_path: Path) -> None:
    made(tmp_path / "lake", "BERN", "old")
    with pytest.raises(OSError, match="full"), site_target(tmp_path / "lake", "BERN"):
        raise OSError("full")
    assert held(tmp_path / "lake", "BERN") == both("old")
    assert list((tmp_path / "lake").glob(".site=*")) == []


def test_other_files_are_never_touched(tmp_path: Path) -> None:
    lake = tmp_path / "lake"
    made(lake, "BERN", "old")
    (lake / "trials" / "site=BERN" / "mine.R").write_text("x")
    with pytest.raises(ExportError, match=r"trials/site=BERN/mine\.R"):
        made(lake, "BERN", "new")
    made(lake, "ULM", "new")
    (lake / "plots").mkdir()
    (lake / "plots" / "trials.svg").write_text("x")
    with pytest.raises(ExportError, match=r"plots/trials\.svg"):
        made(lake, "ULM", "newer")
    assert held(lake, "ULM") == both("new")
    assert (lake / "trials" / "site=BERN" / "mine.R").read_text() == "x"

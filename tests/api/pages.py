"""Code on the pages for authors of plug-ins: read, and kept with each release.

``python -m tests.api.pages 0.3.0`` keeps that of the present pages in the folder of that version.
"""

import re
import sys
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parent
DOCS = HERE.parents[1] / "docs"
KEPT = (
    "add-an-output.md",
    "export-data.md",
    "themes-and-words.md",
    "write-a-policy.md",
    "write-a-node.md",
    "write-your-own-sensor.md",
    "write-your-own-task.md",
)
"""The pages with code that later versions have to run."""
VERSIONS = sorted(path.name for path in HERE.iterdir() if (path / KEPT[0]).is_file())


class Block(NamedTuple):
    """A block of code. ``lead``: the line before it, which may name its file."""

    lead: str
    language: str
    code: str


def blocks(text: str) -> list[Block]:
    """Return the blocks of a page."""
    return [
        Block(*found)
        for found in re.findall(r"([^\n]*)\n\n```(\w+)\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    ]


def python_blocks(text: str) -> list[str]:
    """Return the Python code of a page, block by block."""
    return [block.code for block in blocks(text) if block.language == "python"]


def kept(version: str, page: str, language: str = "python") -> list[Block]:
    """Return the blocks of a language on a page of a version; none if it had no such page."""
    path = HERE / version / page
    found = blocks(path.read_text(encoding="utf-8")) if path.is_file() else []
    return [block for block in found if block.language == language]


def task_files(version: str) -> dict[str, dict[str, str]]:
    """Return the files of the tasks of a version, by task and name."""
    found: dict[str, dict[str, str]] = {}
    for page in ("write-your-own-task.md", "write-a-node.md"):
        for language in ("python", "toml"):
            for block in kept(version, page, language):
                if named := re.search(r"`mytasks/(\w+)/([\w.]+)`", block.lead):
                    found.setdefault(named[1], {})[named[2]] = block.code
    return found


def keep(version: str) -> None:
    """Write the blocks of the present pages into the folder of a version."""
    folder = HERE / version
    folder.mkdir()
    for page in KEPT:
        found = blocks((DOCS / page).read_text(encoding="utf-8"))
        text = "\n".join(
            f"{block.lead}\n\n```{block.language}\n{block.code}```\n"
            for block in found
            if block.language in ("python", "toml")
        )
        (folder / page).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    keep(sys.argv[1])

"""Tasks of docs/write-your-own-task.md and docs/write-a-node.md, and parts of them, taken from the
pages; and those of written_tasks.md, which only tests play.
"""

import re
from pathlib import Path

DOCS = Path(__file__).parents[1] / "docs"
_NAMES = ("write-your-own-task.md", "task-reference.md", "write-a-node.md")
PAGES = [(DOCS / name).read_text(encoding="utf-8") for name in _NAMES]
_WRITTEN = Path(__file__).with_name("written_tasks.md").read_text(encoding="utf-8")
FILES = {
    (name, file): source
    for page in (*PAGES, _WRITTEN)
    for name, file, source in re.findall(
        r"`mytasks/(\w+)/([\w.]+)`[^`]*?\n\n```\w+\n(.*?)```", page, re.DOTALL
    )
}
"""Source of each file of a task on the pages, by the task's name and the file's."""
FRAGMENTS = [
    source
    for page in PAGES
    for source in re.findall(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    if source not in FILES.values()
]
"""Code of the pages that is a part of a task."""
TASKS = sorted(name for name, file in FILES if file == "task.py")


def write_documented(folder: Path, name: str, *files: str) -> Path:
    """Write the files of a task into a folder of tasks as the page has them, and return the task's
    folder.
    """
    task = folder / name
    task.mkdir(parents=True)
    for file in files or ("task",):
        (task / f"{file}.py").write_text(FILES[name, f"{file}.py"], encoding="utf-8")
    return task

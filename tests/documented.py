"""Tasks of docs/write-your-own-task.md, taken from the page."""

import re
from pathlib import Path

PAGE = (Path(__file__).parents[1] / "docs" / "write-your-own-task.md").read_text(encoding="utf-8")


def write_documented(folder: Path, name: str, *files: str) -> Path:
    """Write the files of a task into a folder of tasks as the page has them, and return the task's folder."""
    task = folder / name
    task.mkdir(parents=True)
    for file in files or ("task",):
        (source,) = re.findall(rf"`mytasks/{name}/{file}\.py`[^`]*?\n\n```python\n(.*?)```", PAGE, re.DOTALL)
        (task / f"{file}.py").write_text(source, encoding="utf-8")
    return task

"""Pictures of a task in the provenance of its sessions."""

import hashlib
from pathlib import Path

from sar_tui.loop.task import Task
from sar_tui.store.provenance import software


def test_each_picture_of_a_task_has_its_hash(tmp_path: Path, keyboard: type[Task]) -> None:
    (tmp_path / "task.py").write_text("", encoding="utf-8")
    for code in (tmp_path, tmp_path / "task.py"):
        assert "pictures" not in software(keyboard, "own", code, tmp_path)["task"]
    (tmp_path / "pictures").mkdir()
    (tmp_path / "pictures" / "cat.PNG").write_bytes(b"a cat")
    found = software(keyboard, "own", tmp_path, tmp_path)["task"]
    assert found["pictures"] == {"pictures/cat.PNG": hashlib.sha256(b"a cat").hexdigest()}

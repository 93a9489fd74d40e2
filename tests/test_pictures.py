"""The pictures of the documentation can be drawn from the app."""

from pathlib import Path

import pytest

from docs import pictures


@pytest.mark.slow
async def test_each_picture_is_drawn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    present = sorted(path.name for path in pictures.IMAGES.glob("*.svg"))
    monkeypatch.setattr(pictures, "IMAGES", tmp_path)
    await pictures._draw()
    assert sorted(path.name for path in tmp_path.iterdir()) == present

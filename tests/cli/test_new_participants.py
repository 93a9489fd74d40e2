"""A code that nobody has is asked about, or needs --new: a typing error would divide a person's
record.
"""

from pathlib import Path
from typing import Any

import pytest

from tests.app.app_driver import known
from tests.program import Call

SCORE = "record add FMA-UE {} score=34 --on 2026-03-01"
RECORDS = (
    SCORE,
    "record add adverse-event {} what=Fell severity=mild --on 2026-03-01",
    "programme import {} keyboard --preset mild --reason first",
)


@pytest.mark.parametrize("record", RECORDS)
def test_a_code_that_nobody_has_is_refused_with_the_nearest_or_needs_new(
    call: Call, data: Path, record: str
) -> None:
    known(data, "P01")
    call("simulate keyboard --user average --attempts 1 -p P08")
    call(record.format("P08")).refused("add --new")  # only simulated people have this code
    said = "There is no participant P0L: give P01 if that is meant, or add --new for a new"
    call(record.format("p0l")).refused(said)
    assert call(record.format("P09"), "--new").code == 0
    assert call(record.format("p09")).code == 0
    call(record.format("P09"), "--new").refused("P09 is known here already: leave out --new")
    assert call("check").code == 0
    assert call("backup --verify").code == 0


def test_on_a_terminal_it_is_asked(call: Call, data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []

    def confirm(question: str, **_: Any) -> bool:
        asked.append(question)
        return "P77" in question

    monkeypatch.setattr("sar_tui.cli.common.is_interactive", lambda: True)
    monkeypatch.setattr("sar_tui.cli.common.typer.confirm", confirm)
    known(data, "P01")
    refused = call(SCORE.format("P0l"))
    assert (refused.code, refused.err) == (1, "Nothing was done.\n")
    assert call(SCORE.format("P77")).code == 0
    assert asked == [
        "There is no participant P0L. Is it P01? Is P0L a new participant?",
        "There is no participant P77. Is P77 a new participant?",
    ]
    assert "P0L" not in call("progress P77").out
    assert call("record add FMA-UE P09 score=900 --new").code == 2
    assert call("progress P09").code == 2, "a value that cannot be makes no participant"


def test_each_command_that_looks_for_a_code_names_the_nearest(call: Call, data: Path) -> None:
    known(data, "P01")
    for command in (
        "sessions -p", "progress", "record list -p", "programme show", "programme history",
        "report wizard -p", "report intervention -p", "export -p",
    ):  # fmt: skip
        call(command, "P0l").refused("There is no participant P0L. Is it P01?")

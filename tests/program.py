"""The program called as a person calls it, in this process, with a data folder of its own."""

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from sar_tui.cli import main


class Called(NamedTuple):
    """Result of a call of the program."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        return json.loads(self.out)

    def refused(self, *said: str, code: int = 2) -> None:
        """Assert that nothing was printed but an error with each of these texts."""
        assert (self.code, self.out) == (code, ""), self
        words = " ".join(self.err.split())
        assert not [text for text in said if text not in words], (said, words)

    def shows(self, *said: str, code: int = 0) -> None:
        """Assert that each of these texts was printed, and no error."""
        assert (self.code, self.err) == (code, ""), self
        assert not [text for text in said if text not in self.out], (said, self.out)


Call = Callable[..., Called]


@pytest.fixture
def call(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Call:
    """``call("simulate keyboard --user poor", "-p", code)``: the first argument is split into words.
    The data is in ``tmp_path / "data"``.
    """
    monkeypatch.setenv("SAR_TUI_DATA", str(tmp_path / "data"))
    monkeypatch.setenv("COLUMNS", "160")
    monkeypatch.setenv("TERM", "xterm-256color")
    names = "SAR_TUI_DEBUG NO_COLOR FORCE_COLOR SSH_CONNECTION SSH_TTY SSH_CLIENT TMUX STY"
    for name in names.split():
        monkeypatch.delenv(name, raising=False)

    def program(command: object = "", *arguments: object) -> Called:
        words = [*str(command).split(), *map(str, arguments)]
        monkeypatch.setattr(sys, "argv", ["sar-tui", *words])
        capsys.readouterr()
        with pytest.raises(SystemExit) as ended:
            main()
        captured = capsys.readouterr()
        return Called(int(ended.value.code or 0), captured.out, captured.err)

    return program


@pytest.fixture
def simulated(call: Call) -> str:
    """A short simulated session; its id."""
    called = call("simulate keyboard --user average --seed 1 --attempts 4 -p p01 --json")
    return str(called.json["session"])

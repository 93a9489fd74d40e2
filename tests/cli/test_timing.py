"""``sar-tui timing``: the verdict on a machine, and what is stored."""

import json
import stat
import sys
from itertools import cycle
from pathlib import Path
from typing import Any

import pytest

from sar_tui.timing import verdict
from sar_tui.timing.closed_loop import BASELINE, SAR_TUI, Trial
from sar_tui.timing.scripted_participant import NoPrompt
from sar_tui.timing.verdict import Circumstances, ErrorStatistics, error_statistics, judge
from tests.program import Call

GOOD = error_statistics([0.2, 0.3, 0.25, 0.3, 0.2])
KEPT = {"measured_at", "trials", "median_ms", "sd_ms", "robust_sd_ms", "p99_ms", "verdict"}


def figures(median: float = 0.3, robust: float = 0.1, p99: float = 1.0) -> ErrorStatistics:
    return ErrorStatistics(100, median, median, robust, robust, robust, p99, p99)


def measures(
    monkeypatch: pytest.MonkeyPatch, errors: list[float], bare: list[float], source: str = "flush"
) -> None:
    """Fake the measurement with these errors; `make bench` runs the real one."""
    given = {SAR_TUI.name: cycle(errors), BASELINE.name: cycle(bare)}
    stamp = {"onset_source": source}

    def take_turns(programs: Any, trials: int, *_: Any) -> dict[str, list[Trial]]:
        names = [program.name for program in programs]
        return {name: [Trial(next(given[name]), stamp) for _ in range(trials)] for name in names}

    monkeypatch.setattr(verdict, "take_turns", take_turns)


# --- the verdict


@pytest.mark.parametrize(
    ("measured", "here", "expected", "word"),
    [
        ({}, {}, "fit", ""),
        ({"robust": 1.0, "median": 1.0, "p99": 5.0}, {}, "fit", ""),
        ({"robust": 1.1}, {}, "fit with care", "scatter by 1.1 ms"),
        ({"robust": 3.1}, {}, "not fit", "scatter by 3.1 ms"),
        ({"median": -2.0}, {}, "fit with care", "off by -2.0 ms"),
        ({"median": 3.5}, {}, "not fit", "off by 3.5 ms"),
        ({"p99": 6.0}, {}, "fit with care", "in a hundred is off by 6.0 ms"),
        ({"p99": 21.0}, {}, "not fit", "in a hundred is off by 21.0 ms"),
        ({}, {"ssh": True}, "not fit", "SSH"),
        ({}, {"multiplexer": "tmux"}, "fit with care", "tmux"),
        ({}, {"clock_step": 0.0156}, "not fit", "15.6 ms"),
        ({}, {"stamped_at_flush": 0.99}, "fit with care", "stamped"),
        ({"robust": 2.0}, {"load": 3.2, "cores": 2}, "fit with care", "load 3.2 on 2 cores"),
        ({}, {"load": 3.2, "cores": 2}, "fit", ""),
    ],
)
def test_the_worst_figure_and_the_circumstances_decide_and_are_named(
    measured: dict[str, float], here: dict[str, Any], expected: str, word: str
) -> None:
    found, reasons = judge(figures(**measured), GOOD, Circumstances(**here))
    assert (found, reasons == [], word in " ".join(reasons)) == (expected, not word, True)


def test_the_baseline_shows_whether_the_machine_or_the_program_is_the_cause() -> None:
    assert "is the machine" in " ".join(judge(figures(p99=9), figures(p99=9), Circumstances())[1])
    assert "please report it" in " ".join(judge(figures(p99=9), GOOD, Circumstances())[1])


# --- the command


def test_the_verdict_is_printed_and_the_figures_are_stored_for_the_user_alone(
    call: Call, monkeypatch: pytest.MonkeyPatch, data: Path
) -> None:
    measures(monkeypatch, [0.2, 0.3, 0.4], [0.1, 0.2])
    called = call("timing --trials 12")
    called.shows("This machine is fit for an experiment", "sar-tui", "a bare loop", "keyboard")
    (path,) = data.iterdir()
    assert (path.name, stat.S_IMODE(path.stat().st_mode)) == ("timing.json", 0o600)
    kept = json.loads(path.read_text())
    assert (set(kept), kept["trials"]) == (KEPT, 12)
    found = call("timing --trials 30 --json").json["timing"]
    assert set(found) == KEPT | {"reasons", "bare"}
    assert [found[name] for name in ("trials", "median_ms", "verdict")] == [30, 0.3, "fit"]
    assert (found["reasons"], found["bare"]["median_ms"]) == ([], 0.15)
    monkeypatch.setenv("SSH_CONNECTION", "somewhere")
    assert "not fit for an experiment" in call("timing").out
    monkeypatch.delenv("SSH_CONNECTION")
    measures(monkeypatch, [0.2, 0.3], [0.2, 0.1], "refresh")
    assert call("timing --json").json["timing"]["verdict"] == "fit with care"


def test_a_measurement_that_fails_is_1_and_a_sentence(
    call: Call, monkeypatch: pytest.MonkeyPatch, data: Path
) -> None:
    def fails(*_: object) -> None:
        raise NoPrompt("No prompt has come.")

    monkeypatch.setattr(verdict, "take_turns", fails)
    said = "Timing could not be measured. No prompt has come."
    call("timing").refused(said, code=1)
    assert not (data / "timing.json").exists()
    monkeypatch.setattr(sys, "platform", "win32")
    call("timing").refused("Windows", code=1)

"""``sar-tui timing``: the verdict on a machine, and what is stored."""

import json
import stat
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from sar_tui.timing import verdict
from sar_tui.timing.closed_loop import BASELINE, SAR_TUI, Program, Trial
from sar_tui.timing.scripted_participant import NoPrompt
from sar_tui.timing.verdict import Circumstances, ErrorStatistics, error_statistics, judge
from tests.program import Call

GOOD = error_statistics([0.2, 0.3, 0.25, 0.3, 0.2])
KEPT = {"measured_at", "trials", "median_ms", "sd_ms", "robust_sd_ms", "p99_ms", "verdict"}


def figures(median: float = 0.3, robust: float = 0.1, p99: float = 1.0) -> ErrorStatistics:
    return ErrorStatistics(100, median, median, robust, robust, robust, p99, p99)


def measures(
    errors: dict[str, list[float]], source: str = "flush"
) -> Callable[..., dict[str, list[Trial]]]:
    """Return a fake measurement with these errors; `make bench` runs the real one."""

    def take_turns(
        programs: Sequence[Program],
        trials: int,
        blocks: int,
        folder: Path,
        on_press: Callable[[str], None],
    ) -> dict[str, list[Trial]]:
        return {
            program.name: [
                Trial(
                    errors[program.name][number % len(errors[program.name])],
                    {"onset_source": source},
                )
                for number in range(trials)
            ]
            for program in programs
        }

    return take_turns


@pytest.fixture
def fine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        verdict, "take_turns", measures({SAR_TUI.name: [0.2, 0.3, 0.4], BASELINE.name: [0.1, 0.2]})
    )


# --- the verdict


def test_small_errors_at_a_local_terminal_are_fit() -> None:
    assert judge(figures(), GOOD, Circumstances()) == ("fit", [])


@pytest.mark.parametrize(
    ("measured", "expected", "word"),
    [
        (figures(robust=1.0, median=1.0, p99=5.0), "fit", ""),
        (figures(robust=1.1), "fit with care", "scatter by 1.1 ms"),
        (figures(robust=3.1), "not fit", "scatter by 3.1 ms"),
        (figures(median=-2.0), "fit with care", "off by -2.0 ms"),
        (figures(median=3.5), "not fit", "off by 3.5 ms"),
        (figures(p99=6.0), "fit with care", "in a hundred is off by 6.0 ms"),
        (figures(p99=21.0), "not fit", "in a hundred is off by 21.0 ms"),
    ],
)
def test_the_worst_figure_decides_and_is_named(
    measured: ErrorStatistics, expected: str, word: str
) -> None:
    found, reasons = judge(measured, GOOD, Circumstances())
    assert found == expected
    assert word in " ".join(reasons)


@pytest.mark.parametrize(
    ("here", "expected", "word"),
    [
        (Circumstances(ssh=True), "not fit", "SSH"),
        (Circumstances(multiplexer="tmux"), "fit with care", "tmux"),
        (Circumstances(clock_step=0.0156), "not fit", "15.6 ms"),
        (Circumstances(stamped_at_flush=0.99), "fit with care", "stamped"),
    ],
)
def test_circumstances_that_no_figure_shows_affect_the_verdict(
    here: Circumstances, expected: str, word: str
) -> None:
    found, reasons = judge(figures(), GOOD, here)
    assert found == expected
    assert word in " ".join(reasons)


def test_a_busy_machine_is_reported_as_the_cause_of_bad_figures_only() -> None:
    busy = Circumstances(load=3.2, cores=2)
    assert "load 3.2 on 2 cores" in " ".join(judge(figures(robust=2), GOOD, busy)[1])
    assert judge(figures(), GOOD, busy) == ("fit", [])


def test_the_baseline_shows_whether_the_machine_or_the_program_is_the_cause() -> None:
    assert "is the machine" in " ".join(judge(figures(p99=9), figures(p99=9), Circumstances())[1])
    assert "please report it" in " ".join(judge(figures(p99=9), GOOD, Circumstances())[1])


# --- the command


@pytest.mark.usefixtures("fine")
def test_it_says_in_words_whether_the_machine_is_fit(call: Call) -> None:
    called = call("timing")
    assert called.code == 0
    assert "This machine is fit for an experiment" in called.out
    for word in ("sar-tui", "a bare loop", "robust SD", "p99", "keyboard"):
        assert word in called.out


@pytest.mark.usefixtures("fine")
def test_json_holds_the_figures_the_reasons_and_the_bare_loop(call: Call) -> None:
    found = call("timing --trials 30 --json").json["timing"]
    assert set(found) == KEPT | {"reasons", "bare"}
    assert (found["trials"], found["median_ms"], found["verdict"], found["reasons"]) == (
        30,
        0.3,
        "fit",
        [],
    )
    assert found["bare"]["median_ms"] == 0.15


@pytest.mark.usefixtures("fine")
def test_the_figures_are_stored_for_later_sessions_and_readable_only_by_the_user(
    call: Call, tmp_path: Path
) -> None:
    call("timing")
    call("timing --trials 12")
    path = tmp_path / "data" / "timing.json"
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    kept = json.loads(path.read_text())
    assert set(kept) == KEPT
    assert kept["trials"] == 12
    assert [file.name for file in path.parent.iterdir()] == ["timing.json"]


def test_onsets_not_stamped_at_flush_are_reported(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        verdict,
        "take_turns",
        measures({SAR_TUI.name: [0.2, 0.3], BASELINE.name: [0.2, 0.1]}, "refresh"),
    )
    assert call("timing --json").json["timing"]["verdict"] == "fit with care"


@pytest.mark.usefixtures("fine")
def test_over_ssh_a_machine_is_not_fit(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SSH_CONNECTION", "somewhere")
    assert "not fit for an experiment" in call("timing").out


def test_a_measurement_that_fails_is_1_and_a_sentence(
    call: Call, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def fails(*_: object) -> None:
        raise NoPrompt("No prompt has come.")

    monkeypatch.setattr(verdict, "take_turns", fails)
    called = call("timing")
    assert (called.code, called.out) == (1, "")
    assert called.err == "Timing could not be measured. No prompt has come.\n"
    assert not (tmp_path / "data" / "timing.json").exists()


def test_windows_is_1_and_a_sentence(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "win32")
    called = call("timing")
    assert called.code == 1
    assert "Windows" in called.err

"""A session that was cut off is completed by a later run."""

import shutil
from contextlib import closing
from pathlib import Path
from typing import Any

import msgspec
import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.topics import SESSION, WAITING
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue
from sar_tui.reports.deviations import deviations
from sar_tui.reports.logged_messages import read
from sar_tui.runs.plan import make_plan
from sar_tui.runs.run import Run, resume, start
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from sar_tui.store.database import StoreError, connect
from tests.played import play, somebody

CATALOGUE = Catalogue()
KEYBOARD = CATALOGUE.task("keyboard")
SETTINGS = {"attempts": 3, "prompts_per_attempt": 4, "start_level": 5}
PLAN = make_plan(CATALOGUE, KEYBOARD, ["P01"], SETTINGS, seed=4)


def begun(data: Path, seed: int = 4, steps: int | None = None, **changed: Any) -> Run:
    """Start a session, and do a number of its steps, or all."""
    clock = VirtualClock()
    plan = msgspec.structs.replace(PLAN, seed=seed, **changed)
    run = start(plan, data, CATALOGUE, clock, somebody)
    play(run, clock, steps)
    return run


def resumed(
    data: Path, run: Run, steps: int | None = None, catalogue: Catalogue = CATALOGUE
) -> Run:
    clock = VirtualClock((run.number + 1) * 1000 * SECOND)
    again = resume(run.id, data, catalogue, clock, somebody)
    play(again, clock, steps)
    return again


def test_each_run_stores_its_software_and_machine(
    data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("SSH_CONNECTION", "SSH_TTY", "SSH_CLIENT", "TMUX", "STY", "ZELLIJ"):
        monkeypatch.delenv(name, raising=False)
    run = begun(data, steps=5)
    monkeypatch.setenv("SSH_TTY", "/dev/pts/0")
    resumed(data, run, 5)
    session = sessions.find(connect(data), data, run.id)
    local, ssh = sessions.rows(connect(data), "runs", run.id)
    assert (local["software"], local["machine"]) == (session["software"], session["machine"])
    assert (local["machine"]["flags"], ssh["machine"]["flags"]) == ([], ["ssh"])
    assert ssh["software"] == local["software"]


def test_a_session_that_has_ended_cannot_be_resumed(data: Path) -> None:
    session = begun(data).id
    with pytest.raises(StoreError, match="is completed; only a live one") as caught:
        resume(session, data, CATALOGUE, VirtualClock(), somebody)
    assert caught.value.bad_input


# --- earlier best results


def best_known(data: Path, run: Run) -> dict[str, float]:
    """Return the earlier best results that a run started with, by level."""
    started = [r.message for r in sessions.history(connect(data), run.id) if r.topic is SESSION]
    (best,) = [one.best for one in started if one.run == run.number]
    return dict(best)


def best_of(data: Path, *names: str) -> dict[str, float]:
    best: dict[str, float] = {}
    for name in names:
        for row in sessions.rows(connect(data), "attempts", name):
            if row["metric"] is not None and row["accuracy"] >= 0.8:
                level = str(row["level"])
                best[level] = min(best.get(level, row["metric"]), row["metric"])
    return best


def test_a_session_gets_the_best_of_the_participants_earlier_ones_by_level(data: Path) -> None:
    first, second = begun(data, 1), begun(data, 2)
    begun(data, 3, participant="P02")
    third = begun(data, 4)
    assert best_known(data, first) == {}
    assert best_known(data, second) == best_of(data, first.id)
    assert best_known(data, third) == best_of(data, first.id, second.id) != {}


def test_a_simulated_session_does_not_use_or_set_best_results(data: Path) -> None:
    begun(data, 1, mode="simulated")
    live = begun(data, 2)
    simulated = begun(data, 3, mode="simulated")
    assert best_known(data, live) == best_known(data, simulated) == {}


def test_a_resumed_session_does_not_get_its_own_best_as_an_earlier_one(data: Path) -> None:
    first = begun(data, 1)
    cut = begun(data, 2, steps=40)
    assert best_of(data, cut.id), "it had a result of its own"
    again = resumed(data, cut)
    assert best_known(data, again) == best_known(data, cut) == best_of(data, first.id)


def begun_with_own_theme(data: Path, themes: Path, copied: str) -> tuple[Run, Catalogue]:
    """Start a session with a copy of a theme, and interrupt it."""
    shutil.copytree(CATALOGUE.theme_folder(copied), themes / "mine")
    say_in(themes, "round")
    catalogue, clock = Catalogue(themes=(themes,)), VirtualClock()
    plan = msgspec.structs.replace(PLAN, theme="mine")
    run = start(plan, data, catalogue, clock, somebody)
    assert run.theme_notice == ""
    play(run, clock, 12)
    return run, catalogue


def say_in(themes: Path, word: str) -> None:
    words = themes / "mine" / "words.en.toml"
    words.write_text(f'"attempt {{number}} of {{total}}" = "{word} {{number}} of {{total}}"')


def test_a_theme_edited_between_two_runs_is_spoken_in_the_second_and_the_first_is_replayed(
    data: Path, tmp_path: Path
) -> None:
    run, catalogue = begun_with_own_theme(data, tmp_path / "themes", "calm")
    say_in(tmp_path / "themes", "turn")
    resumed(data, run, catalogue=catalogue)
    history = sessions.history(connect(data), run.id)
    names = [record.message.attempt_name for record in history if record.topic is WAITING]
    assert (names[0], names[-1]) == ("round 1 of 3", "turn 3 of 3")


def test_a_session_whose_theme_was_removed_goes_on_with_the_default_one_and_says_so(
    data: Path, tmp_path: Path
) -> None:
    run, catalogue = begun_with_own_theme(data, tmp_path / "themes", "playful")
    shutil.rmtree(tmp_path / "themes" / "mine")
    again = resumed(data, run, catalogue=catalogue)
    assert again.session.ended
    assert f"The theme mine of session {run.id} cannot be loaded any more" in again.theme_notice
    (deviation,) = deviations(read(connect(data), run.id), [])
    told = (deviation.run, deviation.what, deviation.detail)
    assert told == (2, "theme", "calm instead of mine")


def test_a_simulation_that_is_interrupted_keeps_what_it_has_done(data: Path) -> None:
    def interrupt(attempt: int) -> None:
        if attempt == 3:
            raise KeyboardInterrupt

    brief: Any = {"seed": 1, "mode": "simulated", "id": "S"}
    plan = make_plan(CATALOGUE, "keyboard", ["P01"], {"prompts_per_attempt": 2}, **brief)
    with pytest.raises(KeyboardInterrupt):
        simulate(plan, PEOPLE["average"], data, CATALOGUE, interrupt)
    with closing(connect(data)) as database:
        assert [row["attempt"] for row in sessions.rows(database, "attempts", "S")] == [1, 2]
        assert len(sessions.rows(database, "trials", "S")) >= 5
        assert sessions.find(database, data, "S")["status"] == "interrupted"

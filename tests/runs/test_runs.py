"""A session that was cut off is completed by a later run."""

import shutil
import tempfile
from contextlib import closing
from pathlib import Path
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.topics import SESSION, WAITING
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue
from sar_tui.reports.deviations import deviations
from sar_tui.reports.logged_messages import read
from sar_tui.runs.plan import make_plan
from sar_tui.runs.run import Run, resume, start
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant import SimulatedParticipant
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from sar_tui.store.database import StoreError, connect
from tests.examples import examples

CATALOGUE = Catalogue()
KEYBOARD = CATALOGUE.task("keyboard")
SETTINGS = {"attempts": 3, "prompts_per_attempt": 4, "start_level": 5}
PLAN = make_plan(CATALOGUE, KEYBOARD, ["P01"], SETTINGS, seed=4)


def make_participants(task: Any, theme: Any, seed: int) -> list[SimulatedParticipant]:
    return [SimulatedParticipant(PEOPLE["average"], task, seed)]


def play(run: Run, clock: VirtualClock, steps: int | None = None) -> None:
    """Do a number of steps of a run, or all of them, and close it."""
    run.begin()
    while not run.session.ended and (steps is None or steps > 0):
        assert clock.step()
        steps = None if steps is None else steps - 1
    assert run.session.broken is None
    run.recorder.write()
    run.close()


def table(data: Path, name: Any, session: str, *columns: str) -> list[tuple[Any, ...]]:
    return [
        tuple(row[column] for column in columns)
        for row in sessions.rows(connect(data), name, session)
    ]


TRIALS = ("attempt", "trial", "stimulus", "response", "correct")
ATTEMPTS = ("attempt", "level", "accuracy", "outcome", "feedback")


def undisturbed(data: Path) -> str:
    clock = VirtualClock()
    run = start(PLAN, data, CATALOGUE, clock, make_participants)
    play(run, clock)
    return run.id


@examples(25)
@given(st.lists(st.integers(0, 40), min_size=1, max_size=4))
def test_a_session_resumed_any_number_of_times_has_the_same_trials_as_an_uninterrupted_one(
    cuts: list[int],
) -> None:
    data = Path(tempfile.mkdtemp())
    try:
        whole = undisturbed(data)
        clock = VirtualClock()
        run = start(PLAN, data, CATALOGUE, clock, make_participants)
        play(run, clock, cuts[0])
        for number, steps in enumerate([*cuts[1:], None], 2):
            if run.session.ended:
                break
            assert sessions.find(connect(data), data, run.id)["status"] == "interrupted"
            clock = VirtualClock(number * 1000 * SECOND)
            run = resume(run.id, data, CATALOGUE, clock, make_participants)
            assert run.number == number
            play(run, clock, steps)
        assert sessions.find(connect(data), data, run.id)["status"] == "completed"
        assert table(data, "trials", run.id, *TRIALS) == table(data, "trials", whole, *TRIALS)
        assert table(data, "attempts", run.id, *ATTEMPTS) == table(
            data, "attempts", whole, *ATTEMPTS
        )
        trials = sessions.rows(connect(data), "trials", run.id)
        assert [trial["run"] for trial in trials] == sorted(trial["run"] for trial in trials)
        assert len(sessions.rows(connect(data), "runs", run.id)) == run.number
        seqs = [record.seq for record in sessions.history(connect(data), run.id)]
        assert seqs == list(range(1, len(seqs) + 1))
    finally:
        shutil.rmtree(data)


def test_each_run_stores_its_software_and_machine(
    data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("SSH_CONNECTION", "SSH_TTY", "SSH_CLIENT", "TMUX", "STY", "ZELLIJ"):
        monkeypatch.delenv(name, raising=False)
    clock = VirtualClock()
    run = start(PLAN, data, CATALOGUE, clock, make_participants)
    play(run, clock, 5)
    monkeypatch.setenv("SSH_TTY", "/dev/pts/0")
    clock = VirtualClock(1000 * SECOND)
    play(resume(run.id, data, CATALOGUE, clock, make_participants), clock, 5)
    session = sessions.find(connect(data), data, run.id)
    local, ssh = sessions.rows(connect(data), "runs", run.id)
    assert (local["software"], local["machine"]) == (session["software"], session["machine"])
    assert (local["machine"]["flags"], ssh["machine"]["flags"]) == ([], ["ssh"])
    assert ssh["software"] == local["software"]


def test_a_session_that_has_ended_cannot_be_resumed(data: Path) -> None:
    session = undisturbed(data)
    with pytest.raises(
        StoreError, match="is completed; only a live one that was interrupted"
    ) as caught:
        resume(session, data, CATALOGUE, VirtualClock(), make_participants)
    assert caught.value.bad_input


# --- earlier best results


def best_known(data: Path, run: Run) -> dict[str, float]:
    """Return the earlier best results that a run started with, by level."""
    history = sessions.history(connect(data), run.id)
    (best,) = [
        r.message.best for r in history if r.topic is SESSION and r.message.run == run.number
    ]
    return dict(best)


def best_of(data: Path, *names: str) -> dict[str, float]:
    best: dict[str, float] = {}
    for name in names:
        for row in sessions.rows(connect(data), "attempts", name):
            if row["metric"] is not None and row["accuracy"] >= 0.8:
                level = str(row["level"])
                best[level] = min(best.get(level, row["metric"]), row["metric"])
    return best


def played(data: Path, seed: int, steps: int | None = None, **changed: Any) -> Run:
    clock = VirtualClock()
    plan = msgspec.structs.replace(PLAN, seed=seed, **changed)
    run = start(
        plan,
        data,
        CATALOGUE,
        clock,
        lambda task, theme, seed: [SimulatedParticipant(PEOPLE["average"], task, seed)],
    )
    play(run, clock, steps)
    return run


def test_a_session_gets_the_best_of_the_participants_earlier_ones_by_level(data: Path) -> None:
    first, second = played(data, 1), played(data, 2)
    played(data, 3, participant="P02")
    third = played(data, 4)
    assert best_known(data, first) == {}
    assert best_known(data, second) == best_of(data, first.id)
    assert best_known(data, third) == best_of(data, first.id, second.id) != {}


def test_a_simulated_session_does_not_use_or_set_best_results(data: Path) -> None:
    played(data, 1, mode="simulated")
    live = played(data, 2)
    simulated = played(data, 3, mode="simulated")
    assert best_known(data, live) == best_known(data, simulated) == {}


def test_a_resumed_session_does_not_get_its_own_best_as_an_earlier_one(data: Path) -> None:
    first = played(data, 1)
    cut = played(data, 2, steps=40)
    assert best_of(data, cut.id), "it had a result of its own"
    clock = VirtualClock(1000 * SECOND)
    again = resume(cut.id, data, CATALOGUE, clock, make_participants)
    play(again, clock)
    assert best_known(data, again) == best_known(data, cut) == best_of(data, first.id)


def test_a_theme_edited_between_two_runs_is_spoken_in_the_second_and_the_first_is_replayed(
    data: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "themes" / "mine"
    shutil.copytree(CATALOGUE.theme_folder("calm"), folder)
    words = folder / "words.en.toml"
    words.write_text('"attempt {number} of {total}" = "round {number} of {total}"')
    catalogue = Catalogue(themes=(tmp_path / "themes",))
    clock = VirtualClock()
    run = start(
        msgspec.structs.replace(PLAN, theme="mine"), data, catalogue, clock, make_participants
    )
    play(run, clock, 12)
    words.write_text('"attempt {number} of {total}" = "turn {number} of {total}"')
    clock = VirtualClock(1000 * SECOND)
    again = resume(run.id, data, catalogue, clock, make_participants)
    play(again, clock)
    names = [
        r.message.attempt_name
        for r in sessions.history(connect(data), run.id)
        if r.topic is WAITING
    ]
    assert (names[0], names[-1]) == ("round 1 of 3", "turn 3 of 3")


def test_a_session_whose_theme_was_removed_goes_on_with_the_default_one_and_says_so(
    data: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "themes" / "mine"
    shutil.copytree(CATALOGUE.theme_folder("playful"), folder)
    catalogue = Catalogue(themes=(tmp_path / "themes",))
    clock = VirtualClock()
    run = start(
        msgspec.structs.replace(PLAN, theme="mine"), data, catalogue, clock, make_participants
    )
    assert run.theme_notice == ""
    play(run, clock, 12)
    shutil.rmtree(folder)
    clock = VirtualClock(1000 * SECOND)
    again = resume(run.id, data, catalogue, clock, make_participants)
    play(again, clock)
    assert again.session.ended
    assert again.theme_notice == (
        f"The theme mine of session {run.id} cannot be loaded any more: it went on with calm, "
        "whose words and looks "
        "differ."
    )
    (deviation,) = deviations(read(connect(data), run.id), [])
    assert (deviation.run, deviation.what, deviation.detail) == (2, "theme", "calm instead of mine")


def test_a_simulation_that_is_interrupted_keeps_what_it_has_done(data: Path) -> None:
    def interrupt(attempt: int) -> None:
        if attempt == 3:
            raise KeyboardInterrupt

    plan = make_plan(
        CATALOGUE, "keyboard", ["P01"], {"prompts_per_attempt": 2}, seed=1, mode="simulated", id="S"
    )
    with pytest.raises(KeyboardInterrupt):
        simulate(plan, PEOPLE["average"], data, CATALOGUE, interrupt)
    with closing(connect(data)) as database:
        assert [row["attempt"] for row in sessions.rows(database, "attempts", "S")] == [1, 2]
        assert len(sessions.rows(database, "trials", "S")) >= 5
        assert sessions.find(database, data, "S")["status"] == "interrupted"

"""A session of two that is interrupted and resumed is stored as one."""

from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop.bus import Record
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.session import Session
from sar_tui.loop.topics import PROPOSED, SESSION
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import build
from sar_tui.runs.plan import Plan, make_plan
from sar_tui.runs.run import Run, resume, start
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant import SimulatedParticipant, SimulatedPartner
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import locks, sessions
from sar_tui.store.database import StoreError, connect
from tests.examples import examples, first
from tests.played import play

CATALOGUE = Catalogue()
KIND = CATALOGUE.task("pairs")
SHORT = {"attempts": 2, "prompts_per_attempt": 3}
POLICIES = ("alternate", "race", "cooperative", "joint attention")


def plan(mode: Any = "live", left: str = "P01", right: str = "P02", **parameters: object) -> Plan:
    codes = [code for code in (left, right) if code]
    return make_plan(CATALOGUE, KIND, codes, SHORT | parameters, seed=4, mode=mode)


def make_participants(task: Any, theme: Any, seed: int) -> list[Any]:
    return [
        SimulatedParticipant(PEOPLE["average"], task, seed),
        SimulatedPartner(PEOPLE["poor"], task, seed, seat="B"),
    ]


def rows(data: Path, name: Any, session: str, *columns: str) -> list[tuple[Any, ...]]:
    with closing(connect(data)) as database:
        found = sessions.rows(database, name, session)
    return [tuple(row[column] for column in columns) for row in found]


def recorded(data: Path, session: str) -> list[Record]:
    with closing(connect(data)) as database:
        return list(sessions.history(database, session))


def found(data: Path, session: str) -> Any:
    with closing(connect(data)) as database:
        return sessions.find(database, data, session)


ASKED = ("attempt", "trial", "seat", "stimulus")


def whole(data: Path, **parameters: object) -> str:
    clock = VirtualClock()
    run = start(plan(**parameters), data, CATALOGUE, clock, make_participants)
    play(run, clock)
    return run.id


# --- participants


def test_both_seats_are_stored_and_the_session_is_found_from_either(data: Path) -> None:
    session = whole(data)
    seats = {("A", "P01"), ("B", "P02")}
    assert {*rows(data, "seats", session, "seat", "participant")} == seats
    with closing(connect(data)) as database:
        for code in ("P01", "P02"):
            (row,) = sessions.listing(database, data, participant=code)
            of_both = (session, "P01", "P02", 2)
            assert (row["id"], row["participant"], row["partner"], row["attempts"]) == of_both
            assert sessions.participant_codes(row) == "P01, P02"
        assert sessions.listing(database, data, participant="P03") == []


def test_neither_participant_can_be_in_a_second_live_session(data: Path) -> None:
    run = start(plan(), data, CATALOGUE, VirtualClock(), make_participants)
    for left, right in (("P01", "P03"), ("P03", "P02")):
        second = plan(left=left, right=right)
        with pytest.raises(StoreError, match=r"P0[12] is in a live session already"):
            start(second, data, CATALOGUE, VirtualClock(), make_participants)
    assert not locks.is_held(data, "participant", "P03")
    run.close()
    assert not any(locks.is_held(data, "participant", code) for code in ("P01", "P02"))


@pytest.mark.parametrize(
    ("task", "left", "right", "why"),
    [
        ("pairs", "P01", "", "The task pairs is for two"),
        ("pairs", "P01", "p01", "P01 cannot sit at both seats"),
        ("keyboard", "P01", "P02", "The task keyboard is for one"),
    ],
)
def test_the_number_of_participants_must_match_the_seats(
    task: str, left: str, right: str, why: str
) -> None:
    with pytest.raises(StoreError, match=why) as raised:
        make_plan(CATALOGUE, task, [code for code in (left, right) if code])
    assert raised.value.bad_input


def test_each_participant_has_their_own_best_at_either_seat(data: Path) -> None:
    whole(data, start_level=1, max_level=1)
    clock = VirtualClock()
    other_way = plan(left="P02", right="P01", start_level=1, max_level=1)
    run = start(other_way, data, CATALOGUE, clock, make_participants)
    reported = (run.session.best["1"], run.session.others_best["B"]["1"])
    best = (
        "SELECT min(metric) FROM attempts JOIN seats USING (session, seat) WHERE participant=? "
        "AND accuracy >= 0.8"
    )
    with closing(connect(data)) as before:
        kept = tuple(before.execute(best, (code,)).fetchone()[0] for code in ("P02", "P01"))
    run.close()
    assert reported == kept
    assert reported[0] != reported[1]


@pytest.mark.parametrize(("address", "names"), [("code", {"A": "P01", "B": "P02"}), ("seat", {})])
def test_the_session_gets_codes_only_if_the_agent_addresses_people_by_them(
    data: Path, address: str, names: dict[str, str]
) -> None:
    session = simulate(plan("simulated", address=address), PEOPLE["average"], data, CATALOGUE)
    history = recorded(data, session)
    (started,) = [record.message for record in history if record.topic is SESSION]
    assert started.names == names
    said = [r.message for r in history if r.topic is PROPOSED and r.message.kind == "feedback"]
    wanted = names or {"A": "Left", "B": "Right"}
    assert {(one.seat, one.text.partition(": ")[0]) for one in said} == set(wanted.items())


def test_a_simulated_task_for_two_has_a_partner_even_if_none_is_named(data: Path) -> None:
    session = simulate(plan("simulated", "SIM", ""), PEOPLE["average"], data, CATALOGUE)
    assert sorted(rows(data, "seats", session, "participant")) == [("SIM",), ("SIM-B",)]


# --- interrupted and resumed


@pytest.mark.slow
@pytest.mark.parametrize("policy", first(2, POLICIES))
@examples(6)
@given(steps=st.lists(st.integers(0, 30), min_size=1, max_size=3))
def test_each_trial_of_both_is_stored_once_after_kills_in_mid_trial_and_replays_identically(
    policy: str, steps: list[int], tmp_path_factory: pytest.TempPathFactory
) -> None:
    data = tmp_path_factory.mktemp("data") / "data"
    clock = VirtualClock()
    named = {"policy": policy, "address": "code"}
    run: Run = start(plan(**named), data, CATALOGUE, clock, make_participants)
    session = run.id
    for count in steps:
        play(run, clock, count)
        row = found(data, session)
        if row["status"] != "interrupted":
            break
        assert (row["participant"], row["partner"]) == ("P01", "P02")
        clock = VirtualClock()
        run = resume(session, data, CATALOGUE, clock, make_participants)
        assert all(locks.is_held(data, "participant", code) for code in ("P01", "P02"))
    else:
        play(run, clock)
    numbers = rows(data, "trials", session, "attempt", "trial", "seat")
    assert len(numbers) == len(set(numbers))
    shown = {number[:2] for number in numbers}
    assert shown == {(attempt, trial) for attempt in (1, 2) for trial in (1, 2, 3)}
    assert len(numbers) == (6 if policy in ("alternate", "joint attention") else 12)
    assert len(rows(data, "attempts", session, "attempt")) == 4
    other = data.parent / "whole"
    asked = rows(other, "trials", whole(other, policy=policy), *ASKED)
    assert rows(data, "trials", session, *ASKED) == asked
    replayed = Session(
        KIND(build(KIND.Parameters, SHORT | named)), CATALOGUE.theme("calm"), VirtualClock(), 4
    )
    replayed.replay(recorded(data, session))
    assert replayed.ended

"""Visits are due, early, late or missed by the day, and blocks follow each other."""

from datetime import UTC, datetime, timedelta

import msgspec
import pytest

from sar_tui.store.database import StoreError
from sar_tui.study.ledger import Enrolment, Played
from sar_tui.study.plan import Study
from sar_tui.study.schedule import Item, Next, NothingLeft, items, next_item, visit_days
from tests.study.plans import TWO_GROUPS, plan

FIRST = datetime(2026, 3, 2, 12, tzinfo=UTC)
PERSON = Enrolment(
    participant="P01", study="praise", version=1, number=1, group="praise", orders=(1,)
)


def mine(study: Study) -> list[Item]:
    return list(items(study, PERSON, "praise"))


def done(day: int, item: Item, status: str = "completed") -> Played:
    at = FIRST + timedelta(days=day)
    return Played(
        id=f"{item.key}",
        participant="P01",
        visit=item.visit.name,
        block=item.block.name,
        condition=item.condition,
        position=item.position,
        status=status,
        day=at.date().isoformat(),
        ended=at.isoformat(),
    )


def due(study: Study, played: list[Played], day: int) -> Next:
    found = next_item(study, mine(study), played, FIRST + timedelta(days=day))
    assert isinstance(found, Next)
    return found


def test_conditions_come_in_the_persons_order_and_the_groups_where_it_says_so() -> None:
    found = [(item.block.name, item.condition, item.position) for item in mine(plan())]
    assert found == [
        ("baseline", "unpraised", 1),
        ("speeds", "fast", 1),
        ("speeds", "slow", 2),
        ("training", "praised", 1),
    ]


@pytest.mark.parametrize(
    "person",
    [msgspec.structs.replace(PERSON, orders=()), msgspec.structs.replace(PERSON, group="quiet")],
)
def test_groups_and_orders_of_another_version_are_refused(person: Enrolment) -> None:
    with pytest.raises(StoreError, match="enrolled in version 1 of the study praise, which has"):
        list(items(plan(), person, person.group))


def test_the_first_block_is_due_on_any_day_and_each_follows_the_one_before() -> None:
    study = plan()
    own = mine(study)
    assert due(study, [], 99).item == own[0]
    for number in range(1, 3):
        found = due(study, [done(0, item) for item in own[:number]], 0)
        assert (found.item, found.state) == (own[number], "due")


@pytest.mark.parametrize(
    ("day", "state"),
    [(4, "early"), (5, "due"), (7, "due"), (10, "due"), (11, "late"), (60, "late")],
)
def test_a_visit_is_early_or_late_outside_of_its_window(day: int, state: str) -> None:
    study = plan(TWO_GROUPS.replace("[2, 2]", "[2, 3]"))
    found = due(study, [done(0, item) for item in mine(study)[:3]], day)
    assert found.item == mine(study)[3]
    assert found.state == state


def test_days_are_counted_back_from_a_later_visit_that_was_made_first() -> None:
    study = plan()
    second = [done(0, mine(study)[3])]
    assert next_item(study, mine(study), second, FIRST) == NothingLeft((study.visit("first"),))


THREE = (
    TWO_GROUPS
    + """
[[visits]]
name = "third"
day = 14
window = [1, 1]
[[visits.blocks]]
name = "probe"
condition = "unpraised"
purpose = "retention"
"""
)


def test_a_visit_is_missed_once_the_next_ones_window_begins() -> None:
    study = plan(THREE)
    first = [done(0, item) for item in mine(study)[:3]]
    assert due(study, first, 12).state == "late"
    found = due(study, first, 13)
    assert found.item == mine(study)[4]
    assert [visit.name for visit in found.passed] == ["second"]


def test_a_plan_may_say_that_visits_are_left_out_or_end_the_participation() -> None:
    first = [done(0, item) for item in mine(plan(THREE))[:3]]
    skips = plan(THREE.replace("name =", 'missed = "skip"\nname =', 1))
    assert due(skips, first, 10).passed[0].name == "second"
    stops = plan(THREE.replace("name =", 'missed = "stop"\nname =', 1))
    ended = next_item(stops, mine(stops), first, FIRST + timedelta(days=10))
    assert ended == NothingLeft((stops.visit("second"),))


@pytest.mark.parametrize(
    ("then", "hours", "resumes", "block"),
    [
        ("restart", 1, True, "baseline"),
        ("restart", 30, False, "baseline"),
        ("leave", 1, True, "baseline"),
        ("leave", 30, False, "speeds"),
    ],
)
def test_a_session_that_was_cut_off_goes_on_or_is_begun_again_or_left(
    then: str, hours: int, resumes: bool, block: str
) -> None:
    study = plan(TWO_GROUPS.replace("[outcome]", f'[interrupted]\nthen = "{then}"\n[outcome]'))
    played = [done(0, mine(study)[0], "interrupted")]
    found = next_item(study, mine(study), played, FIRST + timedelta(hours=hours))
    assert isinstance(found, Next)
    assert found.item.block.name == block
    assert bool(found.resume) is resumes
    assert found.repeats is (block == "baseline" and not resumes)


def test_days_count_from_the_first_visit_that_was_made() -> None:
    study = plan()
    played = [done(3, item) for item in mine(study)[:3]]
    (first, second) = visit_days(study, mine(study), played, FIRST + timedelta(days=3))
    assert first.state == "done"
    assert (second.first, second.last) == (
        (FIRST + timedelta(days=8)).date(),
        (FIRST + timedelta(days=12)).date(),
    )

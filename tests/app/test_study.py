"""The screen of a study: who is due, and the next block of a person, on the days of its plan."""

from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, date, datetime, timedelta
from pathlib import Path

import msgspec
import pytest

from sar_tui.app.app import SarTui
from sar_tui.app.screens.study import StudyScreen
from sar_tui.plugins import Catalogue
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import records
from sar_tui.store.database import connect
from sar_tui.store.interface_language import choose_interface_language
from sar_tui.store.locks import hold
from sar_tui.study import enrolment, ledger, next_block
from sar_tui.study.secret import key_file
from tests.album import Album
from tests.app.app_driver import AppDriver, OpenApp, given, known, stored
from tests.app.test_adjust import choose, open_changes
from tests.app.test_sizes import shrink_and_grow
from tests.study.plans import plan

TWO_VISITS = """
name = "praise"
title = "Praise and reaction time"
hypothesis = "People are faster with praise."
[allocation]
blind = true
[groups.praised]
condition = "praise"
[groups.unpraised]
condition = "silence"
[conditions.praise]
task = "keyboard"
theme = "high-contrast"
settings = { feedback_form = "qualitative", prompts_per_attempt = 2 }
[conditions.silence]
task = "keyboard"
settings = { feedback_schedule = "none", prompts_per_attempt = 2 }
[outcome]
visit = "second"
block = "training"
compared = "groups"
[[visits]]
name = "first"
[[visits.blocks]]
name = "baseline"
condition = "praise"
attempts = 1
[[visits.blocks]]
name = "training"
condition = "as allocated"
attempts = 1
[[visits]]
name = "second"
day = 7
window = [2, 2]
[[visits.blocks]]
name = "training"
condition = "as allocated"
attempts = 1
[[visits.blocks]]
name = "usability"
form = "SUS"
"""
CONSENT = TWO_VISITS.replace("[outcome]", '[consent]\nversion = "2"\n[outcome]')
MANY = TWO_VISITS + "".join(
    f"""[[visits]]
name = "training-{number}"
day = {7 + number}
[[visits.blocks]]
name = "training"
condition = "as allocated"
attempts = 1
"""
    for number in range(1, 25)
)
MONDAY = datetime(2026, 3, 2, 12, tzinfo=UTC)


class Study:
    """A study in a data folder, with the app's day."""

    def __init__(self, data: Path, patch: pytest.MonkeyPatch) -> None:
        self.data, self._patch = data, patch
        self.key = key_file("praise")
        self.key.parent.mkdir(parents=True)
        self.key.write_text("5a" * 32)  # the same codes in each test

    def enrol(
        self,
        *codes: str,
        text: str = TWO_VISITS,
        mode: ledger.Mode = "live",
        now: datetime = MONDAY,
    ) -> None:
        """Freeze the plan, and enrol people."""
        with closing(connect(self.data)) as db:
            enrolment.freeze(
                db, Catalogue(()), text, plan(text), self.key, mode=mode, author="me", now=now
            )
            for code in codes:
                enrolment.enrol(db, ledger.find(db), code, self.key, now=now)

    def play(self, code: str, now: datetime) -> None:
        """Let a person do their next block on a day."""
        with closing(connect(self.data)) as db:
            one = next_block.person(db, ledger.find(db), code, self.key)
            found = next_block.due(db, one, now, reason="as in the test")
            session = next_block.plan_of(db, Catalogue(()), one, found, seed=1)
            simulated = msgspec.structs.replace(session, mode="simulated")
            simulate(simulated, PEOPLE["average"], self.data, Catalogue(()), began=now)
            db.execute("UPDATE sessions SET mode='live'")

    def note(self, kind: str, code: str, **content: str | int) -> None:
        """Record something on a person."""
        with closing(connect(self.data)) as db:
            records.add(db, records.kind_of(kind), code, "", {"study": "praise"} | content)

    def today_is(self, day: date) -> None:
        """Let the app open on a day."""
        self._patch.setattr(SarTui, "today", staticmethod(lambda: day))

    def deviations(self) -> list[tuple[object, ...]]:
        """Return what was recorded as a deviation."""
        with closing(connect(self.data)) as db:
            return [
                (each.participant, each.content["what"], each.content.get("reason"))
                for each in ledger.of_study(db, ledger.DEVIATION, "praise")
            ]


@pytest.fixture
def study(data: Path, tmp_path: Path) -> Iterator[Study]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CONFIG_HOME", str(tmp_path / "configuration"))
        yield Study(data, patch)


def key_line(driver: AppDriver) -> str:
    """Return the row above the footer."""
    return driver.rows[-2].strip()


async def test_enter_begins_the_next_block_and_comes_back_with_the_one_after_it(
    opened: OpenApp, study: Study
) -> None:
    study.enrol("P01", "P02", now=datetime.now(UTC))
    async with opened() as driver:
        theme = driver.app.theme
        await driver.press("f7")
        driver.see("Study praise · Praise and reaction time", "0 of 4 visits done")
        driver.see("2 people are due today.", "P01 G1 due", "P02 G2 due")
        await driver.press("2")
        driver.see("find: 2 (Esc)")
        driver.lacks("P01")
        await driver.press("enter")
        assert driver.app.theme != theme
        await driver.do_session()
        await driver.press("enter")
        assert driver.screen_name == "StudyScreen"
        assert driver.app.theme == theme, "the session had another one"
        driver.see("P02 G2 1 of 2 done, due today")
        assert "visit 1, block 2" in key_line(driver)
        assert key_line(driver).endswith("of P02.")
        await driver.press("escape")
        driver.see("P02 G2 1 of 2 done", "P01 G1 due")
        await driver.press("escape")
        assert driver.screen_name == "HomeScreen"
    ((place, status),) = driver.stored("SELECT study, status FROM sessions")
    assert status == "completed"
    found = msgspec.json.decode(place)
    assert (found["visit"], found["block"]) == ("first", "baseline")
    assert study.deviations() == []


async def test_an_interrupted_block_goes_on_where_it_was(opened: OpenApp, study: Study) -> None:
    study.enrol("P01", now=datetime.now(UTC))
    async with opened() as driver:
        await driver.press("f7", "enter")
        await driver.answer(await driver.to_first_prompt())
        session = driver.session_id
    async with opened() as driver:
        await driver.press("f7")
        driver.see("A session was cut off: it goes on where it was.")
        assert key_line(driver).startswith("Press Enter to resume visit 1, block 1")
        await driver.press("enter")
        assert driver.session_id == session


async def test_a_block_that_is_left_goes_on_later(opened: OpenApp, study: Study) -> None:
    study.enrol("P01", now=datetime.now(UTC))
    async with opened() as driver:
        await driver.press("f7", "enter")
        await driver.answer(await driver.to_first_prompt())
        session = driver.session_id
        await open_changes(driver)
        await choose(driver, "Stop, and go on later")
        assert driver.screen_name == "StudyScreen"
        driver.see("A session was cut off: it goes on where it was.")
        said = driver.app.leaving.lines(0)
        assert said[:1] == ["The session is kept. It goes on with:"]
        assert said[1].startswith("  sar-tui study next P01 --study praise")
        await driver.press("enter")
        assert driver.session_id == session


async def test_home_names_all_studies_of_a_person(opened: OpenApp, study: Study) -> None:
    study.enrol("P01", now=MONDAY)
    other = key_file("other")
    other.write_text("5b" * 32)
    text = TWO_VISITS.replace('name = "praise"', 'name = "other"', 1)
    with closing(connect(study.data)) as db:
        enrolment.freeze(db, Catalogue(()), text, plan(text), other, mode="live", author="me")
        enrolment.enrol(db, ledger.find(db, "other"), "P01", other)
    async with opened() as driver:
        driver.see("Study other: visit 1, block 1, due.", "Study praise: visit 1, block 1, due.")


async def test_on_another_day_a_reason_is_asked_for_once_and_escape_changes_nothing(
    opened: OpenApp, study: Study
) -> None:
    study.enrol("P01", now=MONDAY)
    for hour in range(2):
        study.play("P01", MONDAY + timedelta(hours=hour))
    for day, why, what in ((3, "too early", "early"), (10, "too late", "late")):
        study.today_is(MONDAY.date() + timedelta(days=day))
        async with opened() as driver:
            await driver.press("f7")
            driver.see(f"is from Sat 7 Mar to Wed 11 Mar: today is {why}.")
            assert key_line(driver).startswith("Press Enter to start visit 2, block 1")
            await driver.press("enter")
            driver.see("Why not as planned?", "Esc: nothing begins.")
            await driver.press("enter")
            driver.see("A few words are enough.")
            await driver.press("escape")
            assert driver.screen_name == "StudyScreen"
            assert study.deviations() == []
            if what == "late":
                driver.see("1 visit is late.", "P01 G1 done late")
                await driver.press("enter")
                await driver.enter("was on holiday")
                assert driver.screen_name == "SessionScreen"
    assert study.deviations() == [("P01", "late", "was on holiday")]
    study.today_is(MONDAY.date() + timedelta(days=11))
    async with opened() as driver:
        await driver.press("f7")
        driver.see("Differs from the plan: second: late (was on holiday).")
        await driver.press("enter")
        assert driver.screen_name == "SessionScreen", "the reason for this visit is known"
    assert len(study.deviations()) == 1


async def test_no_session_begins_without_consent(opened: OpenApp, study: Study) -> None:
    study.enrol("P01", text=CONSENT, now=datetime.now(UTC))
    async with opened() as driver:
        await driver.press("f7")
        driver.see("P01 has not agreed to the study praise yet.", "sar-tui study consent P01")
        assert not key_line(driver)
        await driver.press("enter")
        assert driver.screen_name == "StudyScreen"
        study.note("consent", "P01", version="2", answer="yes")
        await driver.press("f1", "escape")
        assert key_line(driver).startswith("Press Enter to start visit 1, block 1")
        study.note("consent", "P01", version="2", answer="withdrawn")
        await driver.press("enter")
        driver.see("P01 has withdrawn the consent to the study praise: no session starts.")
        assert driver.screen_name == "StudyScreen"
    assert stored(study.data, "SELECT id FROM sessions") == []


async def test_whoever_is_blind_sees_codes_and_what_another_window_records(
    opened: OpenApp, study: Study
) -> None:
    study.enrol("P01", "P02", now=datetime.now(UTC))
    async with opened() as driver:
        await driver.press("f7")
        driver.lacks("praised", "unpraised", "silence", "(praise)")
        assert key_line(driver) in {
            f"Press Enter to start visit 1, block 1 ({code}) of P01." for code in ("C1", "C2")
        }
        screen = driver.app.screen
        assert isinstance(screen, StudyScreen)
        drawn = screen.query_one("#people")
        listed = drawn.options
        screen._look_again()
        assert drawn.options == listed, "nothing is drawn again"
        study.note("study-exit", "P02", what="withdrawn", reason="moved away")
        screen._look_again()
        await driver.settle()
        driver.see("P02 G2 withdrawn", "1 person is due today.")
        await driver.press("down")
        driver.see("P02 takes part no longer: withdrawn (moved away).")
        assert not key_line(driver)


async def test_without_the_key_the_table_is_shown_and_nothing_begins(
    opened: OpenApp, study: Study
) -> None:
    study.enrol("P01", now=datetime.now(UTC))
    study.key.unlink()
    async with opened() as driver:
        driver.see("Study praise: visit 1, block 1, due. F7")
        await driver.press("f7")
        driver.see("P01 G1 due", "The key of the study is not here")
        driver.lacks("praise)", "silence")
        assert not key_line(driver)
        await driver.press("enter")
        assert driver.screen_name == "StudyScreen"


async def test_a_form_is_filled_in_and_the_end_of_a_study_is_told(
    opened: OpenApp, study: Study
) -> None:
    study.enrol("P01", "P02", now=MONDAY)
    for day in (0, 0, 7):
        study.play("P01", MONDAY + timedelta(days=day))
    study.today_is(MONDAY.date() + timedelta(days=8))
    async with opened() as driver:
        await driver.press("f7", "1")
        assert key_line(driver) == "Press Enter to fill in visit 2, block 2 (SUS) of P01."
        await driver.press("enter")
        driver.see("System Usability Scale", "Item 1 of 10")
        for _ in range(10):
            await driver.press("3", "enter")
        await driver.press("enter")
        assert driver.screen_name == "StudyScreen"
        driver.see("P01 has done all of the study praise.")
        await driver.press("escape", "escape", "f7")
        assert key_line(driver).endswith("of P02."), "P01 has nothing more to do"


async def test_in_a_rehearsal_nobody_trains(opened: OpenApp, study: Study) -> None:
    study.enrol("P01", mode="simulated", now=datetime.now(UTC))
    async with opened() as driver:
        await driver.press("f7", "enter")
        driver.see("This is a rehearsal with simulated people: nobody trains in it.")
        assert driver.screen_name == "StudyScreen"


async def test_home_knows_of_a_study_only_if_there_is_one(opened: OpenApp, study: Study) -> None:
    known(study.data, "P01")
    async with opened() as driver:
        driver.lacks("F7", "Study")
        await driver.press("f7")
        assert driver.screen_name == "HomeScreen"
    study.enrol("P02")
    async with opened() as driver:
        driver.see("F7 Study", "P01 · Keyboard reaction")
        driver.lacks("Study praise")
        await driver.press("2")
        driver.see("Study praise: visit 1, block 1, due. F7")
        await driver.press("f1")
        driver.see("F7 shows the study: who is due, and what comes next.")


@pytest.mark.slow
async def test_of_several_studies_tab_shows_another(opened: OpenApp, study: Study) -> None:
    study.enrol("P01", now=MONDAY)
    other = TWO_VISITS.replace('"praise"\ntitle', '"voice"\ntitle', 1)
    with closing(connect(study.data)) as db:
        key = key_file("voice")
        enrolment.freeze(db, Catalogue(()), other, plan(other), key, mode="live", author="me")
    async with opened() as driver:
        await driver.press("f7")
        driver.see("Study praise", "Tab Other study")
        await driver.press("tab")
        driver.see("Study voice", "Nobody is enrolled yet.", "sar-tui study enrol P01")
        assert not key_line(driver)
        await shrink_and_grow(driver)
        await driver.press("tab")
        driver.see("Study praise")
        await shrink_and_grow(driver)


SIZES = ((80, 24), (100, 32), (160, 48))


@pytest.mark.parametrize("size", SIZES, ids=lambda size: str(size[0]))
async def test_snapshots(opened: OpenApp, study: Study, size: tuple[int, int]) -> None:
    album = Album(Path(__file__).parent / "snapshots", str(size[0]), size)
    _weeks(study)
    async with opened(size=size) as driver:
        await driver.press("1")
        album.take("home-with-a-study", driver)
        await driver.press("escape", "f7")
        album.take("study", driver)
        await driver.press("0", "4", "enter")
        album.take("study-reason", driver)
    album.check()


@pytest.mark.slow
@pytest.mark.parametrize("code", ["de", "es"])
async def test_snapshots_in_other_languages(opened: OpenApp, study: Study, code: str) -> None:
    album = Album(Path(__file__).parent / "snapshots", code, (80, 24))
    _weeks(study)
    choose_interface_language(study.data, code)
    async with opened() as driver:
        await driver.press("f7")
        album.take("study", driver)
    album.check()


@pytest.mark.slow
async def test_a_snapshot_of_many_visits(opened: OpenApp, study: Study) -> None:
    album = Album(Path(__file__).parent / "snapshots", "80", (80, 24))
    _weeks(study, text=MANY)
    async with opened() as driver:
        await driver.press("f7")
        album.take("study-of-many-visits", driver)
    album.check()


def _weeks(study: Study, text: str = TWO_VISITS) -> None:
    """Let people be at several places of a study on a Monday in March."""
    codes = [f"P{number:02}" for number in range(1, 9)]
    study.enrol(*codes, text=text, now=MONDAY - timedelta(days=30))
    for code, days in (
        ("P01", (7, 7)), ("P02", (12, 12)), ("P03", (7, 7, 0)), ("P04", (2, 2)), ("P05", (0,)),
        ("P06", (20, 20)),
    ):  # fmt: skip
        for at, ago in enumerate(days):
            study.play(code, MONDAY - timedelta(days=ago) + timedelta(minutes=5 * at))
    study.note("study-exit", "P06", what="withdrawn", reason="moved away")
    study.note("deviation", "P01", version=1, visit="first", what="other", reason="a drill outside")
    study.today_is(MONDAY.date())


async def test_questions_after_a_session_have_its_theme(opened: OpenApp, study: Study) -> None:
    asking = TWO_VISITS.replace('qualitative"', 'qualitative", ask_wellbeing = true')
    study.enrol("P01", text=asking, now=datetime.now(UTC))
    async with opened() as driver:
        theme = driver.app.theme
        await driver.press("f7", "enter", *given("0", "0"))
        await driver.do_session()
        await driver.press("enter")
        assert (driver.screen_name, driver.app.theme) == ("QuestionScreen", "sar-high-contrast")
        await driver.press(*given("0", "0"))
        assert (driver.screen_name, driver.app.theme) == ("StudyScreen", theme)


@pytest.mark.parametrize("text", [TWO_VISITS, MANY])
async def test_whoever_is_in_a_session_is_shown_until_its_end(
    opened: OpenApp, study: Study, text: str
) -> None:
    study.enrol("P01", text=text, now=MONDAY)
    study.play("P01", MONDAY)
    study.today_is(MONDAY.date())
    choose_interface_language(study.data, "de")
    ((id,),) = stored(study.data, "SELECT id FROM sessions")
    with closing(connect(study.data)) as db:
        db.execute("UPDATE sessions SET status='running', ended_at=NULL")
    held = hold(study.data, "session", id)
    async with opened() as driver:
        await driver.press("f7")
        driver.see("Gerade in einer Sitzung: P01.")
        driver.see("◆ jetzt", "! anders") if text == MANY else driver.see("P01 G1 gerade in einer")
        assert key_line(driver) == ""
        held.release()
        await driver.press("escape", "f7")
        driver.lacks("Gerade in einer Sitzung")

"""Settings: a form made from a task's declaration, stored for one participant."""

import inspect
from collections.abc import AsyncIterator
from contextlib import closing
from pathlib import Path
from typing import Annotated, Any

import msgspec
import pytest

from sar_tui.app.screens.settings import FieldPanel, SettingsScreen
from sar_tui.app.settings.preview import PreviewPane, chart
from sar_tui.app.settings.rules import RuleField
from sar_tui.loop.task import Task
from sar_tui.model.language import Language
from sar_tui.plugins import Catalogue
from sar_tui.rules.declaration import meta, show
from sar_tui.rules.parameters import build, fields
from sar_tui.rules.policies import DIFFICULTY
from sar_tui.runs.plan import make_plan
from sar_tui.runs.preview import Played, Preview
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import programmes
from sar_tui.store.database import connect
from sar_tui.store.programmes import Programme
from sar_tui.widgets.choice import Choice
from sar_tui.widgets.parameter_field import ParameterField
from tests.app.app_driver import AppDriver, OpenApp, known, stored


def panels(driver: AppDriver) -> list[FieldPanel]:
    return list(driver.app.screen.query(FieldPanel))


def every_field(driver: AppDriver) -> list[ParameterField]:
    """Return all fields, including those that were not shown yet."""
    return [widget for panel in panels(driver) for widget in panel.fields]


def field(driver: AppDriver, name: str) -> ParameterField:
    return next(widget for widget in every_field(driver) if widget.field.name == name)


def open_panels(driver: AppDriver) -> list[str]:
    return [found.title for found in panels(driver) if found.display]


def meaning(driver: AppDriver) -> str:
    """Return the text below the focused field, which is on the screen."""
    focused = next(widget for widget in every_field(driver) if widget.has_focus_within)
    driver.see(*focused.note.split()[:2])
    return focused.note


def told(driver: AppDriver) -> str:
    """Return the notifications."""
    return " ".join(notice.message for notice in driver.app._notifications)


def rule_list(driver: AppDriver) -> RuleField:
    return driver.app.screen.query_exactly_one(RuleField)


async def preview(driver: AppDriver) -> str:
    """Wait until the previews have been played, and return the sentence of the one that is
    shown.
    """
    await driver.app.workers.wait_for_complete()
    await driver.settle()
    return driver.app.screen.query_one(PreviewPane).text


async def go_to(driver: AppDriver, name: str) -> None:
    """Find a field, and focus it."""
    await driver.press("f3")
    await driver.enter(name)
    assert field(driver, name).has_focus_within


async def fill(driver: AppDriver, name: str, text: str) -> None:
    """Replace the content of a field."""
    await go_to(driver, name)
    await driver.write("end", "ctrl+u")
    await driver.write(*text)


async def save(driver: AppDriver, reason: str = "Tired") -> None:
    """Save, and give a reason."""
    await driver.press("ctrl+s")
    assert driver.screen_name == "SaveReasonScreen"
    await driver.enter(reason)


async def command(driver: AppDriver, name: str) -> None:
    """Do what the palette offers under a name."""
    screen = driver.app.screen
    assert isinstance(screen, SettingsScreen)
    chosen = next(each for each in screen.commands() if each.title == name)
    done = chosen.callback()
    if inspect.isawaitable(done):
        await done
    await driver.settle()


def stored_settings(data: Path) -> dict[str, Any]:
    """Return the stored settings of P01."""
    ((parameters,),) = stored(data, "SELECT parameters FROM settings WHERE participant='P01'")
    return dict(msgspec.json.decode(parameters))


@pytest.fixture
def a_participant(data: Path) -> None:
    known(data, "P01", attempts=20, prompts_per_attempt=20, quiet_ms=700)


@pytest.fixture
async def form(a_participant: None, opened: OpenApp) -> AsyncIterator[AppDriver]:
    """The settings of P01 for the keyboard task."""
    async with opened() as driver:
        await driver.press("f2")
        yield driver


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
async def test_any_parameter_has_a_field(opened: OpenApp, data: Path, keyboard: type[Task]) -> None:
    class More(keyboard.Parameters, frozen=True, kw_only=True):  # type: ignore[name-defined, misc]
        tempo: Annotated[int, meta("Tempo", "beats", "How fast the drum beats.", ge=1, le=9)] = 3
        drum: Annotated[bool, meta("Drum", help="Whether there is a drum.")] = True

    class Drummed(keyboard):  # type: ignore[valid-type, misc]
        Parameters = More

    async with opened() as driver:
        driver.app.push_screen(SettingsScreen("P01", Drummed))
        await driver.settle()
        assert len(every_field(driver)) == len(fields(keyboard.Parameters)) + 2
        await go_to(driver, "tempo")
        driver.see("Tempo 3 beats")
        assert meaning(driver) == "How fast the drum beats. 1 to 9 beats."
        await fill(driver, "tempo", "12")
        assert meaning(driver) == "Tempo is a whole number, 1 to 9, not 12."
        await fill(driver, "tempo", "7")
        await go_to(driver, "drum")
        driver.see("Drum yes")
        await driver.press("enter", "down", "enter")
        driver.see("◆ Drum no ▼ was yes")
        await save(driver)
    assert stored_settings(data) == {"tempo": 7, "drum": False, "quiet_ms": 700}


async def test_values_are_checked_as_they_are_typed(
    form: AppDriver, data: Path, keyboard: type[Task]
) -> None:
    await fill(form, "attempts", "2x")
    assert meaning(form) == "Attempts is a whole number, 1 to 200, not 2x."
    form.see("Ctrl-S goes to what must be corrected", "Session ! 1", "! Attempts 2x")
    await form.press("backspace")
    assert meaning(form) == "Number of attempts in a session. 1 to 200. Default: 20."
    form.see("◆ Attempts 2 was 20", "◆ 1 not saved")
    form.lacks("must be corrected")
    await fill(form, "foreperiod_min_ms", "1.8")
    assert meaning(form) == "Shortest wait (1.8 s) is above the longest (1.5 s)."
    await fill(form, "foreperiod_max_ms", "1.9")
    assert field(form, "foreperiod_min_ms").problem == ""
    await fill(form, "start_level", "21")
    found = meaning(form)
    assert found == "There are only 20 levels in this choice of keys, so there is no level 21."
    await fill(form, "start_level", "5")
    keys = keyboard(build(keyboard.Parameters, {"start_level": 5}))
    assert meaning(form).endswith(f"Level 5: {keys.level_name(5)}")
    await fill(form, "attempts", "0")
    await form.press("ctrl+s")
    assert field(form, "attempts").has_focus_within, "the invalid value"
    assert meaning(form) == "Attempts is a whole number, 1 to 200, not 0."
    assert stored_settings(data)["attempts"] == 20


async def test_numbers_are_shown_and_typed_in_the_units_of_therapists(form: AppDriver) -> None:
    await fill(form, "threshold", "900")
    assert meaning(form) == (
        "Goal is a number, 0.1 to 60 s, not 900. For milliseconds, type 900 ms."
    )
    await fill(form, "threshold", "900 ms")
    assert field(form, "threshold").value == "900"
    await go_to(form, "min_accuracy")
    form.see("◆ Goal 0.9 s was 1", "Minimum accuracy 80 %")
    await fill(form, "min_accuracy", "101")
    assert meaning(form) == "Minimum accuracy is a number, 0 to 100 %, not 101."
    await fill(form, "min_accuracy", "72,5")
    assert field(form, "min_accuracy").value == "0.725"


async def test_the_start_level_is_shown_where_it_is_used(
    opened: OpenApp, data: Path, catalogue: Catalogue
) -> None:
    known(data, "P01", prompts_per_attempt=20)
    plan = make_plan(catalogue, "keyboard", ["P01"], {"attempts": 8}, seed=1, mode="simulated")
    session = simulate(plan, PEOPLE["poor"], data, catalogue)
    with closing(connect(data)) as database, database:
        database.execute("UPDATE sessions SET mode='live' WHERE id=?", (session,))
    async with opened() as driver:
        await driver.press("f2")
        assert not field(driver, "start_level").display
        await driver.press("f3")
        await driver.enter("start_level")
        assert field(driver, "start_from").has_focus_within
        assert "Start level is used by another choice: fixed level." in told(driver)
        await driver.press("enter", "down", "enter")
        assert field(driver, "start_from").value == "fixed"
        driver.see("fixed level ▼")
        assert field(driver, "start_level").display


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
async def test_an_unknown_sensor_is_told(first_run: AppDriver, catalogue: Catalogue) -> None:
    first_run.app.push_screen(SettingsScreen("P01", catalogue.task("reaching")))
    await first_run.settle()
    await fill(first_run, "imu", "fidget")
    known = "lsl, phidget, phyphox, recorded, ros, serial, simulated, udp, session"
    assert meaning(first_run) == f'There is no sensor "fidget". Choose one of: {known}.'
    await fill(first_run, "imu", "simulated:steady")
    assert "There is no" not in meaning(first_run)


@pytest.mark.slow
async def test_one_field_is_reset_or_all_of_them(form: AppDriver) -> None:
    await fill(form, "prompts_per_attempt", "5")
    await fill(form, "sequence_length", "6")
    await fill(form, "attempts", "7")
    form.see("Session ◆ 1")
    await form.press("ctrl+r")
    form.see("Attempts 20")
    form.lacks("Session ◆ 1")
    await form.write("4")
    assert field(form, "attempts").value == "4", "it replaces the default"
    await form.press("ctrl+r", "end")
    await form.write("4")
    assert field(form, "attempts").value == "204", "unless the cursor is moved"
    assert show(field(form, "sequence_length").value) == "6"
    await go_to(form, "encouragement")
    await form.press("enter", "down", "enter")
    assert field(form, "encouragement").value is False
    await form.press("ctrl+r")
    assert field(form, "encouragement").value is True
    await command(form, "Reset all")
    assert not any(widget.is_changed for widget in every_field(form))


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
async def test_saved_settings_apply_to_the_next_session(opened: OpenApp, data: Path) -> None:
    known(data, "P02", attempts=2)
    async with opened() as driver:
        await driver.press("down", "f2")
        await fill(driver, "attempts", "3")
        await go_to(driver, "choice_set")
        await driver.press("enter", "down", "enter")
        assert field(driver, "choice_set").value == "arrow keys"
        await save(driver)
        assert "Saved: version 2. The next session starts at level 1." in told(driver)
        await driver.press("escape", *["right"] * 3, "enter", "enter")
        driver.see("Press Enter to begin attempt 1 of 3.")
        assert (await driver.begin()).expected in ("left", "right")
    assert stored_settings(data) == {"attempts": 3, "choice_set": "arrow keys", "quiet_ms": 700}
    assert stored(
        data, "SELECT json_extract(parameters, '$.attempts') FROM settings WHERE participant='P02'"
    ) == [(2,)]


async def test_a_language_that_the_theme_lacks_is_told(opened: OpenApp, data: Path) -> None:
    known(data, "P01", language="fr")
    async with opened() as driver:
        await driver.press("f2")
        await go_to(driver, "language")
        assert meaning(driver) == (
            "The theme calm has no phrases in fr; it has: en, de, es. "
            "Choose one of these, or give the theme a file phrases.fr.toml."
        )
        await driver.press("enter", "e", "e", "enter")
        driver.see("◆ Language es ▼")
        await save(driver)
        assert "Saved: version 2." in told(driver)
    assert stored_settings(data)["language"] == "es"


@pytest.mark.slow
async def test_settings_that_became_invalid_are_told_and_can_be_set(
    opened: OpenApp, data: Path
) -> None:
    known(data, "P01", theme="gone", attempts=20, tempo=3, layout="sholes")
    async with opened() as driver:
        await driver.press("f2")
        assert "These settings do not exist any more: tempo." in told(driver)
        await driver.press("pagedown")
        driver.see("Keyboard layout sholes ▼")
        assert field(driver, "layout").note.endswith(", not sholes.")
        await go_to(driver, "layout")
        await driver.press("enter", "enter")
        assert field(driver, "layout").value == "qwerty"
        driver.lacks("must be corrected")
        await fill(driver, "language", "es")
        assert meaning(driver).endswith("Default: en.")


# --- groups


async def test_arrows_and_page_keys_move_between_groups(form: AppDriver) -> None:
    assert rule_list(form).has_focus_within
    await form.press("up", "up", "down", "down", "down")
    assert form.app.focused is form.app.screen.query_one("#groups")
    assert open_panels(form) == ["Limits"]
    form.see("How much is enough?")
    form.see("Enter goes to Limits.")
    await form.press("enter")
    assert field(form, "session_minutes").has_focus_within
    await form.press("pageup")
    assert field(form, "attempts").has_focus_within
    await form.press(*["pageup"] * 3)
    assert open_panels(form) == ["Timing"]


@pytest.mark.slow
async def test_arrows_pass_over_choices_and_do_not_open_them(form: AppDriver) -> None:
    await go_to(form, "prompts_per_attempt")
    await form.press("down", "down", "down")
    assert field(form, "levels").has_focus_within
    assert field(form, "choice_set").value == "both hands"


# --- finding


@pytest.mark.slow
async def test_fields_say_what_they_mean_while_they_are_edited_below_or_beside(
    form: AppDriver,
) -> None:
    first, second = "Number of keys in an attempt. 1 to 200.", "The keys that prompts are drawn"
    await form.press("pagedown")
    form.see(first)
    await form.press("down")
    form.see(second)
    form.lacks(first)
    await form.resize(160, 48)
    form.see(f"Keys {second}")
    await form.press("up")
    form.see(first)
    form.lacks(second)


@pytest.mark.usefixtures("a_participant")
async def test_a_setting_is_found_by_a_word_of_its_title_or_help(first_run: AppDriver) -> None:
    await first_run.press("f2", "/")
    assert first_run.screen_name == "FindSettingScreen"
    await first_run.write(*"held key")
    first_run.see("Key repeat interval Timing")
    await first_run.press("enter")
    assert open_panels(first_run) == ["Timing"]
    assert field(first_run, "repeat_interval_ms").has_focus_within
    await first_run.press("/")
    await first_run.write(*"rest")
    first_run.see("Rest reminder every Session")
    await first_run.press("down", "up", "enter")
    assert field(first_run, "rest_every").has_focus_within
    await first_run.press("/", "escape")
    assert field(first_run, "rest_every").has_focus_within
    await first_run.press("/")
    await first_run.enter("xyzzy")
    assert first_run.screen_name == "FindSettingScreen"


# --- saving


@pytest.mark.usefixtures("a_participant")
async def test_saving_asks_for_a_reason_and_keeps_it(opened: OpenApp, data: Path) -> None:
    async with opened() as driver:
        await driver.press("f2", "ctrl+s")
        assert (driver.screen_name, told(driver)) == ("SettingsScreen", "")
        driver.see("saved version 1")
        await fill(driver, "threshold", "0.9")
        await driver.press("ctrl+s")
        driver.see("● Goal 1 → 0.9 s")
        await driver.press("enter")
        driver.see("A few words are enough.")
        await driver.press("escape")
        driver.see("◆ 1 not saved")
        await driver.press("ctrl+s")
        await driver.write(*"Reached it")
        await driver.press("down")
        await driver.write("end", "ctrl+u")
        await driver.enter("Ana")
        driver.see("P01, Keyboard reaction: settings", "saved version 2")
        driver.lacks("not saved")
        found = driver.stored("SELECT version, author, reason FROM programmes ORDER BY version")
        assert found == [(1, "", ""), (2, "Ana", "Reached it")]
        settings = stored_settings(data)
        assert (settings["threshold"], settings["quiet_ms"]) == (900, 700)

        await command(driver, "Reset all")
        await save(driver)
        assert not field(driver, "quiet_ms").is_mounted, "a setting never shown is saved too"
    assert stored_settings(data) == {}


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
async def test_a_change_by_somebody_else_is_told_and_kept(opened: OpenApp, data: Path) -> None:
    async with opened(size=(100, 30)) as driver:
        await driver.press("f2")
        await fill(driver, "attempts", "9")
        with closing(connect(data)) as database:
            theirs = Programme({"attempts": 5})
            programmes.save(
                database, "P01", "keyboard", theirs, after=1, author="Ben", reason="Pain"
            )
        await save(driver)
        driver.see(
            "The programme of P01 was changed meanwhile: version 2 (Ben: Pain). Nothing was saved."
        )
        assert stored_settings(data)["attempts"] == 5
        await driver.press("ctrl+s")
        driver.see("version 2 (Ben: Pain)", "● Attempts 5 → 9")
        await driver.enter("Agreed")
        assert "Saved: version 3." in told(driver)
    assert stored(
        data, "SELECT json_extract(parameters, '$.attempts') FROM programmes ORDER BY version"
    ) == [(20,), (5,), (9,)]


async def test_a_preset_leaves_nothing_of_the_one_before(opened: OpenApp, data: Path) -> None:
    known(data, "P01", choice_set="left hand")
    folder = data / "presets" / "keyboard"
    folder.mkdir(parents=True)
    (folder / "a.toml").write_text(
        'task = "keyboard"\n[parameters]\nfeedback_every = 3\nlanguage = "es"\n'
    )
    (folder / "b.toml").write_text('task = "keyboard"\n[parameters]\nthreshold = 700.0\n')
    async with opened() as driver:
        await driver.press("f2")
        await driver.press("f6", *["down"] * 3, "enter")  # a, after those of the task
        assert "and stays: Language." in told(driver)
        await driver.press("f6", *["down"] * 4, "enter")  # b
        await save(driver)
    assert stored_settings(data) == {"choice_set": "left hand", "threshold": 700.0}


# --- the rules of difficulty, and the preview


@pytest.mark.slow
async def test_a_rule_is_looked_at_before_it_is_chosen(form: AppDriver) -> None:
    fixed = await preview(form)
    form.see("✓ Step by step", "15 of 20", "An average person: P01 has too few", "more settings ↓")
    form.see(
        "Press ↑ ↓ to look at a rule, Enter to choose it.",
        "Aims at about half of the goals: 15 of 20.",
    )
    await form.press("down")
    form.see("Enter chooses this rule.")
    assert await preview(form) != fixed
    assert field(form, "difficulty_policy").value == "one-up-one-down"
    await form.press("enter")
    assert field(form, "difficulty_policy").value == "percentile"
    form.see("◆ A goal of their own", "follows the results. was")


async def test_only_the_settings_that_a_rule_uses_are_shown(form: AppDriver) -> None:
    def shown() -> set[str]:
        return {each.field.name for each in panels(form)[0].fields if each.display}

    always = {"difficulty_policy", "threshold", "neutral_band", "min_accuracy"}
    by_level = {"start_level", "start_from", "min_level", "max_level"}
    streaks = {"consecutive_successes", "consecutive_failures"}
    assert shown() == always | by_level | streaks
    await form.press("up", "enter")
    assert field(form, "difficulty_policy").value == "fixed"
    assert shown() == always | {"start_level"}
    await form.press("down", "down", "down", "enter")
    assert field(form, "difficulty_policy").value == "sequence"
    assert shown() == always | {"level_sequence", "min_level", "max_level"}
    form.see("Ctrl-S goes to what must be corrected")
    await form.press("ctrl+s")
    assert field(form, "level_sequence").has_focus_within
    await form.write(*"1 1 2")
    form.lacks("must be corrected")
    await form.press("f3")
    await form.enter("target_share")
    assert rule_list(form).has_focus_within, "where the setting gets an effect"
    assert "Target is used by another choice: target." in told(form)


@pytest.mark.slow
async def test_the_preview_follows_each_change_and_stores_nothing(
    form: AppDriver, data: Path
) -> None:
    await fill(form, "threshold", "9")
    aims = "Aims at about half of the goals:"
    assert await preview(form) == f"{aims} 20 of 20. The level rises all the time, to 20."
    await fill(form, "threshold", "0.15")
    assert await preview(form) == f"{aims} 0 of 20. The level stays at 1."
    await form.write("x")
    assert await preview(form) == "Correct what is marked ! to see it."
    assert stored(data, "SELECT count(*) FROM sessions") == [(0,)]


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
async def test_the_preview_says_whom_it_is_like(
    opened: OpenApp, data: Path, catalogue: Catalogue
) -> None:
    plan = make_plan(catalogue, "keyboard", ["P01"], {"attempts": 8}, seed=1, mode="simulated")
    session = simulate(plan, PEOPLE["poor"], data, catalogue)
    with closing(connect(data)) as database, database:
        database.execute("UPDATE sessions SET mode='live' WHERE id=?", (session,))
    async with opened(size=(160, 48)) as driver:
        await driver.press("f2")
        await preview(driver)
        driver.see("Simulated as P01 did in the last session.")


@pytest.mark.slow
async def test_a_rule_that_is_gone_is_shown_until_another_is_chosen(
    opened: OpenApp, data: Path
) -> None:
    known(data, "P01", difficulty_policy="gone")
    async with opened() as driver:
        await driver.press("f2")
        driver.see("! gone", "There is no difficulty policy gone here")
        assert await preview(driver) == "Correct what is marked ! to see it."
        await driver.press("down", "enter")
        assert field(driver, "difficulty_policy").value == "fixed"
        driver.lacks("gone here")


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
async def test_a_rule_that_fails_is_said_to_when_it_is_looked_at_and_spoils_no_other(
    opened: OpenApp, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise ValueError("no goal")

    monkeypatch.setitem(DIFFICULTY, "percentile", DIFFICULTY["percentile"]._replace(goal=fail))
    async with opened() as form:
        await form.press("f2")
        assert "Aims at" in await preview(form)
        form.see("A share of successes level 1 to 9")
        await form.press("down")
        assert (await preview(form)).startswith("It cannot be played: The task keyboard")
        await form.press("down")
        assert "Aims at" in await preview(form)


def test_each_level_has_a_height_of_its_own(keyboard: type[Task]) -> None:
    attempts = tuple(Played(level, True, 1.0) for level in range(1, 21))
    played = Preview(attempts, 20, "level", keyboard.metric)
    for rows in (4, 12, 30):
        lines = [line.plain for line in chart(played, 20, 60, rows, Language())]
        heights = {"".join(column) for column in zip(*lines[:-1], strict=False)}
        assert len(heights) >= 20


# --- leaving without saving


@pytest.mark.slow
async def test_leaving_asks_nothing_and_saves_nothing_and_coming_back_finds_what_was_typed(
    form: AppDriver, data: Path
) -> None:
    await fill(form, "attempts", "7")
    await form.press("escape")
    assert form.screen_name == "HomeScreen"
    assert "Not saved: Attempts. F2 brings that back." in told(form)
    assert stored_settings(data)["attempts"] == 20
    assert form.app.leaving.lines(0) == ["Not saved: changes to the settings of P01 for keyboard."]
    await form.press("f2")
    form.see("◆ 1 not saved")
    assert told(form) == "Back, and not saved: Attempts. F7 discards that."
    await form.press("f7")
    form.see("saved version 1")
    form.lacks("not saved")
    assert "Discarded: Attempts. F7 brings that back." in told(form)
    await form.press("f7")
    form.see("◆ 1 not saved")
    await save(form)
    await form.press("escape")
    assert form.app.settings_drafts == {}
    assert stored_settings(data)["attempts"] == 7


# --- earlier versions


@pytest.fixture
def three_versions(data: Path) -> None:
    known(data, "P01", attempts=20)
    with closing(connect(data)) as database:
        for after, (attempts, who, why) in enumerate(
            ((15, "Ana", "Tired"), (10, "Ben", "Pain")), 1
        ):
            wanted = Programme({"attempts": attempts})
            programmes.save(
                database, "P01", "keyboard", wanted, after=after, author=who, reason=why
            )


@pytest.mark.slow
@pytest.mark.usefixtures("three_versions")
async def test_a_version_is_compared_and_brought_back_as_a_new_one(opened: OpenApp) -> None:
    async with opened() as driver:
        await driver.press("f2")
        await fill(driver, "threshold", "0.9")
        await driver.press("f5")
        driver.see("3", "Ben", "Pain", "These are the settings now.")
        await driver.press("enter")
        assert driver.screen_name == "VersionsScreen", "there is nothing to go back to"
        await driver.press("down")
        driver.see("Version 2 changed", "Attempts 20 → 15", "Going back", "Attempts 10 → 15")
        await driver.press("enter")
        driver.see("Back to version 2", "● Attempts 10 → 15")
        await driver.press("enter")
        driver.see("A few words are enough.")
        await driver.enter("Less pain")
        assert "Saved: version 4." in told(driver)
        assert "Discarded: Goal. F7 brings that back." in told(driver)
        assert field(driver, "attempts").value == 15
        found = driver.stored(
            "SELECT version, json_extract(parameters, '$.attempts'), reason FROM programmes "
            "ORDER BY version"
        )
        assert found[1:] == [
            (2, 15, "Tired"), (3, 10, "Pain"), (4, 15, "Back to version 2: Less pain"),
        ]  # fmt: skip
        assert field(driver, "threshold").value == 1000.0
        await driver.press("f7")
        assert field(driver, "threshold").value == "900", "what was not saved is not lost"


@pytest.mark.slow
async def test_without_versions_the_list_says_how_to_make_one(home: AppDriver) -> None:
    await home.press("f2", "f5")
    home.see("There is one version so far.")


# --- choices


@pytest.mark.slow
async def test_choices_and_outputs_open_in_a_list(form: AppDriver) -> None:
    await go_to(form, "layout")
    choice = field(form, "layout").query_one(Choice)
    await form.press("enter")
    form.see("azerty")
    await form.press("down", "escape")
    assert choice.has_focus
    form.lacks("azerty")
    assert field(form, "layout").value == "qwerty"
    await form.press("space", "a", "enter")
    form.see("◆ Keyboard layout azerty ▼ was qwerty")
    await form.press("enter", "tab")
    assert not choice.children
    await form.pilot.click(choice)
    await form.press("up", "enter")
    assert field(form, "layout").value == "qwerty"
    await form.pilot.click(choice)
    await form.pilot.click(choice)
    await form.settle()
    assert choice.has_focus

    await go_to(form, "outputs")
    await form.press("enter")
    form.see("✓ screen")
    await form.press("down", "down", "enter", "escape")
    assert field(form, "outputs").value == "screen tones"
    await form.press("enter", "enter", "escape")
    assert field(form, "outputs").value == "tones"
    await fill(form, "outputs", "ros://lab/x")
    assert field(form, "outputs").value == "ros://lab/x"

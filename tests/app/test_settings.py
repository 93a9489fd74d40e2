"""Settings: a form made from a task's declaration, stored for one participant."""

from contextlib import closing
from pathlib import Path
from typing import Annotated, Any

import msgspec
import pytest
from textual.widgets import Button, Static

from sar_tui.app.screens.settings import FieldPanel, SettingsScreen
from sar_tui.loop.task import Task
from sar_tui.plugins import Catalogue
from sar_tui.rules.declaration import meta, show
from sar_tui.rules.parameters import build, fields, grouped
from sar_tui.store import programmes
from sar_tui.store.database import connect
from sar_tui.store.programmes import Programme
from sar_tui.widgets.choice import Choice
from sar_tui.widgets.parameter_field import ParameterField
from tests.app.app_driver import AppDriver, OpenApp, known, open_app, stored
from tests.examples import first


def panels(driver: AppDriver) -> list[FieldPanel]:
    return list(driver.app.screen.query(FieldPanel))


def every_field(driver: AppDriver) -> list[ParameterField]:
    """Return all fields, including those that were not shown yet."""
    return [widget for panel in panels(driver) for widget in panel.fields]


def field(driver: AppDriver, name: str) -> ParameterField:
    return next(widget for widget in every_field(driver) if widget.field.name == name)


def panel(driver: AppDriver, title: str) -> FieldPanel:
    """Return the panel with a title."""
    return next(found for found in panels(driver) if found.title == title)


def open_panels(driver: AppDriver) -> list[str]:
    return [found.title for found in panels(driver) if found.display]


def meaning(driver: AppDriver) -> str:
    """Return the text below the fields."""
    return " ".join(str(driver.app.screen.query_one("#meaning", Static).content).split())


async def go_to(driver: AppDriver, name: str) -> None:
    """Find a field, and focus it."""
    await driver.press("f3")
    await driver.write(*name)
    await driver.press("enter")
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
    await driver.write(*reason)
    await driver.press("enter")


def stored_settings(data: Path) -> dict[str, Any]:
    """Return the stored settings of P01."""
    ((parameters,),) = stored(data, "SELECT parameters FROM settings WHERE participant='P01'")
    return dict(msgspec.json.decode(parameters))


@pytest.fixture
def a_participant(data: Path) -> None:
    known(data, "P01", attempts=20, prompts_per_attempt=20)


@pytest.mark.usefixtures("a_participant")
async def test_settings_of_a_rule_that_is_not_chosen_are_marked(opened: OpenApp) -> None:
    async with opened() as driver:
        await driver.press("f2")
        await go_to(driver, "target_share")
        assert meaning(driver).startswith("Without effect now: only with target.")
        assert driver.sees("– Target")
        await go_to(driver, "consecutive_successes")
        assert not meaning(driver).startswith("Without effect")


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
async def test_there_is_one_field_for_each_declared_parameter(
    opened: OpenApp, keyboard: type[Task]
) -> None:
    async with opened() as driver:
        await driver.press("f2")
        assert driver.sees("Settings of P01 for Keyboard reaction: version 1")
        for heading, declared in grouped(keyboard.Parameters).items():
            assert open_panels(driver) == [heading or "Keyboard reaction"]
            for each in declared:
                widget = field(driver, each.name)
                assert widget.has_focus_within
                text = driver.text
                assert each.title in text
                assert each.unit in text
                assert each.help in meaning(driver)
                if each.kind in ("int", "float"):
                    assert each.bounds[1:] in meaning(driver)
                await driver.press("tab" if each is not declared[-1] else "pagedown")
        assert open_panels(driver) == ["Keyboard reaction"]


@pytest.mark.usefixtures("a_participant")
async def test_tab_goes_from_the_groups_through_the_fields_to_the_buttons(opened: OpenApp) -> None:
    async with opened() as driver:
        await driver.press("f2")
        chain = [widget.id or type(widget).__name__ for widget in driver.app.screen.focus_chain]
        assert chain[0] == "groups"
        assert chain[-4:] == ["save", "preset", "reset-all", "back"]
        assert len(chain) == 1 + 6 + 4


@pytest.mark.usefixtures("a_participant")
async def test_a_new_parameter_has_a_field_without_further_changes(
    opened: OpenApp, data: Path, keyboard: type[Task]
) -> None:
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
        assert driver.sees("Tempo 3 beats")
        assert meaning(driver) == "How fast the drum beats. 1 to 9 beats."
        await fill(driver, "tempo", "12")
        assert meaning(driver) == "Tempo is a whole number, 1 to 9, not 12."
        await fill(driver, "tempo", "7")
        await go_to(driver, "drum")
        assert driver.sees("Drum yes")
        await driver.press("enter", "down", "enter")
        assert driver.sees("● Drum no")
        await save(driver)
    assert stored_settings(data) == {"tempo": 7, "drum": False}


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
async def test_values_are_checked_as_they_are_typed_alone_and_together(opened: OpenApp) -> None:
    async with opened() as driver:
        await driver.press("f2")
        await fill(driver, "attempts", "2x")
        assert meaning(driver) == "Attempts is a whole number, 1 to 200, not 2x."
        assert driver.sees("1 to fix")
        assert driver.sees("Session ! 1")
        assert driver.sees("! Attempts 2x")
        await driver.press("backspace")
        assert meaning(driver) == "Number of attempts in a session. 1 to 200. Default: 20."
        assert not driver.sees("to fix")
        assert driver.sees("not saved")
        await fill(driver, "foreperiod_min_ms", "1800")
        assert meaning(driver) == "Shortest wait (1800 ms) is above the longest (1500 ms)."
        await fill(driver, "foreperiod_max_ms", "1900")
        assert field(driver, "foreperiod_min_ms").problem == ""
        await fill(driver, "start_level", "21")
        assert (
            meaning(driver)
            == "There are only 20 levels in this choice of keys, so there is no level 21."
        )


@pytest.mark.usefixtures("a_participant")
async def test_an_invalid_value_is_not_saved_and_gets_the_focus(
    opened: OpenApp, data: Path
) -> None:
    async with opened() as driver:
        await driver.press("f2")
        await fill(driver, "attempts", "0")
        await go_to(driver, "prompts_per_attempt")
        await driver.press("ctrl+s")
        assert field(driver, "attempts").has_focus_within
        assert meaning(driver) == "Attempts is a whole number, 1 to 200, not 0."
    assert stored_settings(data)["attempts"] == 20


@pytest.mark.usefixtures("a_participant")
async def test_an_unknown_sensor_is_reported_at_its_field(
    opened: OpenApp, catalogue: Catalogue
) -> None:
    async with opened() as driver:
        driver.app.push_screen(SettingsScreen("P01", catalogue.task("reaching")))
        await driver.settle()
        await fill(driver, "imu", "fidget")
        known = "phidget, recorded, ros, simulated, session"
        assert meaning(driver) == f'There is no sensor "fidget". Choose one of: {known}.'
        await fill(driver, "imu", "simulated:steady")
        assert "There is no" not in meaning(driver)


@pytest.mark.slow
async def test_a_dot_marks_values_that_differ_from_the_default(opened: OpenApp, data: Path) -> None:
    known(data, "P01", prompts_per_attempt=5)
    async with opened() as driver:
        await driver.press("f2")
        assert driver.sees("● Prompts per attempt 5")
        assert not driver.sees("not saved")
        await fill(driver, "prompts_per_attempt", "20")
        assert driver.sees("not saved")
        assert "● Prompts" not in driver.text


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
async def test_one_field_is_reset_or_all_of_them(opened: OpenApp) -> None:
    async with opened() as driver:
        await driver.press("f2")
        await fill(driver, "prompts_per_attempt", "5")
        await fill(driver, "sequence_length", "6")
        await fill(driver, "attempts", "7")
        await driver.press("ctrl+r")
        assert driver.sees("Attempts 20")
        assert show(field(driver, "sequence_length").value) == "6"
        await go_to(driver, "encouragement")
        await driver.press("enter", "down", "enter")
        assert field(driver, "encouragement").value is False
        await driver.press("ctrl+r")
        assert field(driver, "encouragement").value is True
        driver.app.screen.query_one("#reset-all").focus()
        await driver.press("enter")
        assert not any(widget.is_changed for widget in every_field(driver))


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
async def test_what_is_typed_after_a_reset_replaces_the_default(opened: OpenApp) -> None:
    async with opened() as driver:
        await driver.press("f2")
        await fill(driver, "attempts", "7")
        await driver.press("ctrl+r")
        await driver.write("4")
        assert field(driver, "attempts").value == "4"
        await driver.press("ctrl+r", "end")
        await driver.write("4")
        assert field(driver, "attempts").value == "204", "unless the cursor is moved"


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
@pytest.mark.parametrize(
    "sizes", first(1, [((30, 5), (80, 24)), ((80, 24),), ((80, 30), (79, 24), (80, 24))])
)
async def test_the_focused_field_stays_in_view_in_a_smaller_window(
    opened: OpenApp, sizes: tuple[tuple[int, int], ...]
) -> None:
    async with opened(size=(80, 50)) as driver:
        await driver.press("f2")
        await go_to(driver, "difficulty_policy")
        for size in sizes:
            await driver.resize(*size)
        shown = panel(driver, "Difficulty")
        focused = driver.app.focused
        assert focused
        assert focused.region in shown.region


@pytest.mark.usefixtures("a_participant")
async def test_saved_settings_apply_to_the_participants_next_session(
    opened: OpenApp, data: Path
) -> None:
    known(data, "P02", attempts=2)
    async with opened() as driver:
        await driver.press("down", "f2")
        await fill(driver, "attempts", "3")
        await go_to(driver, "choice_set")
        await driver.press("enter", "down", "enter")
        assert (
            driver.app.screen.query_one("#parameter-choice_set").query_one(Choice).value
            == "arrow keys"
        )
        await save(driver)
        assert driver.sees("saved: version 2")
        assert driver.sees("The next session starts at level 1.")
        await driver.press("escape", *["right"] * 3, "enter", "enter")
        assert driver.sees("Press Enter to begin attempt 1 of 3.")
        assert (await driver.begin()).expected in ("left", "right")
    assert stored_settings(data) == {"attempts": 3, "choice_set": "arrow keys"}
    assert stored(
        data, "SELECT json_extract(parameters, '$.attempts') FROM settings WHERE participant='P02'"
    ) == [(2,)]


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
async def test_leaving_with_unsaved_changes_asks_once(opened: OpenApp, data: Path) -> None:
    async with opened() as driver:
        await driver.press("f2")
        await fill(driver, "attempts", "3")
        await driver.press("escape")
        assert driver.screen_name == "SettingsScreen"
        assert driver.sees("Not saved. Save with Ctrl-S, or")
        await driver.press("escape")
        assert driver.screen_name == "HomeScreen"
        await driver.press("f2", "escape")
        assert driver.screen_name == "HomeScreen"
    assert stored_settings(data)["attempts"] == 20


async def test_a_language_that_the_theme_lacks_is_reported_and_those_it_has_are_offered(
    opened: OpenApp, data: Path
) -> None:
    known(data, "P01", language="de")
    async with opened() as driver:
        await driver.press("f2")
        await go_to(driver, "language")
        assert meaning(driver) == (
            "The theme calm has no phrases in de; it has: en, es. "
            "Choose one of these, or give the theme a file phrases.de.toml."
        )
        await driver.press("enter", "e", "e", "enter")
        assert driver.sees("● Language es ▼")
        await save(driver)
        assert driver.sees("saved: version 2")
    assert stored_settings(data)["language"] == "es"


async def test_a_language_can_be_set_with_a_missing_theme(opened: OpenApp, data: Path) -> None:
    known(data, "P01", theme="gone")
    async with opened() as driver:
        await driver.press("f2")
        await fill(driver, "language", "es")
        assert meaning(driver).endswith("Default: en.")


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
async def test_outputs_are_picked_from_a_list_or_typed(opened: OpenApp) -> None:
    async with opened() as driver:
        await driver.press("f2")
        await go_to(driver, "outputs")
        await driver.press("enter")
        assert driver.sees("✓ screen")
        await driver.press("down", "down", "enter", "escape")
        assert field(driver, "outputs").value == "screen tones"
        await driver.press("enter", "enter", "escape")
        assert field(driver, "outputs").value == "tones"
        await fill(driver, "outputs", "ros://lab/x")
        assert field(driver, "outputs").value == "ros://lab/x"


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
async def test_titles_fit_beside_the_values(opened: OpenApp, catalogue: Catalogue) -> None:
    async with opened() as driver:
        for name in ("keyboard", "reaching", "pairs"):
            driver.app.push_screen(SettingsScreen("P01", catalogue.task(name)))
            await driver.settle()
            for widget in every_field(driver):
                assert len(widget.field.title) < 24, widget.field.name


# --- groups


@pytest.mark.slow
async def test_groups_count_what_differs_and_the_count_follows(opened: OpenApp, data: Path) -> None:
    known(
        data,
        "P01",
        attempts=20,
        prompts_per_attempt=5,
        operator_feedback="approve",
        operator_time_ms=6000,
    )
    async with opened() as driver:
        await driver.press("f2")
        assert driver.sees("Keyboard reaction ● 1")
        assert driver.sees("Operator ● 2")
        assert panel(driver, "Session").summary == ""
        await fill(driver, "operator_time_ms", "4000")
        assert driver.sees("Operator ● 1")
        driver.app.screen.query_one("#groups").focus()
        await driver.press("ctrl+r")
        assert panel(driver, "Operator").summary == ""
        assert field(driver, "prompts_per_attempt").is_changed
        assert driver.sees("not saved")


@pytest.mark.usefixtures("a_participant")
async def test_arrows_and_page_keys_move_between_groups_and_enter_goes_to_the_fields(
    opened: OpenApp,
) -> None:
    async with opened() as driver:
        await driver.press("f2")
        assert field(driver, "prompts_per_attempt").has_focus_within
        await driver.press("up", "down", "down")
        assert driver.app.focused is driver.app.screen.query_one("#groups")
        assert open_panels(driver) == ["Limits"]
        assert meaning(driver).endswith(" settings. Enter goes to them.")
        await driver.press("enter")
        assert field(driver, "session_minutes").has_focus_within
        await driver.press("pageup")
        assert field(driver, "attempts").has_focus_within
        await driver.press("pageup", "pageup")
        assert open_panels(driver) == ["Timing"]


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
async def test_a_group_opens_with_a_click(opened: OpenApp) -> None:
    async with opened() as driver:
        await driver.press("f2")
        await driver.pilot.click("#groups", offset=(3, 3))
        await driver.settle()
        assert open_panels(driver) == ["Difficulty"]


async def test_settings_that_were_never_shown_are_saved_and_reset_too(
    opened: OpenApp, data: Path
) -> None:
    known(data, "P01", attempts=20, prompts_per_attempt=20, quiet_ms=700, operator_lost_ms=3000)
    async with opened() as driver:
        await driver.press("f2")
        await fill(driver, "attempts", "7")
        await save(driver)
        assert stored_settings(data) == {"attempts": 7, "quiet_ms": 700, "operator_lost_ms": 3000}
        driver.app.screen.query_one("#reset-all").focus()
        await driver.press("enter")
        await save(driver)
        assert not any(field(driver, name).is_mounted for name in ("quiet_ms", "operator_lost_ms"))
    assert stored_settings(data) == {}


@pytest.mark.slow
async def test_the_help_of_a_level_says_what_it_is(data: Path, catalogue: Catalogue) -> None:
    known(data, "P01", start_level=5, choice_set="both hands")
    async with open_app(data, catalogue) as driver:
        await driver.press("f2")
        await go_to(driver, "start_level")
        assert meaning(driver).startswith("The level of the first attempt")
        assert "Level 5: " in meaning(driver)
        keys = catalogue.task("keyboard")(
            build(catalogue.task("keyboard").Parameters, {"start_level": 5})
        )
        assert meaning(driver).endswith(f"Level 5: {keys.level_name(5)}")
        await fill(driver, "start_level", "99")
        assert "Level" not in meaning(driver).replace("level 99", "")


# --- finding


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
async def test_a_setting_is_found_by_a_word_of_its_title_or_help(opened: OpenApp) -> None:
    async with opened() as driver:
        await driver.press("f2", "/")
        assert driver.screen_name == "FindSettingScreen"
        await driver.write(*"held key")
        assert driver.sees("Key repeat interval Timing")
        await driver.press("enter")
        assert open_panels(driver) == ["Timing"]
        assert field(driver, "repeat_interval_ms").has_focus_within
        await driver.press("/")
        await driver.write(*"rest")
        assert driver.sees("Rest reminder every Session")
        await driver.press("down", "up", "enter")
        assert field(driver, "rest_every").has_focus_within
        await driver.press("/", "escape")
        assert field(driver, "rest_every").has_focus_within
        await driver.press("/")
        await driver.write(*"xyzzy")
        await driver.press("enter")
        assert driver.screen_name == "FindSettingScreen"


# --- saving


@pytest.mark.usefixtures("a_participant")
async def test_saving_asks_for_a_reason_and_keeps_it(opened: OpenApp, data: Path) -> None:
    async with opened() as driver:
        await driver.press("f2", "ctrl+s")
        assert driver.sees("nothing has changed")
        await fill(driver, "threshold", "900")
        await driver.press("ctrl+s")
        assert driver.sees("● Goal 1000 → 900 ms")
        await driver.press("enter")
        assert driver.sees("A few words are enough.")
        await driver.press("escape")
        assert driver.sees("not saved")
        await driver.press("ctrl+s")
        await driver.write(*"Reached it")
        await driver.press("down")
        await driver.write("end", "ctrl+u")
        await driver.write(*"Ana")
        await driver.press("enter")
        assert driver.sees("Settings of P01 for Keyboard reaction: version 2")
    assert stored(data, "SELECT version, author, reason FROM programmes ORDER BY version") == [
        (1, "", ""),
        (2, "Ana", "Reached it"),
    ]


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
        assert driver.sees(
            "The programme of P01 was changed meanwhile: version 2 by Ben (Pain). Nothing was "
            "saved."
        )
        assert stored_settings(data)["attempts"] == 5
        await driver.press("ctrl+s")
        assert driver.sees("version 2 by Ben (Pain)")
        assert driver.sees("● Attempts 5 → 9")
        await driver.write(*"Agreed")
        await driver.press("enter")
        assert driver.sees("saved: version 3")
    assert stored(
        data, "SELECT json_extract(parameters, '$.attempts') FROM programmes ORDER BY version"
    ) == [(20,), (5,), (9,)]


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
async def test_a_preset_fills_in_its_values_and_saves_nothing(opened: OpenApp, data: Path) -> None:
    async with opened() as driver:
        await driver.press("f2")
        driver.app.screen.query_one("#preset").focus()
        await driver.press("enter")
        assert driver.sees("moderate Shorter attempts")
        await driver.press("down", "enter")
        assert driver.sees("● Prompts per attempt 15")
        assert driver.sees("not saved")
        assert stored_settings(data)["attempts"] == 20
        await save(driver)
    assert stored_settings(data)["threshold"] == 1500


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
        for downs in (3, 4):  # a, then b, after those of the task
            driver.app.screen.query_one("#preset", Button).press()
            await driver.settle()
            await driver.press(*["down"] * downs, "enter")
        assert driver.sees("and stays: Language.")
        await save(driver)
    assert stored_settings(data) == {"choice_set": "left hand", "threshold": 700.0}


async def test_settings_that_do_not_exist_any_more_are_told(opened: OpenApp, data: Path) -> None:
    known(data, "P01", tempo=3)
    async with opened() as driver:
        await driver.press("f2")
        assert driver.sees("These settings do not exist any more: tempo.")


# --- choices


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
async def test_choices_open_in_a_list(opened: OpenApp) -> None:
    async with opened() as driver:
        await driver.press("f2")
        await go_to(driver, "layout")
        choice = field(driver, "layout").query_one(Choice)
        await driver.press("down")
        assert driver.sees("azerty")
        await driver.press("down", "escape")
        assert choice.has_focus
        assert not driver.sees("azerty")
        assert field(driver, "layout").value == "qwerty"
        await driver.press("space", "a", "enter")
        assert driver.sees("● Keyboard layout azerty ▼")
        await driver.press("enter", "tab")
        assert not choice.children
        await driver.pilot.click(choice)
        await driver.press("up", "enter")
        assert field(driver, "layout").value == "qwerty"
        await driver.pilot.click(choice)
        await driver.pilot.click(choice)
        await driver.settle()
        assert choice.has_focus


async def test_a_choice_that_no_longer_exists_is_reported_and_can_be_changed(
    opened: OpenApp, data: Path
) -> None:
    known(data, "P01", attempts=20, layout="sholes")
    async with opened() as driver:
        await driver.press("f2")
        assert driver.sees("Keyboard layout sholes ▼")
        assert field(driver, "layout").note.endswith(", not sholes.")
        await go_to(driver, "layout")
        await driver.press("enter", "enter")
        assert field(driver, "layout").value == "qwerty"
        assert not driver.sees("to fix")

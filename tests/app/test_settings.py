"""Settings: a form made from a task's declaration, stored for one participant."""

from pathlib import Path
from typing import Annotated, Any

import msgspec
import pytest
from textual.widget import Widget

from sar_tui.app.screens.settings import SettingsScreen
from sar_tui.framework.declaration import meta, show
from sar_tui.framework.parameters import fields, grouped
from sar_tui.framework.task import Task
from sar_tui.plugins import Catalogue
from sar_tui.widgets.choice import Choice
from sar_tui.widgets.field_group import FieldGroup
from sar_tui.widgets.parameter_field import ParameterField
from tests.app.app_driver import AppDriver, known, open_app, stored


def groups(driver: AppDriver) -> list[FieldGroup]:
    return list(driver.app.screen.query(FieldGroup))


def every_field(driver: AppDriver) -> list[ParameterField]:
    """Return all fields, including folded ones."""
    return [widget for found in groups(driver) for widget in found.fields]


def field(driver: AppDriver, name: str) -> ParameterField:
    return next(widget for widget in every_field(driver) if widget.field.name == name)


def lines(widget: ParameterField) -> list[str]:
    """Return the drawing of a field."""
    return str(widget.render()).splitlines()


def reads(driver: AppDriver, name: str) -> str:
    """Return the text below a field."""
    return " ".join(" ".join(lines(field(driver, name))[1:]).split())


def group(driver: AppDriver, title: str) -> FieldGroup:
    """Return the group whose heading begins with a text."""
    return next(found for found in groups(driver) if title in found.heading.title)


def heading(found: FieldGroup) -> str:
    """The title and the text beside it."""
    return f"{found.heading.title} {found.heading.summary}".rstrip()


def on_the_form(driver: AppDriver) -> str:
    """Return the text of the form, without its scroll bar."""
    return " ".join(" ".join(row[:76] for row in driver.rows).split())


async def go_to(driver: AppDriver, name: str) -> None:
    """Focus a field, and unfold its heading."""
    around = next(found for found in groups(driver) if field(driver, name) in found.fields)
    if around.folded:
        around.heading.focus()
        await driver.press("enter")
    field(driver, name).focus_editor()
    await driver.settle()


async def fill(driver: AppDriver, name: str, text: str) -> None:
    """Replace the content of a field."""
    await go_to(driver, name)
    await driver.write("end", "ctrl+u")
    await driver.write(*text)


def stored_settings(data: Path) -> dict[str, Any]:
    """Return the stored settings of P01."""
    ((parameters,),) = stored(data, "SELECT parameters FROM settings WHERE participant='P01'")
    return dict(msgspec.json.decode(parameters))


@pytest.fixture
def a_participant(data: Path) -> None:
    known(data, "P01", attempts=20, prompts_per_attempt=20)


@pytest.mark.usefixtures("a_participant")
async def test_there_is_one_field_for_each_declared_parameter(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with open_app(data, catalogue, size=(80, 300)) as driver:
        await driver.press("f2")
        assert driver.sees("Settings of P01 for Keyboard reaction")
        for title in ("Operator", "Timing"):
            group(driver, title).heading.focus()
            await driver.press("enter")
        words, shown = on_the_form(driver), [widget.field for widget in driver.app.screen.query(ParameterField)]
        assert shown == [declared for under in grouped(keyboard.Parameters).values() for declared in under]
        for declared in shown:
            for part in (declared.title, declared.help, declared.unit, show(declared.default)):
                assert part in words
            assert declared.choices or declared.bounds in words


@pytest.mark.usefixtures("a_participant")
async def test_tab_reaches_every_heading_and_every_field_under_it_in_order(data: Path, catalogue: Catalogue) -> None:
    async with open_app(data, catalogue) as driver:
        await driver.press("f2")
        group(driver, "Timing").heading.focus()
        await driver.press("enter")
        order: list[Widget] = []
        for found in groups(driver):
            inside = () if found.folded else found.fields
            order += [found.heading, *(widget.query_one("Input, Choice") for widget in inside)]
        chain = driver.app.screen.focus_chain
        assert chain[: len(order)] == order
        assert [widget.id for widget in chain[len(order) :]] == ["save", "reset-all", "back"]
        await driver.write(*["tab"] * 6)
        assert field(driver, "repeat_interval_ms").has_focus_within
        assert "The same key again within this time is a held key, not a press." in on_the_form(driver)


@pytest.mark.usefixtures("a_participant")
async def test_a_new_parameter_has_a_field_without_further_changes(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    class More(keyboard.Parameters, frozen=True, kw_only=True):  # type: ignore[name-defined, misc]
        tempo: Annotated[int, meta("Tempo", "beats", "How fast the drum beats.", ge=1, le=9)] = 3
        drum: Annotated[bool, meta("Drum", help="Whether there is a drum.")] = True

    class Drummed(keyboard):  # type: ignore[valid-type, misc]
        Parameters = More

    async with open_app(data, catalogue) as driver:
        driver.app.push_screen(SettingsScreen("P01", Drummed))
        await driver.settle()
        assert len(every_field(driver)) == len(fields(keyboard.Parameters)) + 2
        await go_to(driver, "tempo")
        assert driver.sees("Tempo 3 beats (1 to 9)")
        assert driver.sees("How fast the drum beats.")
        await fill(driver, "tempo", "12")
        assert reads(driver, "tempo") == "Tempo is a whole number, 1 to 9, not 12."
        await fill(driver, "tempo", "7")
        await go_to(driver, "drum")
        assert driver.sees("Drum yes")
        await driver.press("enter", "down", "enter")
        assert driver.sees("● Drum no")
        await driver.press("ctrl+s")
    assert stored_settings(data) == {"tempo": 7, "drum": False}


@pytest.mark.usefixtures("a_participant")
async def test_values_are_checked_as_they_are_typed_alone_and_together(data: Path, catalogue: Catalogue) -> None:
    async with open_app(data, catalogue) as driver:
        await driver.press("f2")
        await fill(driver, "attempts", "2x")
        assert reads(driver, "attempts") == "Attempts is a whole number, 1 to 200, not 2x."
        assert driver.sees("1 to fix")
        await driver.press("backspace")
        assert reads(driver, "attempts") == "Number of attempts in a session. Default: 20."
        assert not driver.sees("to fix")
        assert driver.sees("not saved")
        await fill(driver, "foreperiod_min_ms", "1800")
        assert reads(driver, "foreperiod_min_ms") == "Shortest wait (1800 ms) is above the longest (1500 ms)."
        await fill(driver, "foreperiod_max_ms", "1900")
        assert "Default: 500." in reads(driver, "foreperiod_min_ms")
        await fill(driver, "start_level", "21")
        assert (
            reads(driver, "start_level") == "There are only 20 levels in this choice of keys, so there is no level 21."
        )


@pytest.mark.usefixtures("a_participant")
async def test_an_invalid_value_is_not_saved_and_gets_the_focus(data: Path, catalogue: Catalogue) -> None:
    async with open_app(data, catalogue) as driver:
        await driver.press("f2")
        await fill(driver, "attempts", "0")
        await go_to(driver, "prompts_per_attempt")
        await driver.press("ctrl+s")
        assert field(driver, "attempts").has_focus_within
        assert driver.sees("Attempts is a whole number, 1 to 200, not 0.")
    assert stored_settings(data)["attempts"] == 20


@pytest.mark.usefixtures("a_participant")
async def test_an_unknown_sensor_is_reported_at_its_field(data: Path, catalogue: Catalogue) -> None:
    async with open_app(data, catalogue) as driver:
        driver.app.push_screen(SettingsScreen("P01", catalogue.task("reaching")))
        await driver.settle()
        await fill(driver, "imu", "fidget")
        known = "phidget, recorded, ros, simulated, session"
        assert reads(driver, "imu") == f'There is no sensor "fidget". Choose one of: {known}.'
        await fill(driver, "imu", "simulated:steady")
        assert "There is no" not in reads(driver, "imu")


async def test_a_dot_marks_values_that_differ_from_the_default(data: Path, catalogue: Catalogue) -> None:
    known(data, "P01", prompts_per_attempt=5)
    async with open_app(data, catalogue) as driver:
        await driver.press("f2")
        assert driver.sees("● Prompts per attempt 5")
        assert not driver.sees("not saved")
        await fill(driver, "prompts_per_attempt", "20")
        assert driver.sees("not saved")
        assert "● Prompts" not in driver.text


async def test_a_setting_saved_under_a_former_spelling_shows_the_present_one(data: Path, catalogue: Catalogue) -> None:
    known(data, "P01", difficulty_policy="thesis")
    async with open_app(data, catalogue) as driver:
        await driver.press("f2")
        assert not field(driver, "difficulty_policy").is_changed
        assert show(field(driver, "difficulty_policy").value) == "one-up-one-down"


@pytest.mark.usefixtures("a_participant")
async def test_one_field_is_reset_or_all_of_them(data: Path, catalogue: Catalogue) -> None:
    async with open_app(data, catalogue) as driver:
        await driver.press("f2")
        await fill(driver, "prompts_per_attempt", "5")
        await fill(driver, "sequence_length", "6")
        await fill(driver, "attempts", "7")
        await driver.press("ctrl+r")
        assert driver.sees("Attempts 20")
        assert show(field(driver, "sequence_length").value) == "6"
        driver.app.screen.query_one("#reset-all").focus()
        await driver.press("enter")
        assert not any(widget.is_changed for widget in every_field(driver))


@pytest.mark.usefixtures("a_participant")
async def test_what_is_typed_after_a_reset_replaces_the_default(data: Path, catalogue: Catalogue) -> None:
    async with open_app(data, catalogue) as driver:
        await driver.press("f2")
        await fill(driver, "attempts", "7")
        await driver.press("ctrl+r")
        await driver.write("4")
        assert field(driver, "attempts").value == "4"
        await driver.press("ctrl+r", "end")
        await driver.write("4")
        assert field(driver, "attempts").value == "204", "unless the cursor is moved"


@pytest.mark.usefixtures("a_participant")
@pytest.mark.parametrize("sizes", [((80, 24),), ((30, 5), (80, 24)), ((80, 30), (79, 24), (80, 24))])
async def test_the_focused_field_stays_in_view_in_a_smaller_window(
    sizes: tuple[tuple[int, int], ...], data: Path, catalogue: Catalogue
) -> None:
    async with open_app(data, catalogue, size=(80, 50)) as driver:
        await driver.press("f2")
        form = driver.app.screen.query_one("#form")
        in_view = [each for each in every_field(driver) if each.region and each.region in form.region]
        for widget in (in_view[-1], group(driver, "Timing")):
            if isinstance(widget, ParameterField):
                widget.focus_editor()
            else:
                widget.heading.focus()
            for size in sizes:
                await driver.resize(*size)
            focused = driver.app.focused
            assert focused
            assert focused.region in form.region
            await driver.resize(80, 50)


@pytest.mark.usefixtures("a_participant")
async def test_saved_settings_apply_to_the_participants_next_session(data: Path, catalogue: Catalogue) -> None:
    known(data, "P02", attempts=2)
    async with open_app(data, catalogue) as driver:
        await driver.press("f2")
        await fill(driver, "attempts", "3")
        await go_to(driver, "choice_set")
        await driver.press("enter", "down", "enter")
        assert driver.app.screen.query_one("#parameter-choice_set").query_one(Choice).value == "arrow keys"
        await driver.press("ctrl+s")
        assert driver.sees("saved for P01")
        await driver.press("escape", *["right"] * 3, "enter", "enter")
        assert driver.sees("Press Enter to begin attempt 1 of 3.")
        assert (await driver.begin()).expected in ("left", "right")
    assert stored_settings(data) == {"attempts": 3, "choice_set": "arrow keys"}
    assert stored(data, "SELECT json_extract(parameters, '$.attempts') FROM settings WHERE participant='P02'") == [(2,)]


@pytest.mark.usefixtures("a_participant")
async def test_leaving_with_unsaved_changes_asks_once(data: Path, catalogue: Catalogue) -> None:
    async with open_app(data, catalogue) as driver:
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


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
async def test_a_yes_or_no_field_is_reset_like_any_other(data: Path, catalogue: Catalogue) -> None:
    async with open_app(data, catalogue) as driver:
        await driver.press("f2")
        await go_to(driver, "encouragement")
        await driver.press("enter", "down", "enter")
        assert field(driver, "encouragement").value is False
        assert driver.sees("not saved")
        await driver.press("ctrl+r")
        assert field(driver, "encouragement").value is True
        assert not driver.sees("not saved")


@pytest.mark.usefixtures("a_participant")
async def test_a_language_that_the_theme_lacks_is_reported_at_its_field(data: Path, catalogue: Catalogue) -> None:
    async with open_app(data, catalogue) as driver:
        await driver.press("f2")
        await fill(driver, "language", "de")
        assert reads(driver, "language") == (
            "The theme calm has no phrases in de; it has: en, es. "
            "Type one of these, or give the theme a file phrases.de.toml."
        )
        await driver.press("ctrl+s")
        assert driver.sees("1 to fix")
        await fill(driver, "language", "es-mx")
        await driver.press("ctrl+s")
        assert driver.sees("saved for P01")
    assert stored_settings(data)["language"] == "es-mx"


async def test_a_language_can_be_set_with_a_missing_theme(data: Path, catalogue: Catalogue) -> None:
    known(data, "P01", theme="gone")
    async with open_app(data, catalogue) as driver:
        await driver.press("f2")
        await fill(driver, "language", "es")
        assert reads(driver, "language").endswith("Default: en.")


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
async def test_titles_and_units_fit_beside_the_values(data: Path, catalogue: Catalogue) -> None:
    async with open_app(data, catalogue) as driver:
        for name in ("keyboard", "reaching"):
            driver.app.push_screen(SettingsScreen("P01", catalogue.task(name)))
            await driver.settle()
            for found in groups(driver):
                await found.fold(False)
            await driver.settle()
            for widget in every_field(driver):
                line = lines(widget)[0]
                assert line[2 + len(widget.field.title) : 28].strip() == ""
                assert len(line) <= widget.content_size.width, widget.field.name


# --- headings -------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("a_participant")
async def test_the_form_opens_in_the_tasks_first_field_and_headings_fold_with_a_key(
    data: Path, catalogue: Catalogue
) -> None:
    async with open_app(data, catalogue) as driver:
        await driver.press("f2")
        assert field(driver, "prompts_per_attempt").has_focus_within
        folded = {heading(found): found.folded for found in groups(driver)}
        assert next(iter(folded)) == "▼ Keyboard reaction"
        assert [words for words in folded if folded[words]] == [
            "▶ Operator 11 settings, none changed",
            "▶ Timing 6 settings, none changed",
        ]
        await driver.press("pageup")
        assert driver.sees("▼ Keyboard reaction Enter folds it")
        await driver.press("enter")
        assert driver.sees("▶ Keyboard reaction 6 settings, none changed Enter opens it")
        assert not driver.sees("Prompts per attempt")
        await driver.press("tab")
        assert group(driver, "Session").heading.has_focus
        await driver.press("up", "space")
        assert driver.sees("Prompts per attempt 20")
        await driver.press("space")
        assert not driver.sees("Prompts per attempt")


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
async def test_a_heading_opens_with_a_click(data: Path, catalogue: Catalogue) -> None:
    async with open_app(data, catalogue, size=(80, 300)) as driver:
        await driver.press("f2")
        await driver.pilot.click(group(driver, "Timing").heading)
        await driver.settle()
        assert not group(driver, "Timing").folded
        assert driver.sees("Shortest wait 500")


@pytest.mark.usefixtures("a_participant")
async def test_page_keys_move_between_headings_starting_with_the_current_one(data: Path, catalogue: Catalogue) -> None:
    async with open_app(data, catalogue) as driver:
        await driver.press("f2")
        found = groups(driver)
        for key, at in (("pageup", 0), ("pageup", 0), ("pagedown", 1), ("pagedown", 2)):
            await driver.press(key)
            assert found[at].heading.has_focus
        driver.app.screen.query_one("#back").focus()
        for key in ("pageup", "pagedown"):
            await driver.press(key)
            assert found[-1].heading.has_focus
        await go_to(driver, "start_level")
        await driver.press("pageup")
        assert driver.rows[2].split() == ["▼", "Difficulty", "Enter", "folds", "it"]
        await driver.press("pageup")
        assert found[1].heading.has_focus


async def test_a_folded_heading_shows_values_that_differ_from_the_defaults(data: Path, catalogue: Catalogue) -> None:
    known(data, "P01", operator_feedback="approve", operator_time_ms=6000, levels=["fj"])
    async with open_app(data, catalogue) as driver:
        await driver.press("f2")
        assert heading(group(driver, "Operator")) == "▶ Operator ● feedback: approve, time to decide: 6000 ms"
        group(driver, "Operator").heading.focus()
        await driver.settle()
        assert driver.sees("▶ Operator ● feedback: approve, time to decide: 6000 ms")
        await driver.press("ctrl+r")
        assert heading(group(driver, "Operator")) == "▶ Operator 11 settings, none changed"
        assert field(driver, "levels").is_changed
        assert driver.sees("not saved")


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
async def test_emptied_settings_are_shown_as_none(data: Path, catalogue: Catalogue) -> None:
    async with open_app(data, catalogue) as driver:
        driver.app.push_screen(SettingsScreen("P01", catalogue.task("reaching")))
        await driver.settle()
        await fill(driver, "outputs", "")
        group(driver, "Agent").heading.focus()
        await driver.press("enter")
        assert heading(group(driver, "Agent")) == "▶ Agent ● outputs: none"


@pytest.mark.usefixtures("a_participant")
async def test_an_invalid_value_unfolds_its_heading(data: Path, catalogue: Catalogue) -> None:
    async with open_app(data, catalogue) as driver:
        await driver.press("f2")
        await fill(driver, "foreperiod_max_ms", "400")
        assert reads(driver, "foreperiod_min_ms") == "Shortest wait (500 ms) is above the longest (400 ms)."
        group(driver, "Timing").heading.focus()
        await driver.press("enter")
        assert heading(group(driver, "Timing")) == "▶ Timing 1 to fix"
        await fill(driver, "attempts", "7")
        assert not group(driver, "Timing").folded
        group(driver, "Timing").heading.focus()
        await driver.press("enter", "ctrl+s")
        assert field(driver, "foreperiod_min_ms").has_focus_within
        assert driver.sees("Shortest wait (500 ms) is above the longest (400 ms).")
    assert stored_settings(data)["attempts"] == 20


@pytest.mark.slow
@pytest.mark.usefixtures("a_participant")
async def test_folded_settings_are_saved_too(data: Path, catalogue: Catalogue) -> None:
    async with open_app(data, catalogue) as driver:
        await driver.press("f2")
        await fill(driver, "quiet_ms", "700")
        group(driver, "Timing").heading.focus()
        await driver.press("enter", "ctrl+s")
        assert heading(group(driver, "Timing")) == "▶ Timing ● quiet before a prompt: 700 ms"
        assert driver.sees("saved for P01")
    assert stored_settings(data) == {"quiet_ms": 700}


async def test_settings_that_were_never_unfolded_are_saved_and_reset_too(data: Path, catalogue: Catalogue) -> None:
    known(data, "P01", attempts=20, prompts_per_attempt=20, quiet_ms=700, operator_lost_ms=3000)
    async with open_app(data, catalogue) as driver:
        await driver.press("f2")
        group(driver, "Operator").heading.focus()
        await driver.press("ctrl+r", "ctrl+s")
        assert driver.sees("saved for P01")
        assert stored_settings(data) == {"quiet_ms": 700}
        driver.app.screen.query_one("#reset-all").focus()
        await driver.press("enter", "ctrl+s")
        assert not any(field(driver, name).is_mounted for name in ("quiet_ms", "operator_lost_ms"))
        group(driver, "Timing").heading.focus()
        await driver.press("enter")
        assert driver.sees("Quiet before a prompt 500")
    assert stored_settings(data) == {}


@pytest.mark.slow
async def test_an_invalid_stored_value_is_unfolded_when_the_form_opens(data: Path, catalogue: Catalogue) -> None:
    known(data, "P01", attempts=20, prompts_per_attempt=20, quiet_ms=9999)
    async with open_app(data, catalogue, size=(80, 300)) as driver:
        await driver.press("f2")
        assert driver.sees("Quiet before a prompt is a whole number, 0 to 5000, not 9999.")
        assert driver.sees("1 to fix")


# --- choices --------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("a_participant")
async def test_choices_open_in_a_list(data: Path, catalogue: Catalogue) -> None:
    async with open_app(data, catalogue) as driver:
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


async def test_a_choice_that_no_longer_exists_is_reported_and_can_be_changed(data: Path, catalogue: Catalogue) -> None:
    known(data, "P01", attempts=20, layout="sholes")
    async with open_app(data, catalogue) as driver:
        await driver.press("f2")
        assert driver.sees("Keyboard layout sholes ▼")
        assert reads(driver, "layout").endswith(", not sholes.")
        await go_to(driver, "layout")
        await driver.press("enter", "enter")
        assert field(driver, "layout").value == "qwerty"
        assert not driver.sees("to fix")

"""Settings: a form made from a task's declaration, kept for one participant."""

from pathlib import Path
from typing import Annotated, Any

import msgspec
import pytest
from textual.widget import Widget

from sar_tui.app.screens.settings import SettingsScreen
from sar_tui.framework.parameter_groups import grouped
from sar_tui.framework.parameters import fields, meta, show
from sar_tui.framework.task import Task
from sar_tui.plugins import Catalogue
from sar_tui.widgets.choice import Choice
from sar_tui.widgets.field_group import FieldGroup
from sar_tui.widgets.parameter_field import ParameterField
from tests.app.chair import Chair, known, sit_down, stored


def groups(chair: Chair) -> list[FieldGroup]:
    return list(chair.app.screen.query(FieldGroup))


def every_field(chair: Chair) -> list[ParameterField]:
    """Those that are folded away as well."""
    return [widget for found in groups(chair) for widget in found.fields]


def field(chair: Chair, name: str) -> ParameterField:
    return next(widget for widget in every_field(chair) if widget.field.name == name)


def lines(widget: ParameterField) -> list[str]:
    """What a field draws."""
    return str(widget.render()).splitlines()


def reads(chair: Chair, name: str) -> str:
    """What stands under a field."""
    return " ".join(" ".join(lines(field(chair, name))[1:]).split())


def group(chair: Chair, title: str) -> FieldGroup:
    """The heading that begins with some words, and what stands under it."""
    return next(found for found in groups(chair) if title in found.heading.title)


def heading(found: FieldGroup) -> str:
    """The title and what is told beside it."""
    return f"{found.heading.title} {found.heading.told}".rstrip()


def on_the_form(chair: Chair) -> str:
    """All that can be read left of the scroll bar."""
    return " ".join(" ".join(row[:76] for row in chair.rows).split())


async def go_to(chair: Chair, name: str) -> None:
    """Put the cursor into a field, and open its heading for that."""
    around = next(found for found in groups(chair) if field(chair, name) in found.fields)
    if around.folded:
        around.heading.focus()
        await chair.press("enter")
    field(chair, name).focus_editor()
    await chair.settle()


async def fill(chair: Chair, name: str, text: str) -> None:
    """Replace what a field holds."""
    await go_to(chair, name)
    await chair.write("end", "ctrl+u")
    await chair.write(*text)


def kept(data: Path) -> dict[str, Any]:
    """The settings of P01 as they are stored."""
    ((parameters,),) = stored(data, "SELECT parameters FROM settings WHERE participant='P01'")
    return dict(msgspec.json.decode(parameters))


@pytest.fixture
def a_participant(data: Path) -> None:
    known(data, "P01", attempts=20, prompts_per_attempt=20)


@pytest.mark.usefixtures("a_participant")
async def test_there_is_one_field_for_each_declared_parameter(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, size=(80, 200)) as chair:
        await chair.press("f2")
        assert chair.sees("Settings of P01 for Keyboard reaction")
        for title in ("Operator", "Timing"):
            group(chair, title).heading.focus()
            await chair.press("enter")
        words, shown = on_the_form(chair), [widget.field for widget in chair.app.screen.query(ParameterField)]
        assert shown == [declared for under in grouped(keyboard.Parameters).values() for declared in under]
        for declared in shown:
            for part in (declared.title, declared.help, declared.unit, show(declared.default)):
                assert part in words
            assert declared.choices or declared.bounds in words


@pytest.mark.usefixtures("a_participant")
async def test_tab_reaches_every_heading_and_every_field_under_it_in_order(data: Path, catalogue: Catalogue) -> None:
    async with sit_down(data, catalogue) as chair:
        await chair.press("f2")
        group(chair, "Timing").heading.focus()
        await chair.press("enter")
        order: list[Widget] = []
        for found in groups(chair):
            inside = () if found.folded else found.fields
            order += [found.heading, *(widget.query_one("Input, Choice") for widget in inside)]
        chain = chair.app.screen.focus_chain
        assert chain[: len(order)] == order
        assert [widget.id for widget in chain[len(order) :]] == ["save", "reset-all", "back"]
        await chair.write(*["tab"] * 6)
        assert field(chair, "repeat_interval_ms").has_focus_within
        assert "The same key again within this time is a held key, not a press." in on_the_form(chair)


@pytest.mark.usefixtures("a_participant")
async def test_a_parameter_that_a_task_adds_has_a_field_with_no_other_change(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    class More(keyboard.Parameters, frozen=True, kw_only=True):  # type: ignore[name-defined, misc]
        tempo: Annotated[int, meta("Tempo", "beats", "How fast the drum beats.", ge=1, le=9)] = 3
        drum: Annotated[bool, meta("Drum", help="Whether there is a drum.")] = True

    class Drummed(keyboard):  # type: ignore[valid-type, misc]
        Parameters = More

    async with sit_down(data, catalogue) as chair:
        chair.app.push_screen(SettingsScreen("P01", Drummed))
        await chair.settle()
        assert len(every_field(chair)) == len(fields(keyboard.Parameters)) + 2
        await go_to(chair, "tempo")
        assert chair.sees("Tempo 3 beats (1 to 9)")
        assert chair.sees("How fast the drum beats.")
        await fill(chair, "tempo", "12")
        assert reads(chair, "tempo") == "Tempo is a whole number, 1 to 9, not 12."
        await fill(chair, "tempo", "7")
        await go_to(chair, "drum")
        assert chair.sees("Drum yes")
        await chair.press("enter", "down", "enter")
        assert chair.sees("● Drum no")
        await chair.press("ctrl+s")
    assert kept(data) == {"tempo": 7, "drum": False}


@pytest.mark.usefixtures("a_participant")
async def test_a_value_is_checked_as_it_is_typed(data: Path, catalogue: Catalogue) -> None:
    async with sit_down(data, catalogue) as chair:
        await chair.press("f2")
        await fill(chair, "attempts", "2x")
        assert reads(chair, "attempts") == "Attempts is a whole number, 1 to 200, not 2x."
        assert chair.sees("1 to mend")
        await chair.press("backspace")
        assert reads(chair, "attempts") == "How many attempts a session has. Default: 20."
        assert not chair.sees("to mend")
        assert chair.sees("not saved")


@pytest.mark.usefixtures("a_participant")
async def test_settings_that_do_not_go_together_are_told_at_the_field(data: Path, catalogue: Catalogue) -> None:
    async with sit_down(data, catalogue) as chair:
        await chair.press("f2")
        await fill(chair, "foreperiod_min_ms", "1800")
        assert reads(chair, "foreperiod_min_ms") == "Shortest wait (1800 ms) is above the longest (1500 ms)."
        await fill(chair, "foreperiod_max_ms", "1900")
        assert "Default: 500." in reads(chair, "foreperiod_min_ms")
        await fill(chair, "start_level", "11")
        assert (
            reads(chair, "start_level") == "There are only 10 levels in this choice of keys, so there is no level 11."
        )


@pytest.mark.usefixtures("a_participant")
async def test_what_is_wrong_is_not_saved_and_is_gone_to(data: Path, catalogue: Catalogue) -> None:
    async with sit_down(data, catalogue) as chair:
        await chair.press("f2")
        await fill(chair, "attempts", "0")
        await go_to(chair, "prompts_per_attempt")
        await chair.press("ctrl+s")
        assert field(chair, "attempts").has_focus_within
        assert chair.sees("Attempts is a whole number, 1 to 200, not 0.")
    assert kept(data)["attempts"] == 20


@pytest.mark.usefixtures("a_participant")
async def test_a_sensor_that_there_is_not_is_told_where_it_is_set(data: Path, catalogue: Catalogue) -> None:
    async with sit_down(data, catalogue) as chair:
        chair.app.push_screen(SettingsScreen("P01", catalogue.task("reaching")))
        await chair.settle()
        await fill(chair, "imu", "fidget")
        known = "phidget, recorded, ros, simulated, session"
        assert reads(chair, "imu") == f'There is no sensor "fidget". There is: {known}.'
        await fill(chair, "imu", "simulated:steady")
        assert "There is no" not in reads(chair, "imu")


async def test_a_dot_marks_what_differs_from_the_default(data: Path, catalogue: Catalogue) -> None:
    known(data, "P01", prompts_per_attempt=5)
    async with sit_down(data, catalogue) as chair:
        await chair.press("f2")
        assert chair.sees("● Prompts per attempt 5")
        assert not chair.sees("not saved")
        await fill(chair, "prompts_per_attempt", "20")
        assert chair.sees("not saved")
        assert "● Prompts" not in chair.text


@pytest.mark.usefixtures("a_participant")
async def test_one_field_is_reset_or_all_of_them(data: Path, catalogue: Catalogue) -> None:
    async with sit_down(data, catalogue) as chair:
        await chair.press("f2")
        await fill(chair, "prompts_per_attempt", "5")
        await fill(chair, "sequence_length", "6")
        await fill(chair, "attempts", "7")
        await chair.press("ctrl+r")
        assert chair.sees("Attempts 20")
        assert show(field(chair, "sequence_length").value) == "6"
        chair.app.screen.query_one("#reset-all").focus()
        await chair.press("enter")
        assert not any(widget.is_changed for widget in every_field(chair))


@pytest.mark.usefixtures("a_participant")
async def test_saved_settings_are_those_of_the_participants_next_session(data: Path, catalogue: Catalogue) -> None:
    known(data, "P02", attempts=2)
    async with sit_down(data, catalogue) as chair:
        await chair.press("f2")
        await fill(chair, "attempts", "3")
        await go_to(chair, "choice_set")
        await chair.press("enter", "down", "enter")
        assert chair.app.screen.query_one("#parameter-choice_set").query_one(Choice).value == "arrow keys"
        await chair.press("ctrl+s")
        assert chair.sees("saved for P01")
        await chair.press("escape", *["right"] * 3, "enter", "enter")
        assert chair.sees("Press Enter to begin attempt 1 of 3.")
        assert (await chair.begin()).expected in ("left", "right")
    assert kept(data) == {"attempts": 3, "choice_set": "arrow keys"}
    assert stored(data, "SELECT json_extract(parameters, '$.attempts') FROM settings WHERE participant='P02'") == [(2,)]


@pytest.mark.usefixtures("a_participant")
async def test_leaving_asks_once_if_something_was_not_saved(data: Path, catalogue: Catalogue) -> None:
    async with sit_down(data, catalogue) as chair:
        await chair.press("f2")
        await fill(chair, "attempts", "3")
        await chair.press("escape")
        assert chair.screen_name == "SettingsScreen"
        assert chair.sees("Not saved yet. Save with Ctrl-S, or")
        await chair.press("escape")
        assert chair.screen_name == "HomeScreen"
        await chair.press("f2", "escape")
        assert chair.screen_name == "HomeScreen"
    assert kept(data)["attempts"] == 20


@pytest.mark.usefixtures("a_participant")
async def test_yes_or_no_is_put_back_like_any_other(data: Path, catalogue: Catalogue) -> None:
    async with sit_down(data, catalogue) as chair:
        await chair.press("f2")
        await go_to(chair, "encouragement")
        await chair.press("enter", "down", "enter")
        assert field(chair, "encouragement").value is False
        assert chair.sees("not saved")
        await chair.press("ctrl+r")
        assert field(chair, "encouragement").value is True
        assert not chair.sees("not saved")


@pytest.mark.usefixtures("a_participant")
async def test_a_language_that_the_participants_theme_lacks_is_told_where_it_is_set(
    data: Path, catalogue: Catalogue
) -> None:
    async with sit_down(data, catalogue) as chair:
        await chair.press("f2")
        await fill(chair, "language", "de")
        assert reads(chair, "language") == (
            "The theme calm has no de; it has: en, es. Type one of these, or give the theme a file phrases.de.toml."
        )
        await chair.press("ctrl+s")
        assert chair.sees("1 to mend")
        await fill(chair, "language", "es-mx")
        await chair.press("ctrl+s")
        assert chair.sees("saved for P01")
    assert kept(data)["language"] == "es-mx"


async def test_a_theme_that_is_gone_keeps_nobody_from_setting_a_language(data: Path, catalogue: Catalogue) -> None:
    known(data, "P01", theme="gone")
    async with sit_down(data, catalogue) as chair:
        await chair.press("f2")
        await fill(chair, "language", "es")
        assert reads(chair, "language").endswith("Default: en.")


@pytest.mark.usefixtures("a_participant")
async def test_no_title_touches_its_value_and_no_unit_is_cut_off(data: Path, catalogue: Catalogue) -> None:
    async with sit_down(data, catalogue) as chair:
        for name in ("keyboard", "reaching"):
            chair.app.push_screen(SettingsScreen("P01", catalogue.task(name)))
            await chair.settle()
            for found in groups(chair):
                await found.fold(False)
            await chair.settle()
            for widget in every_field(chair):
                line = lines(widget)[0]
                assert line[2 + len(widget.field.title) : 28].strip() == ""
                assert len(line) <= widget.content_size.width, widget.field.name


# --- headings -------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("a_participant")
async def test_the_form_opens_in_the_tasks_first_field_with_what_few_need_folded_away(
    data: Path, catalogue: Catalogue
) -> None:
    async with sit_down(data, catalogue) as chair:
        await chair.press("f2")
        assert field(chair, "prompts_per_attempt").has_focus_within
        folded = {heading(found): found.folded for found in groups(chair)}
        assert next(iter(folded)) == "▼ Keyboard reaction"
        assert [words for words in folded if folded[words]] == [
            "▶ Operator 10 settings, none changed",
            "▶ Timing 6 settings, none changed",
        ]


@pytest.mark.usefixtures("a_participant")
async def test_a_heading_opens_and_folds_with_a_key(data: Path, catalogue: Catalogue) -> None:
    async with sit_down(data, catalogue) as chair:
        await chair.press("f2", "pageup")
        assert chair.sees("▼ Keyboard reaction Enter folds it")
        await chair.press("enter")
        assert chair.sees("▶ Keyboard reaction 6 settings, none changed Enter opens it")
        assert not chair.sees("Prompts per attempt")
        await chair.press("tab")
        assert group(chair, "Session").heading.has_focus
        await chair.press("up", "space")
        assert chair.sees("Prompts per attempt 20")
        await chair.press("space")
        assert not chair.sees("Prompts per attempt")


@pytest.mark.usefixtures("a_participant")
async def test_a_heading_opens_with_a_click(data: Path, catalogue: Catalogue) -> None:
    async with sit_down(data, catalogue, size=(80, 200)) as chair:
        await chair.press("f2")
        await chair.pilot.click(group(chair, "Timing").heading)
        await chair.settle()
        assert not group(chair, "Timing").folded
        assert chair.sees("Shortest wait 500")


@pytest.mark.usefixtures("a_participant")
async def test_page_keys_go_from_heading_to_heading_and_first_to_ones_own(data: Path, catalogue: Catalogue) -> None:
    async with sit_down(data, catalogue) as chair:
        await chair.press("f2")
        found = groups(chair)
        for key, at in (("pageup", 0), ("pageup", 0), ("pagedown", 1), ("pagedown", 2)):
            await chair.press(key)
            assert found[at].heading.has_focus
        chair.app.screen.query_one("#back").focus()
        for key in ("pageup", "pagedown"):
            await chair.press(key)
            assert found[-1].heading.has_focus
        await go_to(chair, "start_level")
        await chair.press("pageup")
        assert chair.rows[2].split() == ["▼", "Difficulty", "Enter", "folds", "it"]
        await chair.press("pageup")
        assert found[1].heading.has_focus


async def test_a_folded_heading_tells_what_differs_from_the_defaults(data: Path, catalogue: Catalogue) -> None:
    known(data, "P01", operator_feedback="approve", operator_time_ms=6000, levels=["fj"])
    async with sit_down(data, catalogue) as chair:
        await chair.press("f2")
        assert heading(group(chair, "Operator")) == "▶ Operator ● feedback: approve, time to decide: 6000 ms"
        group(chair, "Operator").heading.focus()
        await chair.settle()
        assert chair.sees("▶ Operator ● feedback: approve, time to decide: 6000 ms")
        await chair.press("ctrl+r")
        assert heading(group(chair, "Operator")) == "▶ Operator 10 settings, none changed"
        assert field(chair, "levels").is_changed
        assert chair.sees("not saved")


@pytest.mark.usefixtures("a_participant")
async def test_emptied_settings_are_told_as_none(data: Path, catalogue: Catalogue) -> None:
    async with sit_down(data, catalogue) as chair:
        chair.app.push_screen(SettingsScreen("P01", catalogue.task("reaching")))
        await chair.settle()
        await fill(chair, "outputs", "")
        group(chair, "Agent").heading.focus()
        await chair.press("enter")
        assert heading(group(chair, "Agent")) == "▶ Agent ● outputs: none"


@pytest.mark.usefixtures("a_participant")
async def test_what_is_wrong_unfolds_its_heading(data: Path, catalogue: Catalogue) -> None:
    async with sit_down(data, catalogue) as chair:
        await chair.press("f2")
        await fill(chair, "foreperiod_max_ms", "400")
        assert reads(chair, "foreperiod_min_ms") == "Shortest wait (500 ms) is above the longest (400 ms)."
        group(chair, "Timing").heading.focus()
        await chair.press("enter")
        assert heading(group(chair, "Timing")) == "▶ Timing 1 to mend"
        await fill(chair, "attempts", "7")
        assert not group(chair, "Timing").folded
        group(chair, "Timing").heading.focus()
        await chair.press("enter", "ctrl+s")
        assert field(chair, "foreperiod_min_ms").has_focus_within
        assert chair.sees("Shortest wait (500 ms) is above the longest (400 ms).")
    assert kept(data)["attempts"] == 20


@pytest.mark.usefixtures("a_participant")
async def test_what_is_folded_away_is_saved_all_the_same(data: Path, catalogue: Catalogue) -> None:
    async with sit_down(data, catalogue) as chair:
        await chair.press("f2")
        await fill(chair, "quiet_ms", "700")
        group(chair, "Timing").heading.focus()
        await chair.press("enter", "ctrl+s")
        assert heading(group(chair, "Timing")) == "▶ Timing ● quiet before a prompt: 700 ms"
        assert chair.sees("saved for P01")
    assert kept(data) == {"quiet_ms": 700}


async def test_what_was_never_unfolded_is_saved_and_put_back_as_well(data: Path, catalogue: Catalogue) -> None:
    known(data, "P01", attempts=20, prompts_per_attempt=20, quiet_ms=700, operator_lost_ms=3000)
    async with sit_down(data, catalogue) as chair:
        await chair.press("f2")
        group(chair, "Operator").heading.focus()
        await chair.press("ctrl+r", "ctrl+s")
        assert chair.sees("saved for P01")
        assert kept(data) == {"quiet_ms": 700}
        chair.app.screen.query_one("#reset-all").focus()
        await chair.press("enter", "ctrl+s")
        assert not any(field(chair, name).is_mounted for name in ("quiet_ms", "operator_lost_ms"))
        group(chair, "Timing").heading.focus()
        await chair.press("enter")
        assert chair.sees("Quiet before a prompt 500")
    assert kept(data) == {}


async def test_what_is_kept_wrong_is_unfolded_as_the_form_opens(data: Path, catalogue: Catalogue) -> None:
    known(data, "P01", attempts=20, prompts_per_attempt=20, quiet_ms=9999)
    async with sit_down(data, catalogue, size=(80, 200)) as chair:
        await chair.press("f2")
        assert chair.sees("Quiet before a prompt is a whole number, 0 to 5000, not 9999.")
        assert chair.sees("1 to mend")


# --- choices --------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("a_participant")
async def test_a_choice_is_made_from_a_list_that_opens(data: Path, catalogue: Catalogue) -> None:
    async with sit_down(data, catalogue) as chair:
        await chair.press("f2")
        await go_to(chair, "layout")
        choice = field(chair, "layout").query_one(Choice)
        await chair.press("down")
        assert chair.sees("azerty")
        await chair.press("down", "escape")
        assert choice.has_focus
        assert not chair.sees("azerty")
        assert field(chair, "layout").value == "qwerty"
        await chair.press("space", "a", "enter")
        assert chair.sees("● Keyboard layout azerty ▼")
        await chair.press("enter", "tab")
        assert not choice.children
        await chair.pilot.click(choice)
        await chair.press("up", "enter")
        assert field(chair, "layout").value == "qwerty"
        await chair.pilot.click(choice)
        await chair.pilot.click(choice)
        await chair.settle()
        assert choice.has_focus


async def test_a_choice_that_there_is_no_more_is_told_and_another_can_be_made(data: Path, catalogue: Catalogue) -> None:
    known(data, "P01", attempts=20, layout="sholes")
    async with sit_down(data, catalogue) as chair:
        await chair.press("f2")
        assert chair.sees("Keyboard layout sholes ▼")
        assert reads(chair, "layout").endswith(", not sholes.")
        await go_to(chair, "layout")
        await chair.press("enter", "enter")
        assert field(chair, "layout").value == "qwerty"
        assert not chair.sees("to mend")

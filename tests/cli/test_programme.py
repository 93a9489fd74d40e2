"""``sar-tui programme``: shows, exports, imports programmes, and lists their versions and
presets.
"""

import io
import tomllib
from contextlib import closing
from pathlib import Path
from typing import Annotated, Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop.task import Task
from sar_tui.plugins import Catalogue
from sar_tui.rules.declaration import meta
from sar_tui.rules.parameters import build, changed, fields
from sar_tui.runs.plan import make_plan
from sar_tui.runs.programme_file import (
    ProgrammeFile,
    applied,
    files,
    find,
    not_applied,
    parse,
    read,
    write,
)
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import participants, programmes, sessions
from sar_tui.store.database import connect
from sar_tui.store.programmes import Programme
from tests.examples import examples
from tests.program import Call

WHY = ("--reason", "Reached the goal", "--author", "ana")


def save(
    data: Path, after: int, author: str = "ana", reason: str = "Start", **parameters: Any
) -> None:
    with closing(connect(data)) as database:
        participants.add(database, "P07")
        changed = Programme(parameters)
        programmes.save(
            database, "P07", "keyboard", changed, after=after, author=author, reason=reason
        )


def newest(data: Path) -> Programme:
    with closing(connect(data)) as database:
        return programmes.newest(database, "P07", "keyboard")


# --- shown


def test_a_programme_shows_what_differs_who_saved_it_and_why(call: Call, data: Path) -> None:
    save(data, 0, attempts=12, threshold=900.0)
    called = call("programme show p07")
    assert (called.code, called.err) == (0, "")
    words = " ".join(called.out.split())
    assert "P07, Keyboard reaction: version 1" in words
    assert "by ana Why Start Theme calm" in words
    assert "Attempts 12 20 attempts" in words
    assert "Goal 900 ms 1000 threshold" in words
    (row,) = call("programme show P07 keyboard --json").json["programmes"]
    assert row["parameters"] == {"attempts": 12, "threshold": 900.0}
    assert (row["participant"], row["task"], row["version"], row["author"]) == (
        "P07",
        "keyboard",
        1,
        "ana",
    )


def test_the_history_tells_who_changed_what_and_why_the_newest_first(
    call: Call, data: Path
) -> None:
    save(data, 0, attempts=12)
    save(data, 1, "ben", "Tired after eight", attempts=8)
    called = call("programme history P07")
    lines = [line for line in called.out.splitlines() if "Attempts" in line]
    assert "by ben" in lines[0]
    assert "Attempts 12 → 8" in lines[0]
    assert "Tired after eight" in lines[0]
    assert "Attempts 20 → 12" in lines[1]
    rows = call("programme history P07 --json").json["versions"]
    assert [row["version"] for row in rows] == [2, 1]
    assert rows[0]["changes"] == [
        {"name": "attempts", "title": "Attempts", "unit": "", "before": 12, "after": 8}
    ]
    assert (
        call("programme show P07 --version 1 keyboard --json").json["programmes"][0]["version"] == 1
    )


def test_a_participant_without_a_programme_and_one_who_does_not_exist_are_told_apart(
    call: Call, data: Path
) -> None:
    with closing(connect(data)) as database:
        participants.add(database, "P07")
    for command in ("show", "history"):
        called = call("programme", command, "P07")
        assert called.code == 0
        assert "P07 has no programme yet" in called.out
        assert call("programme", command, "P09") == (
            2,
            "",
            "There is no participant P09. Is it P07?\n",
        )
    assert "its defaults are used" in call("programme show P07 keyboard").out


def test_a_session_shows_the_version_that_it_ran(call: Call, data: Path, simulated: str) -> None:
    save(data, 0, attempts=12)
    with closing(connect(data)) as database:
        database.execute("UPDATE seats SET participant='P07'")
        database.execute("UPDATE sessions SET programme=1")
    called = call("show last")
    assert "Programme    version 1 by ana: Start" in called.out
    assert call("show last --json").json["session"]["programme"] == 1


def test_values_that_cannot_be_used_any_more_are_told(call: Call, data: Path) -> None:
    save(data, 0, attempts=12, tempo=3)
    assert (
        "! Not used: The setting tempo does not exist any more." in call("programme show P07").out
    )
    (row,) = call("programme show P07 --json").json["programmes"]
    assert row["left_out"] == {"tempo": "The setting tempo does not exist any more."}
    assert call("programme history P07").code == 0
    assert call("programme export P07 keyboard").code == 0


# --- files


def test_an_exported_programme_names_every_setting_and_is_imported_for_another(
    call: Call, data: Path, tmp_path: Path, keyboard: type[Task]
) -> None:
    save(data, 0, attempts=12, levels=["fj", "dfjk"], choice_set="left hand")
    text = call("programme export P07 keyboard").out
    assert all(
        f"\n{field.name} = " in text or f"\n# {field.name} = " in text
        for field in fields(keyboard.Parameters)
    )
    assert tomllib.loads(text)["parameters"] == {
        "attempts": 12,
        "levels": ["fj", "dfjk"],
        "choice_set": "left hand",
    }
    file = tmp_path / "p07.toml"
    assert call("programme export P07 keyboard --to", file).code == 0
    assert call("programme export P07 keyboard --to", file).code == 2
    called = call("programme import p08 keyboard", file, *WHY, "--new")
    assert called.out == "Saved version 1 of the programme of P08 for Keyboard reaction.\n"
    (row,) = call("programme show P08 --json").json["programmes"]
    assert row["parameters"] == {
        "attempts": 12,
        "levels": ["fj", "dfjk"],
        "choice_set": "left hand",
    }
    assert row["reason"] == "Reached the goal"
    again = call("programme import p08 keyboard", file, *WHY)
    assert (
        again.out
        == "Nothing differs from version 1 of the programme of P08 for Keyboard reaction.\n"
    )


def test_a_file_exported_before_another_change_is_refused_unless_it_is_meant(
    call: Call, data: Path, tmp_path: Path
) -> None:
    save(data, 0, attempts=12)
    file = tmp_path / "p07.toml"
    call("programme export P07 keyboard --to", file)
    save(data, 1, "ben", "Tired", attempts=8)
    file.write_text(file.read_text().replace("attempts = 12", "attempts = 15"))
    refused = call("programme import P07 keyboard", file, *WHY)
    assert (refused.code, refused.out) == (2, "")
    assert "changed meanwhile: version 2 by ben (Tired). Nothing was saved." in refused.err
    assert newest(data).parameters == {"attempts": 8}
    assert call("programme import P07 keyboard", file, "--anyway", *WHY).code == 0
    assert (newest(data).version, newest(data).parameters) == (3, {"attempts": 15})


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (
            'task = "keyboard"\n[parameters]\nattempts = 0\n',
            "Attempts is a whole number, 1 to 200, not 0.",
        ),
        (
            'task = "keyboard"\n[parameters]\nattemps = 3\n',
            "There is no parameter attemps. Did you mean attempts?",
        ),
        ('task = "keyboard"\n[parameters]\nlanguage = "de"\n', "has no phrases in de"),
        ('task = "keyboard"\ntheme = "gone"\n', "There is no theme gone."),
        ('task = "reaching"\n', "This programme is for the task reaching, not keyboard."),
        (
            'task = "keyboard"\nattempts = 3\n',
            "has unknown entries: attempts. Settings belong under [parameters].",
        ),
        ("attempts 3", "is not valid TOML"),
        ("", "is not a programme"),
        ("\udcff", "is not a text in UTF-8"),
    ],
)
def test_a_file_that_does_not_fit_is_refused_with_the_reason(
    call: Call, data: Path, tmp_path: Path, content: str, says: str
) -> None:
    save(data, 0, attempts=12)
    file = tmp_path / "file.toml"
    file.write_bytes(content.encode(errors="surrogateescape"))
    called = call("programme import P07 keyboard", file, *WHY)
    assert (called.code, called.out) == (2, "")
    assert says in called.err
    assert newest(data).version == 1


def test_a_programme_is_read_from_standard_input(
    call: Call, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO('task = "keyboard"\n[parameters]\nattempts = 4\n'))
    assert call("programme import P07 keyboard -", *WHY, "--new").code == 0
    assert newest(data).parameters == {"attempts": 4}


def test_a_new_parameter_is_exported_and_listed_without_further_changes(
    keyboard: type[Task],
) -> None:
    class More(keyboard.Parameters, frozen=True, kw_only=True):  # type: ignore[name-defined, misc]
        tempo: Annotated[int, meta("Tempo", "beats", "How fast the drum beats.", ge=1, le=9)] = 3

    class Drummed(keyboard):  # type: ignore[valid-type, misc]
        Parameters = More

    exported = write(Drummed, "P07", Programme({"tempo": 5}, version=1))
    assert (
        "# Tempo (beats). How fast the drum beats. Allowed: 1 to 9. Default: 3.\ntempo = 5\n"
        in exported
    )
    assert parse(exported, "it").parameters == {"tempo": 5}


@examples(40)
@given(st.text(), st.text(), st.lists(st.text()), st.floats(allow_nan=False, allow_infinity=False))
def test_every_programme_that_is_written_is_read_the_same(
    keyboard: type[Task], reason: str, language: str, levels: list[str], threshold: float
) -> None:
    values = {"language": language, "levels": levels, "threshold": threshold, "no\nmore": reason}
    text = write(keyboard, "P07", Programme(values, "calm", 3, "2026", reason, reason))
    there = parse(text, "it")
    del values["no\nmore"]
    assert there.parameters == values
    assert (there.participant, there.version, there.theme, there.reason) == (
        "P07",
        3,
        "calm",
        reason,
    )


# --- presets


@pytest.mark.parametrize("task", ["keyboard", "pairs", "reaching"])
def test_each_task_ships_presets_that_fit_and_set_the_same_settings(
    catalogue: Catalogue, tmp_path: Path, task: str
) -> None:
    kind = catalogue.task(task)
    found = {name: read(path) for name, path in files(tmp_path, kind).items()}
    assert list(found) == ["mild", "moderate", "severe"]
    assert len({frozenset(preset.parameters) for preset in found.values()}) == 1
    assert not any(not_applied(kind, preset) for preset in found.values())
    built = [build(kind.Parameters, preset.parameters) for preset in found.values()]
    assert all(preset.task == task and preset.summary for preset in found.values())
    goals = [parameters.threshold for parameters in built]
    assert goals == sorted(set(goals))


def test_a_preset_states_the_exercise_and_leaves_what_is_the_persons(
    call: Call, data: Path
) -> None:
    save(data, 0, choice_set="left hand", attempts=3, feedback_every=4, minutes_a_day=20)
    assert call("programme import P07 keyboard --preset severe", *WHY).code == 0
    severe = newest(data).parameters
    assert (severe["choice_set"], severe["attempts"], severe["threshold"]) == (
        "left hand",
        6,
        3000.0,
    )
    assert call("programme import P07 keyboard --preset mild", *WHY).code == 0
    assert newest(data).parameters == {
        "choice_set": "left hand",
        "minutes_a_day": 20,
        "practice_attempts": 1,
    }
    unknown = call("programme import P07 keyboard --preset light", *WHY)
    assert unknown.err == "The task keyboard has no preset light. It has: mild, moderate, severe.\n"


def own_preset(data: Path, name: str, text: str) -> None:
    folder = data / "presets" / "keyboard"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.toml").write_text(f'task = "keyboard"\n{text}')


def test_nothing_is_left_of_the_preset_before(call: Call, data: Path) -> None:
    """Whichever two follow each other, and whatever they name."""
    own_preset(
        data,
        "slow",
        '[parameters]\nfeedback_every = 3\nlevels = ["fj", "dfjk"]\noperator_feedback = "veto"',
    )
    own_preset(data, "quick", "[parameters]\nthreshold = 700.0")
    assert call("programme import P07 keyboard --preset quick", *WHY, "--new").code == 0
    alone = newest(data).parameters
    assert alone == {"threshold": 700.0}
    for before in ("slow", "severe", "mild"):
        assert call("programme import P07 keyboard --preset", before, *WHY).code == 0
        assert call("programme import P07 keyboard --preset quick", *WHY).code == 0
        assert newest(data).parameters == alone


def test_what_a_preset_names_of_the_person_stays_and_is_told(call: Call, data: Path) -> None:
    save(data, 0, choice_set="left hand", language="es")
    own_preset(
        data,
        "mine",
        'theme = "playful"\n[parameters]\nchoice_set = "right hand"\nlanguage = "en"\nattempts = 7',
    )
    called = call("programme import P07 keyboard --preset mine", *WHY)
    assert (
        called.err
        == "! The preset also names what belongs to the person or the place, and stays: Keys, "
        "Language.\n"
    )
    assert newest(data).parameters == {"choice_set": "left hand", "language": "es", "attempts": 7}
    assert newest(data).theme == "calm"


@pytest.mark.parametrize("task", Catalogue().task_names())
def test_the_scope_of_a_preset_is_each_setting_but_the_persons(
    catalogue: Catalogue, task: str
) -> None:
    """A new setting is the exercise's unless it is declared as personal: those are listed here, and
    in the docs.
    """
    kind = catalogue.task(task)
    personal = {field.name for field in fields(kind.Parameters) if field.personal}
    common = {
        "language",
        "outputs",
        "speech",
        "operator_joins",
        "ask_wellbeing",
        "pain_limit",
        "pain_rise",
    }
    limits = {field.name for field in fields(kind.Parameters) if field.group == "Limits"}
    own = {
        "imu",
        "imu_b",
        "imu_trunk",
        "hand",
        "hand_b",
        "layout",
        "choice_set",
        "marker_distances_cm",
        "respond_with",
    }
    assert common | limits <= personal <= common | limits | own
    assert own & {field.name for field in fields(kind.Parameters)} <= personal
    changed = {field.name: "another" for field in fields(kind.Parameters)}
    after = applied(kind, ProgrammeFile(task), changed)
    assert {name for name, value in after.items() if value == "another"} == personal


def test_a_programme_is_kept_as_a_preset_of_ones_own(call: Call, data: Path) -> None:
    save(data, 0, choice_set="left hand", attempts=3)
    assert call("programme export P07 keyboard --preset left-arm").code == 0
    kind = Catalogue().task("keyboard")
    kept = find(data, kind, "left-arm")
    assert kept.parameters.keys() == {
        field.name for field in fields(kind.Parameters) if not field.personal
    }
    assert (kept.participant, kept.theme) == ("", "")
    assert call("programme export P07 keyboard --preset ../x").code == 2
    names = [row["name"] for row in call("programme presets keyboard --json").json["presets"]]
    assert names == ["mild", "moderate", "severe", "left-arm"]
    assert call("programme import P08 keyboard --preset left-arm", *WHY, "--new").code == 0
    (row,) = call("programme show P08 --json").json["programmes"]
    assert row["parameters"] == {"attempts": 3}


def test_a_preset_that_cannot_be_read_is_listed_with_the_reason(call: Call, data: Path) -> None:
    folder = data / "presets" / "keyboard"
    folder.mkdir(parents=True)
    (folder / "mine.toml").write_text("attempts 3")
    called = call("programme presets keyboard")
    assert called.code == 0
    assert "mild" in called.out
    assert "is not valid TOML" in called.out


# --- the record


def test_a_session_is_stored_with_all_its_settings_and_none_of_the_session_before(
    data: Path, catalogue: Catalogue
) -> None:
    save(data, 0, prompts_per_attempt=2, feedback_every=2, attempts=1)
    kind = catalogue.task("keyboard")
    conditions: list[dict[str, Any]] = [
        {"feedback_schedule": "faded", "feedback_fade": 5, "start_level": 3, "start_from": "fixed"},
        {"threshold": 700.0},
        {},
    ]
    for condition in conditions:
        plan = make_plan(catalogue, kind, ["P07"], condition, saved=newest(data), mode="simulated")
        session = simulate(plan, PEOPLE["poor"], data, catalogue)
        with closing(connect(data)) as database:
            stored = sessions.find(database, data, session)["parameters"]
        assert stored.keys() == {field.name for field in fields(kind.Parameters)}
        programme = {"prompts_per_attempt": 2, "feedback_every": 2, "attempts": 1}
        assert changed(build(kind.Parameters, stored)) == {**programme, **condition}

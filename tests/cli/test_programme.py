"""``sar-tui programme``: shows, exports, imports programmes, and lists their versions and
presets.
"""

import io
import json
import tomllib
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.cli.common import print_json
from sar_tui.loop.task import Task
from sar_tui.model.language import Sentence
from sar_tui.plugins import Catalogue
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
from tests.edit import edit
from tests.examples import examples
from tests.program import Call

WHY = ("--reason", "Reached the goal", "--author", "ana")


def save(
    data: Path, after: int, author: str = "ana", reason: str = "Start", **parameters: Any
) -> None:
    who = {"after": after, "author": author, "reason": reason}
    with closing(connect(data)) as database:
        participants.add(database, "P07")
        programmes.save(database, "P07", "keyboard", Programme(parameters), **who)


def newest(data: Path) -> Programme:
    with closing(connect(data)) as database:
        return programmes.newest(database, "P07", "keyboard")


# --- shown


def test_a_programme_and_its_history_tell_who_changed_what_and_why(call: Call, data: Path) -> None:
    save(data, 0, attempts=12, threshold=900.0)
    save(data, 1, "ben", "Tired after eight", attempts=8)
    (first,) = call("programme show P07 --version 1 keyboard --json").json["programmes"]
    assert first["parameters"] == {"attempts": 12, "threshold": 900.0}
    assert [first[name] for name in ("participant", "version", "author")] == ["P07", 1, "ana"]
    words = " ".join(call("programme show p07").out.split())
    for part in ("P07, Keyboard reaction: version 2", "by ben", "Attempts 8 20 attempts"):
        assert part in words
    out = call("programme history P07").out
    newer, older = (line for line in out.splitlines() if "Attempts" in line)
    assert all(part in newer for part in ("by ben", "Attempts 12 → 8", "Tired after eight"))
    assert "Attempts 20 → 12" in older
    rows = call("programme history P07 --json").json["versions"]
    assert [row["version"] for row in rows] == [2, 1]
    change = rows[0]["changes"][0]
    assert [change[name] for name in ("name", "before", "after")] == ["attempts", 12, 8]


def test_a_session_shows_the_version_that_it_ran_and_a_programme_what_cannot_be_used(
    call: Call, data: Path, simulated: str
) -> None:
    with closing(connect(data)) as database:
        participants.add(database, "P07")
    for command in ("show", "history"):
        call("programme", command, "P07").shows("P07 has no programme yet")
    call("programme show P07 keyboard").shows("its defaults are used")
    save(data, 0, attempts=12, tempo=3)
    with closing(connect(data)) as database:
        database.execute("UPDATE seats SET participant='P07'")
        database.execute("UPDATE sessions SET programme=1")
    call("show last").shows("Programme    version 1 by ana: Start")
    assert call("show last --json").json["session"]["programme"] == 1
    why = "The setting tempo does not exist any more."
    call("programme show P07").shows(f"! Not used: {why}")
    (row,) = call("programme show P07 --json").json["programmes"]
    assert row["left_out"] == {"tempo": why}
    assert call("programme history P07").code == 0
    assert call("programme export P07 keyboard").code == 0


# --- files


def test_an_exported_programme_names_every_setting_and_is_imported_for_another(
    call: Call,
    data: Path,
    tmp_path: Path,
    keyboard: type[Task],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    settings = {"attempts": 12, "levels": ["fj", "dfjk"], "choice_set": "left hand"}
    save(data, 0, **settings)
    text = call("programme export P07 keyboard").out
    for field in fields(keyboard.Parameters):
        assert f"\n{field.name} = " in text or f"\n# {field.name} = " in text
    assert " Allowed: 1 to 200. Default: 20.\n# prompts_per_attempt = 20\n" in text
    assert tomllib.loads(text)["parameters"] == settings
    file = tmp_path / "p07.toml"
    assert [call("programme export P07 keyboard --to", file).code for _ in range(2)] == [0, 2]
    imported = call("programme import p08 keyboard", file, *WHY, "--new")
    imported.shows("Saved version 1 of the programme of P08")
    (row,) = call("programme show P08 --json").json["programmes"]
    assert (row["parameters"], row["reason"]) == (settings, "Reached the goal")
    call("programme import p08 keyboard", file, *WHY).shows("Nothing differs from version 1")
    monkeypatch.setattr("sys.stdin", io.StringIO('task = "keyboard"\n[parameters]\nattempts = 4\n'))
    assert call("programme import P07 keyboard -", "--anyway", *WHY).code == 0
    assert newest(data).parameters == {"attempts": 4}


def test_a_file_exported_before_another_change_is_refused_unless_it_is_meant(
    call: Call, data: Path, tmp_path: Path
) -> None:
    save(data, 0, attempts=12)
    file = tmp_path / "p07.toml"
    call("programme export P07 keyboard --to", file)
    save(data, 1, "ben", "Tired", attempts=8)
    edit(file, "attempts = 12", "attempts = 15")
    refused = call("programme import P07 keyboard", file, *WHY)
    refused.refused("changed meanwhile: version 2 (ben: Tired). Nothing was saved.")
    assert newest(data).parameters == {"attempts": 8}
    assert call("programme import P07 keyboard", file, "--anyway", *WHY).code == 0
    assert (newest(data).version, newest(data).parameters) == (3, {"attempts": 15})


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ('task = "keyboard"\n[parameters]\nattempts = 0', "Attempts is a whole number, 1 to 200, not 0."),
        ('task = "keyboard"\n[parameters]\nattemps = 3', "There is no parameter attemps. Did you mean attempts?"),
        ('task = "keyboard"\n[parameters]\nlanguage = "fr"', "has no phrases in fr"),
        ('task = "keyboard"\ntheme = "gone"', "There is no theme gone."),
        ('task = "keyboard"\nattempts = 3', "unknown entries: attempts. Settings belong under [parameters]."),
        ('task = "reaching"', "This programme is for the task reaching, not keyboard."),
        ("attempts 3", "is not valid TOML"),
        ("", "is not a programme"),
        ("\udcff", "is not a text in UTF-8"),
    ],
)  # fmt: skip
def test_a_file_that_does_not_fit_is_refused_with_the_reason(
    call: Call, data: Path, tmp_path: Path, content: str, says: str
) -> None:
    save(data, 0, attempts=12)
    file = tmp_path / "file.toml"
    file.write_bytes(f"{content}\n".encode(errors="surrogateescape"))
    call("programme import P07 keyboard", file, *WHY).refused(says)
    assert newest(data).version == 1


@examples(20)
@given(st.text(), st.text(), st.lists(st.text()), st.floats(allow_nan=False, allow_infinity=False))
def test_every_programme_that_is_written_is_read_the_same(
    keyboard: type[Task], reason: str, language: str, levels: list[str], threshold: float
) -> None:
    values = {"language": language, "levels": levels, "threshold": threshold}
    given = Programme({**values, "no\nmore": reason}, "calm", 3, "2026", reason, reason)
    there = parse(write(keyboard, "P07", given), "it")
    assert (there.parameters, there.participant) == (values, "P07")
    assert (there.version, there.theme, there.reason) == (3, "calm", reason)


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
    assert all(preset.task == task and preset.summary for preset in found.values())
    built = [build(kind.Parameters, preset.parameters) for preset in found.values()]
    goals = [parameters.threshold for parameters in built]
    assert goals == sorted(set(goals))


def test_the_scope_of_a_preset_is_each_setting_but_the_persons(catalogue: Catalogue) -> None:
    """A new setting is the exercise's unless it is declared as personal: those are listed here, and
    in the docs.
    """
    everybodys = set(
        (
            "language outputs speech operator_joins instructions ask_wellbeing pain_limit pain_rise"
            " read_aloud switch scan_interval_ms bounce_ms system_keys added_delay_ms"
        ).split()
    )
    own = (
        "imu imu_b imu_trunk hand hand_b layout choice_set marker_distances_cm respond_with "
        "least_turn_deg"
    )
    for kind in map(catalogue.task, catalogue.task_names()):
        declared = fields(kind.Parameters)
        names = {field.name for field in declared}
        limits = {field.name for field in declared if field.group == "Limits"}
        personal = {field.name for field in declared if field.personal}
        assert personal == everybodys | limits | set(own.split()) & names, kind.name
        after = applied(kind, ProgrammeFile(kind.name), dict.fromkeys(names, "another"))
        assert {name for name, value in after.items() if value == "another"} == personal


def own_preset(data: Path, name: str, text: str) -> None:
    folder = data / "presets" / "keyboard"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.toml").write_text(f'task = "keyboard"\n{text}')


def test_a_preset_leaves_what_is_the_persons_and_nothing_of_the_preset_before(
    call: Call, data: Path
) -> None:
    """Whichever two follow each other, and whatever they name."""
    settings = 'feedback_every = 3\nlevels = ["fj", "dfjk"]\noperator_feedback = "veto"'
    own_preset(data, "slow", f"[parameters]\n{settings}")
    own_preset(data, "quick", "[parameters]\nthreshold = 700.0")
    kept = {"choice_set": "left hand", "minutes_a_day": 20}
    save(data, 0, attempts=3, feedback_every=4, **kept)
    quick = {"threshold": 700.0}
    for name, sets in (
        ("quick", quick),
        ("slow", {"feedback_every": 3}),
        ("quick", quick),
        ("severe", {"attempts": 6, "threshold": 3000.0}),
        ("quick", quick),
        ("mild", {"practice_attempts": 1}),
    ):
        assert call("programme import P07 keyboard --preset", name, *WHY).code == 0
        found = newest(data).parameters
        assert (kept | sets).items() <= found.items()
        assert (found == kept | quick) is (name == "quick")
    assert found == {**kept, "practice_attempts": 1}


def test_what_a_preset_names_of_the_person_stays_and_is_told(call: Call, data: Path) -> None:
    save(data, 0, choice_set="left hand", language="es")
    settings = 'choice_set = "right hand"\nlanguage = "en"\nattempts = 7'
    own_preset(data, "mine", f'theme = "playful"\n[parameters]\n{settings}')
    said = call("programme import P07 keyboard --preset mine", *WHY).err
    assert said.startswith("! The preset also names what belongs to the person")
    assert said.endswith("and stays: Keys, Language.\n")
    assert newest(data).parameters == {"choice_set": "left hand", "language": "es", "attempts": 7}
    assert newest(data).theme == "calm"


def test_a_programme_is_kept_as_a_preset_of_ones_own(call: Call, data: Path) -> None:
    save(data, 0, choice_set="left hand", attempts=3)
    assert call("programme export P07 keyboard --preset left-arm").code == 0
    kind = Catalogue().task("keyboard")
    kept = find(data, kind, "left-arm")
    exercise = {field.name for field in fields(kind.Parameters) if not field.personal}
    assert (kept.parameters.keys(), kept.participant, kept.theme) == (exercise, "", "")
    assert call("programme export P07 keyboard --preset ../x").code == 2
    names = [row["name"] for row in call("programme presets keyboard --json").json["presets"]]
    assert names == ["mild", "moderate", "severe", "left-arm"]
    assert call("programme import P08 keyboard --preset left-arm", *WHY, "--new").code == 0
    (row,) = call("programme show P08 --json").json["programmes"]
    assert row["parameters"] == {"attempts": 3}
    own_preset(data, "mine", "attempts 3")
    call("programme presets keyboard").shows("mild", "is not valid TOML")


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


@pytest.mark.parametrize("more", [{}, {"file": "\udcff"}])
def test_the_reason_of_a_setting_is_a_plain_text_in_json(
    more: dict[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    print_json({"why": Sentence("It is {n}.", n=1), **more})
    assert json.loads(capsys.readouterr().out)["why"] == "It is 1."

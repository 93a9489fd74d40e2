"""``sar-tui study``: commands that it prints can be typed, and it says why it stops."""

import io
import os
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import msgspec
import pytest

from sar_tui.cli import live, study
from sar_tui.cli.study_words import changes
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store.database import connect
from sar_tui.study import next_block
from tests.played import catalogue
from tests.program import Call
from tests.study.plans import TWO_GROUPS, WITH_FORMS, plan, written

CONSENT = TWO_GROUPS.replace("[outcome]", '[consent]\nversion = "2"\n\n[outcome]')


def named(name: str, text: str = TWO_GROUPS) -> str:
    """Return a plan of another study."""
    return text.replace('name = "praise"', f'name = "{name}"', 1)


@pytest.fixture(autouse=True)
def keys(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep the keys of studies in a folder of the test."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "configuration"))


def enrol(call: Call, tmp_path: Path, text: str = TWO_GROUPS, new: str = "--new") -> str:
    """Freeze a plan, enrol P01, and return what was printed."""
    called = call("study enrol P01", new, "--plan", written(tmp_path, text))
    assert called.code == 0, called
    return called.out


@pytest.fixture
def played(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Let a block be simulated, and end with a status."""

    def prepare(status: str, then: Callable[[], object] = lambda: None) -> None:
        def begin(home: Any, one: Any, found: Any, reason: str, how: Any) -> int:
            with closing(connect(home.folder)) as db:
                session = next_block.plan_of(db, catalogue(), one, found, seed=1)
                simulated = msgspec.structs.replace(session, mode="simulated")
                simulate(simulated, PEOPLE["average"], home.folder, catalogue())
                db.execute("UPDATE sessions SET mode='live', status=?", (status,))
            then()
            return 0

        monkeypatch.setattr(live, "showing", lambda *given, **more: live.Showing())
        monkeypatch.setattr(study, "_begin", begin)

    return prepare


def test_with_several_studies_commands_name_the_study(call: Call, tmp_path: Path) -> None:
    alone = enrol(call, tmp_path, CONSENT)
    assert "\n  sar-tui study consent P01 --answer yes\n" in alone
    assert "\n  sar-tui study next P01\n" in alone
    printed = enrol(call, tmp_path, named("other", CONSENT), new="--key=" + str(tmp_path / "k"))
    assert "\n  sar-tui study consent P01 --answer yes --study other\n" in printed
    assert "\n  sar-tui study next P01 --study other\n" in printed
    call("study next P01").refused("There are several studies: praise, other. Name one: --study")
    command = "sar-tui study enrol P02 --new --study other"
    assert f"\n  {command}\n" in call("study next P02 --study other").err
    call("report study --study other --key", tmp_path / "k").shows("Flow of participants")
    call("report methods --study other").shows("# Methods")


def test_the_data_folder_is_in_commands(call: Call, tmp_path: Path) -> None:
    folder = tmp_path / "elsewhere"
    called = call("study enrol P01 --new --data", folder, "--plan", written(tmp_path))
    assert f"\n  sar-tui study next P01 --data {folder}\n" in called.out


def test_consent_is_asked_for_before_a_terminal(call: Call, tmp_path: Path) -> None:
    enrol(call, tmp_path, CONSENT)
    called = call("study next P01")
    called.refused("P01 has not agreed to the study praise yet.")
    assert called.err.endswith("\n  sar-tui study consent P01 --answer yes\n")
    call("study consent P01 --answer yes").shows("P01 agreed to")
    call("study next P01").refused("This needs a real terminal")


def test_next_keeps_its_study_when_another_one_is_frozen(
    call: Call, tmp_path: Path, played: Callable[..., None]
) -> None:
    enrol(call, tmp_path)
    other = tmp_path / "other"
    other.mkdir()

    def freeze() -> None:
        from sar_tui.study import enrolment

        text = named("other")
        with closing(connect(Path(os.environ["SAR_TUI_DATA"]))) as db:
            enrolment.freeze(
                db, catalogue(), text, plan(text), other / "key", mode="live", author="me"
            )

    played("completed", freeze)
    called = call("study next P01 --once")
    assert (called.code, called.err) == (0, "Visit first, block baseline\n"), called
    assert called.out.splitlines() == [
        "P01: the visit first has 2 blocks to do today.",
        "  sar-tui study next P01 --study praise",
    ]


@pytest.mark.parametrize(
    ("status", "why", "left"),
    [
        ("aborted", "was ended early. It counts as done: nothing more is begun.", "2 blocks"),
        ("interrupted", "was interrupted: it goes on where it was.", "3 blocks"),
    ],
)
def test_next_says_why_it_stops(
    call: Call, tmp_path: Path, played: Callable[..., None], status: str, why: str, left: str
) -> None:
    enrol(call, tmp_path)
    played(status)
    said, then, *command = call("study next P01").out.splitlines()
    assert said == f"The block baseline {why}"
    assert then == f"P01: the visit first has {left} to do today."
    assert command == ([] if status == "interrupted" else ["  sar-tui study next P01"])


def test_a_visit_that_the_plan_does_not_have_is_told_with_those_it_has(
    call: Call, tmp_path: Path
) -> None:
    enrol(call, tmp_path)
    call("study next P01 --visit third").refused("There is no visit third.", "first, second.")
    call("study next P01 --visit first --block nap").refused(
        "There is no block nap in the visit first. There are: first/baseline, first/speeds."
    )


def test_an_amendment_says_what_it_changes(call: Call, tmp_path: Path) -> None:
    enrol(call, tmp_path)
    changed = (
        TWO_GROUPS.replace('name = "praise"', 'name = "praise"\nversion = 2', 1)
        .replace("threshold = 800", "threshold = 700")
        .replace("attempts = 3\nlevel = 3", "attempts = 4\nlevel = 3")
        .replace("window = [2, 2]", "window = [1, 2]")
        .replace("with praise.", "when praised.")
    )
    called = call("study amend --reason shorter", written(tmp_path, changed))
    called.shows(
        "  changed: condition fast (settings)\n",
        "  changed: visit second (window)\n",
        "  changed: visit first, block baseline (attempts)\n",
        "  changed: hypothesis\n",
        "People who were enrolled before keep their group and their order.",
    )
    more = WITH_FORMS.replace("[conditions.fast]", "[conditions.fastest]").replace(
        '"fast"]', '"fastest"]'
    )
    assert set(changes(plan(), plan(more))) == {
        "new: condition fastest",
        "gone: condition fast",
        "changed: visit first, block speeds (conditions)",
        "new: visit first, block strain",
        "new: visit second, block usability",
    }


def test_a_new_plan_asks_again_until_it_can_be_used(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    answers = "My Study\nmine\nkeybord\nkeyboard\na\na b\nn\n3 4\n0 7\n"
    monkeypatch.setattr(sys, "stdin", io.StringIO(answers))
    file = tmp_path / "new.toml"
    called = call("study new --to", file)
    assert called.code == 0, called
    assert "A name begins with a letter" in called.err
    assert "There is no task keybord." in called.err
    assert "Tasks: flanker," in called.err
    checked = call("study check", file)
    checked.shows("version 1 of the study mine is fine.")
    assert "!" not in checked.out
    call("study new --name A --to", tmp_path / "other.toml").refused("A name begins with a letter")


def test_a_rehearsal_lists_forms_in_the_order_of_the_plan(call: Call, tmp_path: Path) -> None:
    file = written(tmp_path, WITH_FORMS.replace('sites = ["BERN", "GENF"]\n', ""))
    called = call("study rehearse --people 2 --to", tmp_path / "rehearsal", file)
    assert called.code == 0, called
    rows = [line.split() for line in called.out.splitlines()[2:]]
    blocks = [row[1] for row in rows if row[0] in ("first", "second")]
    assert [*dict.fromkeys(blocks)] == ["baseline", "speeds", "strain", "training", "usability"]
    assert ["second", "usability", "form", "SUS", "2", "–", "–"] in rows


def test_status_explains_its_sign(call: Call, tmp_path: Path) -> None:
    enrol(call, tmp_path)
    assert "!" not in call("study status").out
    call("study deviation P01 --visit first --reason noise").shows("It is recorded")
    call("study status").shows("! differs from the plan. How, and why:\n  sar-tui report study\n")

"""Published studies as plans, from what their abstracts and registrations say of the method.

"A comparison of learning modes using a serial reaction time task", Rigakuryoho Kagaku 2021,
36:837, doi:10.1589/rika.36.837: 32 people in an implicit and an explicit group; blocks of 12 trials,
five of practice and two of retention; the explicit group was told of the fixed sequence, in one
trial before practice.

"Effects of positive social comparative feedback on motor sequence learning and performance
expectancies", Frontiers in Psychology 2023, 13:1005705, doi:10.3389/fpsyg.2022.1005705, registered
as NCT04270448: a sequence task with no feedback, with response times, or with response times and the
word that they are better than others'; three groups allocated at random, 48 people; practice on one
day, retention about 24 hours later; perceived competence is asked before and after practice, and at
retention.
"""

import re
import shutil
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.records import kind
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from sar_tui.store.database import connect
from sar_tui.study import ledger
from sar_tui.study.conditions import problems_here
from sar_tui.study.rehearsal import rehearse
from tests.study.plans import plan

LEARNING_MODES = """
name = "learning-modes"
title = "Implicit and explicit learning of a sequence"
hypothesis = "Instruction on the fixed sequence makes reaction times in it shorter."
people = 32

[outcome]
visit = "day"
block = "retention"
compared = "groups"

[groups.implicit]
condition = "untold"
[groups.explicit]
condition = "told"

[conditions.untold]
task = "srtt"
settings = { prompts_per_attempt = 12, random_every = 2 }
[conditions.told]
task = "srtt"
settings = { prompts_per_attempt = 12, random_every = 2 }
instructions = "In some rounds the square moves in an order that repeats: 1 2 1 3 4 2 3 1 4 3 2 4."

[[visits]]
name = "day"
[[visits.blocks]]
name = "practice"
condition = "as allocated"
attempts = 5
practice = 1
[[visits.blocks]]
name = "retention"
condition = "as allocated"
purpose = "retention"
attempts = 2
"""


def test_a_published_study_can_be_planned_and_rehearsed(tmp_path: Path) -> None:
    study = plan(LEARNING_MODES)
    assert not [*problems_here(study, Catalogue(()))]
    start = datetime(2026, 3, 2, tzinfo=UTC)
    (site,) = rehearse(
        study,
        LEARNING_MODES,
        Catalogue(()),
        tmp_path,
        tmp_path / "k.key",
        people=4,
        seed=1,
        start=start,
    )
    with closing(connect(site.folder)) as db:
        frozen = ledger.find(db)
        played = ledger.played(db, "learning-modes", frozen.mode)
        assert len(played) == 8
        for one in played:
            row = sessions.stored(db, one.id)
            assert row
            attempts = sessions.rows(db, "attempts", one.id)
            wanted = {"practice": (1, 5), "retention": (0, 2)}[one.block]
            practice = sum(each["practice"] for each in attempts)
            assert (practice, len(attempts) - practice) == wanted
            is_silent = one.block == "retention"
            assert (row["parameters"]["feedback_schedule"] == "none") is is_silent
            (asked,) = db.execute(
                "SELECT count(*) FROM messages JOIN session_numbers ON number=session_number"
                " WHERE id=? AND message LIKE '%order that repeats%'",
                (one.id,),
            ).fetchone()
            assert bool(asked) is (one.condition == "told")


FEEDBACK = """
name = "comparison"
hypothesis = "Positive social comparison supports the learning of a sequence."
people = 48

[outcome]
visit = "retention"
block = "test"
compared = "groups"

[groups.control]
condition = "nothing"
[groups.times]
condition = "response-time"
[groups.positive]
condition = "better-than-others"

[conditions.nothing]
task = "srtt"
settings = { feedback_schedule = "none", encouragement = false }
[conditions.response-time]
task = "srtt"
settings = { feedback_form = "quantitative" }
[conditions.better-than-others]
task = "srtt"
theme = "comparing"
settings = { feedback_form = "both" }

[[visits]]
name = "practice"
[[visits.blocks]]
name = "before"
form = "competence"
[[visits.blocks]]
name = "training"
condition = "as allocated"
attempts = 5
[[visits.blocks]]
name = "after"
form = "competence"

[[visits]]
name = "retention"
day = 1
[[visits.blocks]]
name = "again"
form = "competence"
[[visits.blocks]]
name = "test"
condition = "as allocated"
purpose = "retention"
attempts = 2
"""
COMPETENCE = """
name = "competence"
title = "How well will you do?"
entered_by = "participant"
[form]
[[fields]]
name = "sure"
title = "How sure are you that you are good at this?"
type = "integer"
lowest = 1
highest = 7
labels = ["not at all", "very"]
"""
BETTER = "You are faster than most people."


def test_a_study_of_three_kinds_of_feedback_on_two_days(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "kinds").mkdir()
    (tmp_path / "kinds" / "competence.toml").write_text(COMPETENCE)
    monkeypatch.setattr(kind, "own_folder", lambda: tmp_path / "kinds")
    kind._read_folder.cache_clear()
    theme = tmp_path / "themes" / "comparing"
    shutil.copytree(Catalogue().theme_folder("calm"), theme)
    phrases = (theme / "phrases.en.toml").read_text()
    for degree in ("positive_slight", "positive", "positive_strong"):
        phrases = re.sub(rf"(?ms)^{degree} = \[.*?^\]", f'{degree} = ["{BETTER}"]', phrases)
    (theme / "phrases.en.toml").write_text(phrases)
    catalogue = Catalogue(themes=(tmp_path / "themes",))

    study = plan(FEEDBACK)
    assert not [*problems_here(study, catalogue)]
    (tmp_path / "k.key").write_text("5a" * 32)
    (site,) = rehearse(
        study, FEEDBACK, catalogue, tmp_path, tmp_path / "k.key", people=6, seed=1,
        start=datetime(2026, 3, 2, tzinfo=UTC), persons=lambda _: PEOPLE["average"],
    )  # fmt: skip
    with closing(connect(site.folder)) as db:
        frozen = ledger.find(db)
        told = set()
        for one in ledger.played(db, "comparison", frozen.mode):
            said = [str(each["final"]) for each in sessions.rows(db, "actions", one.id)]
            if one.condition:
                told.add((one.visit, one.condition, any(BETTER in each for each in said)))
        asked = db.execute("SELECT count(*) FROM records WHERE kind='competence'").fetchone()
    conditions = ["better-than-others", "nothing", "response-time"]
    practice = {("practice", name, name == conditions[0]) for name in conditions}
    assert told == practice | {("retention", name, False) for name in conditions}
    assert asked == (18,)

"""A published study as a plan, from what its abstract says of the method.

"A comparison of learning modes using a serial reaction time task", Rigakuryoho Kagaku 2021,
36:837, doi:10.1589/rika.36.837: 32 people in an implicit and an explicit group; blocks of 12 trials,
five of practice and two of retention; the explicit group was told of the fixed sequence, in one
trial before practice.
"""

from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path

from sar_tui.plugins import Catalogue
from sar_tui.store import sessions
from sar_tui.store.database import connect
from sar_tui.study import ledger
from sar_tui.study.conditions import problems_here
from sar_tui.study.rehearsal import rehearse
from tests.study.plans import plan

PLAN = """
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
    study = plan(PLAN)
    assert not [*problems_here(study, Catalogue(()))]
    start = datetime(2026, 3, 2, tzinfo=UTC)
    (site,) = rehearse(
        study, PLAN, Catalogue(()), tmp_path, tmp_path / "k.key", people=4, seed=1, start=start
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

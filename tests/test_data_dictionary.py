"""The data dictionary names all that is stored: each column, each topic, each field of a choice,
each parameter.
"""

import json
import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import get_args

import pytest
from sqlite_utils import Database

from sar_tui.loop.task import Task
from sar_tui.model import messages
from sar_tui.model.messages import FeedbackChoice
from sar_tui.plugins import Catalogue
from sar_tui.rules import feedback
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.operator import PROFILES
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store.database import connect
from sar_tui.validation.adaptation import average
from sar_tui.validation.feedback import competent, examples, frequency
from sar_tui.validation.modularity import added_parts
from sar_tui.validation.report import Conditions, Report
from sar_tui.validation.table_4_1 import simulated_velocity
from tests import data_dictionary

PAGE = data_dictionary.PAGE.read_text(encoding="utf-8")

pytestmark = pytest.mark.usefixtures("simulated_once")


def named(text: str) -> set[str]:
    """Return the words of a text that are marked as code."""
    return set(re.findall(r"`([^`\n]+)`", text))


def section(table: str) -> str:
    return PAGE.partition(f"### {table}\n")[2].partition("\n### ")[0].partition("\n## ")[0]


def test_the_tables_are_those_that_are_declared(catalogue: Catalogue) -> None:
    made = data_dictionary.with_tables(PAGE, data_dictionary.tables(catalogue))
    if os.environ.get("SAR_TUI_UPDATE_SNAPSHOTS"):
        data_dictionary.PAGE.write_text(made, encoding="utf-8")
    else:
        assert made == PAGE, "write it anew with SAR_TUI_UPDATE_SNAPSHOTS=1"


@pytest.mark.parametrize(
    ("table", "names"),
    [
        ("attempts", {*FeedbackChoice.__struct_fields__, *feedback.INCLUDED}),
        ("actions", {*get_args(messages.Kind), *get_args(messages.Policy), "accepted", "dropped"}),
        ("actions", set(messages.Proposal.__struct_fields__)),
        ("events", {*get_args(messages.PartState), *get_args(messages.ActionPart)}),
    ],
)
def test_fields_kinds_and_states_are_documented_with_their_table(
    table: str, names: set[str]
) -> None:
    assert names - named(section(table)) == set()


@pytest.mark.parametrize(
    ("name", "validate"),
    [
        ("figure-4.4", average),
        ("figure-4.8", simulated_velocity),
        ("figure-4.12", competent),
        ("figure-4.13", examples),
        ("figure-4.14", frequency),
        ("figure-4.15", added_parts),
    ],
)
def test_every_field_of_a_validation_is_documented(
    name: str,
    validate: Callable[[Conditions], Report],
    catalogue: Catalogue,
) -> None:
    fields = set(validate(Conditions(catalogue, seeds=range(1, 2))).rows[0])
    lines = [
        line for line in PAGE.splitlines() if line.startswith((f"- `{name}`", "- `figure-4.11`"))
    ]
    assert fields - set().union(*map(named, lines)) == set()


def test_the_documented_query_lists_each_decision_with_the_time_of_day(
    data: Path, keyboard: type[Task], catalogue: Catalogue
) -> None:
    plan = make_plan(catalogue, keyboard, ["SIM"], {"attempts": 2}, seed=3, mode="simulated")
    simulate(plan, PEOPLE["average"], data, catalogue, operator=PROFILES["careful"])
    query = re.search(r"```sql\n(.*?)```", PAGE.partition("## Examples")[2], re.DOTALL)
    assert query
    database = connect(data)
    (count, first) = database.execute("SELECT count(*), min(decided_ns) FROM actions").fetchone()
    anchor = json.dumps(
        {"clock_ns": first - 1_500_000_000, "utc": "2026-03-01T23:59:59.250000+00:00"}
    )
    # a simulated session has a clock of its own
    database.execute("UPDATE runs SET clock_anchor=?", (anchor,))
    rows = list(Database(database).query(query[1]))
    database.close()
    assert len(rows) == count
    assert rows[0]["decided_utc"] == "2026-03-02 00:00:00.750"
    assert {"feedback", "greeting"} <= {row["kind"] for row in rows}

"""Every stored column says what becomes of it when data leaves, and columns that name people,
devices and places never leave.
"""

from pathlib import Path

import pytest

from sar_tui.export.columns import stored
from sar_tui.model.messages import FeedbackChoice
from sar_tui.model.messages.loop import Timing
from sar_tui.store.tables import TABLES
from tests.export.exported import csv_of


@pytest.mark.parametrize(
    "source",
    [
        "imu_streams.serial",
        "imu_streams.source",
        "programmes.author",
        "actions.actor",
        "runs.boot_id",
    ],
)
def test_a_column_that_must_not_leave_cannot_be_put_into_a_table(source: str) -> None:
    with pytest.raises(ValueError, match="must not leave"):
        stored(source)


def test_every_stamp_date_and_id_has_the_treatment_that_a_recoded_export_replaces() -> None:
    """A new column that is said to be open would bring the machine's clock, or a true date,
    back.
    """
    wanted = {"_ns": "clock", "_at": "time", ".session": "id", ".seed": "seed"}
    declared = {
        f"{table.name}.{column.name}": column.privacy
        for table in TABLES.values()
        for whole in table.columns
        for column in (whole, *whole.parts)
    }
    found = {
        source: treatment
        for source, treatment in declared.items()
        for ending, right in wanted.items()
        if source.endswith(ending) and treatment not in (right, "inner")
    }
    assert found == {}


def test_every_field_of_timing_and_choice_has_a_column(simulated: str, data: Path) -> None:
    (trial, *_), (attempt, *_) = csv_of(data, "trials"), csv_of(data, "attempts")
    assert set(Timing.__struct_fields__) - set(trial) == set()
    assert {f"choice_{name}" for name in FeedbackChoice.__struct_fields__} - set(attempt) == set()

"""Every stored column has a treatment, and columns that name people, devices and places never
leave.
"""

from pathlib import Path

import pytest
from sqlite_utils import Database

from sar_tui.export.columns import stored
from sar_tui.export.inventory import SOURCES
from sar_tui.store.database import connect


def test_every_column_of_the_database_is_in_the_inventory(data: Path) -> None:
    database = connect(data)
    tables = [
        table for table in Database(database).tables if not table.name.startswith(("sqlite_", "_"))
    ]
    present = {f"{table.name}.{column}" for table in tables for column in table.columns_dict}
    database.close()
    assert present - set(SOURCES) == set(), (
        "say in sar_tui/export/inventory.py what becomes of a new column"
    )


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
        stored(source, "string", "A test.")


def test_every_stamp_date_and_id_has_the_treatment_that_a_recoded_export_replaces() -> None:
    """A new column that is said to be open would bring the machine's clock, or a true date,
    back.
    """
    wanted = {"_ns": "clock", "_at": "time", ".session": "id", ".seed": "seed"}
    found = {
        source: treatment
        for source, treatment in SOURCES.items()
        for ending, right in wanted.items()
        if source.endswith(ending) and treatment not in (right, "inner")
    }
    assert found == {}

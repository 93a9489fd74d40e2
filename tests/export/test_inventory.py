"""Every stored column says what becomes of it when data leaves, and columns that name people,
devices and places never leave.
"""

import pytest

from sar_tui.export.columns import stored
from sar_tui.store.tables import TABLES


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
